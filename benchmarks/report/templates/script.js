"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const names = (column) => (i) => data[column].names[data[column].codes[i]];
  const numbers = (column) => (i) => data[column][i];
  const columns = [
    ["Task", names("task")], ["Agent", names("agent")], ["Case", numbers("index")], ["Repeat", numbers("repeat")],
    ["Seed", numbers("seed")], ["Ended in", names("ending")], ["Complete %", numbers("complete")], ["Steps", numbers("steps")],
    ["Return", numbers("return")], ["Seconds", numbers("seconds")], ["ms per act", numbers("act")],
  ].filter(([title]) => title !== "Repeat" || data.repeat.some(Boolean));
  const SIZE = 50;
  const form = document.getElementById("filters");
  const head = document.querySelector("#table thead tr");
  const body = document.querySelector("#table tbody");
  const [back, forth] = document.querySelectorAll("#pager button");
  let rows = [], page = 0, sorted = null, descending = false;

  const cell = (kind, text, name) => {
    const element = document.createElement(kind);
    element.textContent = text;
    if (name) element.className = name;
    return element;
  };

  function extras(i) {
    const found = [];
    if (data.video[i] >= 0) {
      const link = cell("a", " \u25b6 video");
      link.href = `#video-${data.video[i]}`;
      link.addEventListener("click", () => reveal(data.video[i]));
      found.push(link);
    }
    const message = data.message.names[data.message.codes[i]];
    if (message) found.push(cell("small", message));
    return found;
  }

  function show() {
    const pages = Math.max(1, Math.ceil(rows.length / SIZE));
    body.replaceChildren(...rows.slice(page * SIZE, (page + 1) * SIZE).map((i) => {
      const line = document.createElement("tr");
      for (const [title, value] of columns) {
        const content = value(i);
        const element = cell("td", content, typeof content === "number" ? "number" : "text");
        if (title === "Ended in") element.append(...extras(i));
        line.append(element);
      }
      return line;
    }));
    document.getElementById("found").textContent = `${rows.length} of ${data.seed.length} episodes`;
    document.querySelector("#pager span").textContent = `page ${page + 1} of ${pages}`;
    back.disabled = page === 0;
    forth.disabled = page + 1 >= pages;
  }

  function filter() {
    const chosen = ["task", "agent", "ending"].map((name) => [data[name].codes, Number(form.elements[name].value)]);
    const text = form.elements.text.value.trim().toLowerCase();
    const speaks = data.message.names.map((message) => message.toLowerCase().includes(text));
    rows = [];
    for (let i = 0; i < data.seed.length; i++) {
      if (!chosen.every(([codes, code]) => code < 0 || codes[i] === code)) continue;
      if (text && !speaks[data.message.codes[i]] && !String(data.seed[i]).includes(text)) continue;
      rows.push(i);
    }
    if (sorted !== null) {
      const value = columns[sorted][1];
      const order = (a, b) => (typeof a === "number" ? a - b : a < b ? -1 : a > b ? 1 : 0);
      rows.sort((i, j) => (descending ? order(value(j), value(i)) : order(value(i), value(j))));
    }
    page = 0;
    show();
  }

  function sortBy(column) {
    descending = sorted === column && !descending;
    sorted = column;
    [...head.children].forEach((title, i) => {
      if (i === sorted) title.setAttribute("aria-sort", descending ? "descending" : "ascending");
      else title.removeAttribute("aria-sort");
    });
    filter();
  }

  function turn(step) {
    page += step;
    show();
  }

  function load(figure) {
    const film = figure.querySelector("video");
    if (!film.src) film.src = `data:video/mp4;base64,${film.dataset.film}`;
  }

  function reveal(number) {
    const figure = document.getElementById(`video-${number}`);
    figure.hidden = false;
    load(figure);
  }

  function choose(button) {
    for (const other of document.querySelectorAll("#choice button")) other.setAttribute("aria-pressed", other === button);
    for (const figure of document.querySelectorAll(".films figure")) {
      const { first, failure } = figure.dataset;
      figure.hidden = !(button.value === "all" || (button.value === "first" ? first : failure) === "true");
      if (!figure.hidden) load(figure);
    }
  }

  for (const name of ["task", "agent", "ending"]) {
    form.elements[name].append(new Option("all", -1), ...data[name].names.map((text, i) => new Option(text, i)));
  }
  columns.forEach(([title, value], i) => {
    const first = data.seed.length ? value(0) : "";
    const element = cell("th", title, typeof first === "number" ? "number" : "");
    element.tabIndex = 0;
    element.addEventListener("click", () => sortBy(i));
    element.addEventListener("keydown", (event) => { if (event.key === "Enter") sortBy(i); });
    head.append(element);
  });
  form.addEventListener("input", filter);
  form.addEventListener("submit", (event) => event.preventDefault());
  back.addEventListener("click", () => turn(-1));
  forth.addEventListener("click", () => turn(1));
  for (const button of document.querySelectorAll("#choice button")) button.addEventListener("click", () => choose(button));
  document.querySelectorAll(".films figure:not([hidden])").forEach(load);
  filter();
})();
