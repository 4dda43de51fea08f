"""Tables of the documentation hold what the published rows say."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from statistics import fmean

from benchmarks.manifest import FILE_NAME as MANIFEST_NAME
from benchmarks.report.collected import collect
from benchmarks.report.paper import method_of, paper_of
from benchmarks.rows import Row
from benchmarks.statistics import paired_p, wilson
from benchmarks.suites import CABLE, CABLE_ADAPTATION, NOTEBOOK, NOTEBOOK_ADAPTATION

ROOT = Path(__file__).parents[2]
PUBLISHED = ROOT / "benchmarks" / "published"
README = (ROOT / "README.md").read_text(encoding="utf-8")
BASELINES = (ROOT / "docs" / "baselines.md").read_text(encoding="utf-8")
METHOD = (ROOT / "docs" / "method.md").read_text(encoding="utf-8")

Key = tuple[str, str, str]
TASKS = {
    "cable": (CABLE, "default"),
    "cable, adaptation": (CABLE_ADAPTATION, "default"),
    "cable, contact goals": (CABLE, "contact goals"),
    "cable, adaptation, contact goals": (CABLE_ADAPTATION, "contact goals"),
    "notebook": (NOTEBOOK, "default"),
    "notebook, adaptation": (NOTEBOOK_ADAPTATION, "default"),
}
CASES = 20


def table(page: str, corner: str) -> list[dict[str, str]]:
    """Lines of the table whose first heading begins like this, by heading."""
    start = page.index(f"\n| {corner}")
    lines = page[start + 1 :].partition("\n\n")[0].splitlines()
    heading, _, *body = [[cell.strip() for cell in line[1:-1].split("|")] for line in lines]
    return [dict(zip(heading, cells, strict=True)) for cells in body]


def rows_in(folders: Sequence[Path]) -> dict[Key, list[Row]]:
    """Rows by agent and task, in the order of their cases, as a report joins them."""
    found: dict[Key, list[Row]] = {}
    for row in sorted(collect(folders).rows, key=lambda row: row.index):
        assert row.status == "ok"
        found.setdefault((row.agent, row.env, row.condition), []).append(row)
    return found


def matching(*patterns: str) -> list[Path]:
    """Published folders, at least one of each pattern."""
    found = [sorted(PUBLISHED.glob(pattern)) for pattern in patterns]
    assert all(found), patterns
    return [folder for folders in found for folder in folders]


def of_the_readme() -> list[Path]:
    """Folders of the README's own report, expanded as a shell does."""
    (command,) = re.findall(r"^icd-bench report (.*?) --markdown", README, re.M | re.S)
    patterns = []
    for word in command.replace("\\\n", " ").split():
        parts = re.fullmatch(r"benchmarks/published/(.*)\{(.*)\}(.*)", word)
        assert parts is not None, word
        patterns += [f"{parts[1]}{name}{parts[3]}" for name in parts[2].split(",")]
    return matching(*patterns)


def won_of(rows: Sequence[Row]) -> tuple[int, int]:
    """Successes and episodes."""
    return sum(row.success for row in rows), len(rows)


def rate(rows: Sequence[Row], unit: str = "") -> str:
    won, n = won_of(rows)
    interval = wilson(won, n)
    assert interval is not None
    return f"{won}/{n} ({100 * interval.low:.0f}-{100 * interval.high:.0f}{unit})"


def code(text: str) -> str:
    """What stands in backticks first."""
    found = re.search(r"`(.+?)`", text)
    assert found is not None, text
    return found[1]


def test_readme_results_are_those_of_its_own_report() -> None:
    rows = rows_in(of_the_readme())
    lines = [line for line in table(README, "successes in 20") if "`" in next(iter(line.values()))]
    agents = set()
    for line in lines:
        name, *cells = line.values()
        agents.add(code(name))
        for task, cell in zip(TASKS.values(), cells, strict=True):
            found = rows.get((code(name), *task), [])
            assert cell == (rate(found) if found else ""), (name, task)
    assert list(lines[0])[1:] == list(TASKS)
    assert {agent for agent, *_ in rows} == agents | {"expert"}


def test_readme_results_by_chance_and_of_the_paper() -> None:
    rows = rows_in(matching("gates-*/rows/expert-routes-all"))
    by_name = {next(iter(line.values())): line for line in table(README, "successes in 20")}
    chance = by_name["by chance: every clip passed, whatever the goal"]
    for name, task in TASKS.items():
        found = rows.get(("expert-routes-all", *task), [])[:CASES]
        assert chance[name] == (rate(found) if found else "")
        paper = paper_of(*task).get("icd")
        text = f"{paper.successes}/{paper.runs}" if paper else ""
        assert by_name["the paper's ICD"][name] == text


def test_readme_gates_are_those_of_their_rows() -> None:
    agents = ("expert-clean", "pc-mppi", "ladder:transferred-points")
    for line in table(README, "id | task"):
        env_id, _, gates = line.values()
        rows = rows_in(matching(f"gates-{code(env_id)}/rows/*"))
        counts = [won_of(rows.get((agent, code(env_id), "default"), [])) for agent in agents]
        assert gates == ", ".join(f"{won}/{n}" if n else "-" for won, n in counts)


