"""Markdown and LaTeX."""

import re
from pathlib import Path

from markdown_it import MarkdownIt

from benchmarks.report.collected import collect
from benchmarks.report.text import to_latex, to_markdown
from tests.bench.making import make_row, make_rows, save

EVIL = r"<b>a|b_c*d`e[f](g)\ & 100% #1 $x^2$ ~{}"


def test_markdown_is_a_table_with_verdicts(tmp_path: Path) -> None:
    rows = make_rows("a", [True] * 6) + make_rows("b", [False] * 6)
    text = to_markdown(collect([save(tmp_path, rows)]))
    assert "### E-v0\n" in text
    rate = r"100.0 \[61, 100\]"
    assert f"| a | observations | 6/6 {rate} | {rate} | 22 | 100.0 | 0 |  |" in text
    assert "- a / b, 6 common episodes: a better (p = 0.031)" in text


def test_several_tasks_are_shown_at_a_glance(tmp_path: Path) -> None:
    one = save(tmp_path / "one", make_rows("a", [True] * 6))
    other = save(tmp_path / "other", make_rows("b", [False] * 6, env="F-v0"))
    text = to_markdown(collect([one, other]))
    assert "| agent | E-v0 | F-v0 |\n| --- | ---: | ---: |\n" in text
    assert "| a | 6/6 100.0 \\[61, 100\\] |  |\n" in text
    assert "| b |  | 0/6 0.0 \\[0, 39\\] |\n" in text
    assert "glance" not in to_markdown(collect([one]))


def test_names_stay_text_in_markdown(tmp_path: Path) -> None:
    folder = save(tmp_path, [make_row(agent=EVIL), make_row(agent="b", status="error", message="")])
    html = MarkdownIt("commonmark").enable("table").render(to_markdown(collect([folder])))
    assert html.count("<tr>") == 3
    assert "<b>" not in html
    assert "<em>" not in html
    shown = EVIL.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    assert f"<td>{shown}</td>" in html


def test_latex_is_balanced_and_escaped(tmp_path: Path) -> None:
    text = to_latex(collect([save(tmp_path, [make_row(agent=EVIL, env="A_B-v0")])]))
    assert text.count(r"\begin{") == text.count(r"\end{") == 2
    assert r"A\_B-v0" in text
    body = next(line for line in text.splitlines() if "100\\%" in line)
    assert len(re.findall(r"(?<!\\)&", body)) == 7
    assert not re.search(r"(?<!\\)[%#_$]", body)
    assert r"\textbackslash{} \& 100\% \#1 \$x\textasciicircum{}2\$ \textasciitilde{}\{\}" in body


def test_papers_numbers_are_in_the_last_column(tmp_path: Path) -> None:
    folder = save(tmp_path, make_rows("icd", [True], env="ICDCableRouting-v0"))
    assert to_markdown(collect([folder])).count("| 90 / 95 |") == 1
    assert "90 / 95 \\\\" in to_latex(collect([folder]))


def test_papers_numbers_stand_beside_its_settings_too(tmp_path: Path) -> None:
    folder = save(tmp_path, make_rows("icd-paper", [True], env="ICDCableRouting-v0"))
    assert to_markdown(collect([folder])).count("| 90 / 95 |") == 1


def test_no_rows_are_n_a(tmp_path: Path) -> None:
    collected = collect([save(tmp_path, [])])
    assert "| a | observations | 0/0 n/a | n/a | n/a | n/a | 0 |" in to_markdown(collected)
    assert "a & observations & 0/0 n/a & n/a" in to_latex(collected)