def renamed(rows: dict[Key, list[Row]]) -> dict[Key, list[Row]]:
    """Rows of ICD in the local field, made when it was called ``icd``, by its present name."""
    return {("icd-local", env, condition): found for (_, env, condition), found in rows.items()}


def against(rows: Sequence[Row], icd: Sequence[Row]) -> str:
    """Scenes that only ICD solves, those that only the other does, and McNemar's test."""
    assert [row.seed for row in rows] == [row.seed for row in icd]
    pairs = [(ours.success, row.success) for ours, row in zip(icd, rows, strict=True)]
    p = paired_p(*zip(*pairs, strict=True), [row.seed for row in icd])
    text = f"{p:.2g}" if p >= 1e-4 else f"{p:.0e}".replace("e-0", "e-")
    return f"{pairs.count((True, False))} : {pairs.count((False, True))}, p = {text}"


def steps(rows: Sequence[Row]) -> str:
    """Mean steps of successes; contact goals are judged at the end of the budget."""
    won = [row.steps for row in rows if row.success]
    if rows[0].condition == "contact goals":
        assert {row.steps for row in rows} == {300}
        return "all 300"
    return f"{fmean(won):.0f}" if won else ""


def test_baselines_are_measured_as_their_rows_say() -> None:
    more = matching("*-paper-*", "gates-*/rows/ladder-transferred-points")
    rows = rows_in([*of_the_readme(), *more]) | renamed(rows_in(matching("icd-local-*")))
    contact = {"contact goals": CABLE, "contact goals, adaptation": CABLE_ADAPTATION}
    shown = set()
    for line in table(BASELINES, "20 test scenes | agent"):
        scenes, name, success, complete, paper, taken, compared = line.values()
        agent = code(name)
        task = (contact[scenes], "contact goals") if scenes in contact else (scenes, "default")
        found = rows[agent, *task]
        assert success == rate(found, " %"), line
        assert complete == f"{100 * fmean(row.complete for row in found):g} %", line
        assert paper == paper_text(method_of(agent), *task), line
        assert taken == steps(found), line
        assert compared == ("" if agent == "icd" else against(found, rows["icd", *task])), line
        shown.add((agent, *task))
    assert {key for key in rows if key[0] not in ("random", "expert")} == shown


def test_a_hundred_other_scenes_are_as_their_rows_say() -> None:
    rows = rows_in(matching("paired-*"))
    agents = set()
    for line in table(METHOD, "100 scenes"):
        name, success, complete, taken, paper, compared = line.values()
        agents.add(code(name))
        found = rows[code(name), CABLE, "default"]
        assert len(found) == len({row.seed for row in found}) == 100, name
        assert success == rate(found, " %"), name
        assert complete.startswith(f"{100 * fmean(row.complete for row in found):g} % ("), name
        assert taken == steps(found), name
        assert paper == paper_text(code(name), CABLE, "default"), name
        icd = rows["icd", CABLE, "default"]
        assert compared == ("" if code(name) == "icd" else against(found, icd)), name
    assert {agent for agent, *_ in rows} == agents


def paper_text(agent: str, env: str, condition: str) -> str:
    result = paper_of(env, condition).get(agent)
    if result is None:
        return ""
    complete = "" if result.complete is None else f" / {100 * result.complete:g}"
    return f"{100 * result.success:g}{complete}"


def test_rungs_of_the_ladder_are_as_high_as_their_rows_say() -> None:
    others = ("local-", "icd-local-", "paired-", "two-fields-", "quick", "dp3-temperature-")
    folders = matching("*-*", "gates-*/rows/ladder-*")
    folders = [folder for folder in folders if not folder.name.startswith(others)]
    rungs = rows_in([folder for folder in folders if (folder / MANIFEST_NAME).exists()])
    local = rows_in(matching("local-*"))
    three = [f"ladder:{name}" for name in ("places", "far-field", "near-field")]
    compared = 0
    for line in table(METHOD, "rung"):
        rung, *cells = line.values()
        first, *more = re.findall(r"`(\S+)`", rung)
        names, rows = [first, *(first.rpartition("-")[0] + end for end in more)], rungs
        if rung.startswith("the same three"):
            names, rows = three, local
        elif names == ["icd-local"]:
            icd = {key: found for key, found in rungs.items() if key[0] == "icd"}
            rows = renamed(icd) | renamed(rows_in(matching("icd-local-*")))  # the same elsewhere
        for heading, cell in zip(list(line)[1:], cells, strict=True):
            task = TASKS[heading.replace(" adaptation", ", adaptation")]
            found = [rows.get((name, *task)) for name in names]
            texts = [str(won_of(ran)[0]) if ran else "-" for ran in found]
            assert cell == (" / ".join(texts) if any(found) else ""), (rung, heading)
            compared += any(ran is not None for ran in found)
    assert compared > 40
