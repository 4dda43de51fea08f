"""Pairs of agents: only on common episodes, and never "better" without the test."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binomtest

from benchmarks.report.comparisons import LEVEL, compare, compare_all, compare_with
from tests.bench.making import make_row, make_rows


def test_only_common_finished_episodes_count() -> None:
    first = make_rows("a", [True, True, True, False])
    second = [
        *make_rows("b", [False, True]),
        replace(first[2], agent="b", status="error", complete=0.0, message="boom"),
        make_row(agent="b", index=9, seed=999, success=True, complete=1.0),
    ]
    pair = compare("a", "b", first, second)
    assert (pair.common, pair.first_only, pair.second_only) == (2, 1, 0)
    assert (pair.success_difference, pair.complete_difference, pair.p) == (0.5, 0.5, 1.0)


def test_nothing_in_common_is_said_and_does_not_crash() -> None:
    pairs = compare_all({"a": make_rows("a", [True]), "b": [], "c": [make_row(seed=7)]})
    assert [pair.verdict for pair in pairs] == ["no common episodes"] * 3
    assert {pair.p for pair in pairs} == {None}
    assert compare_all({}) == compare_all({"a": []}) == []


def test_many_wins_are_better_and_few_are_not() -> None:
    worse, same, better = [False] * 12, [True] + [False] * 11, [True] * 9 + [False] * 3
    outcomes = {"w": worse, "s": same, "b": better}
    rows = {name: make_rows(name, won) for name, won in outcomes.items()}
    verdicts = {(c.first, c.second): c.verdict for c in compare_all(rows)}
    assert verdicts["w", "s"] == "no difference shown (p = 1.000)"
    assert verdicts["w", "b"] == "b better (p = 0.012)"  # 3 x 2 / 2^9
    assert verdicts["s", "b"] == "b better (p = 0.016)"  # 2 x 2 / 2^8


def test_correction_can_take_a_verdict_away() -> None:
    rows = {"a": make_rows("a", [True] * 6), "b": make_rows("b", [False] * 6)}
    assert compare_all(rows)[0].verdict == "a better (p = 0.031)"
    more = {**rows, "c": make_rows("c", [True] * 6)}
    assert {c.verdict for c in compare_all(more)} == {
        "no difference shown (p = 0.094)",
        "no difference shown (p = 1.000)",
    }


@settings(deadline=None)
@given(st.lists(st.tuples(st.booleans(), st.booleans()), max_size=30))
def test_better_is_said_exactly_where_mcnemar_says_so(pairs: list[tuple[bool, bool]]) -> None:
    first, second = ([pair[i] for pair in pairs] for i in range(2))
    found = compare("a", "b", make_rows("a", first), make_rows("b", second))
    wins, losses = pairs.count((True, False)), pairs.count((False, True))
    assert (found.first_only, found.second_only) == (wins, losses)
    p = binomtest(wins, wins + losses).pvalue if wins + losses else 1.0
    if not pairs:
        assert found.verdict == "no common episodes"
    elif p >= LEVEL:
        assert found.verdict.startswith("no difference shown")
    else:
        assert found.verdict.startswith("a better" if wins > losses else "b better")


def test_repeats_are_paired_by_scene_and_repeat() -> None:
    def rows(agent: str, *won: bool) -> list[object]:
        return [
            make_row(agent=agent, index=i % 2, seed=i % 2, repeat=i // 2, success=w, complete=0.0)
            for i, w in enumerate(won)
        ]

    pair = compare("a", "b", rows("a", True, True, False, True), rows("b", False, True, True, True))
    assert (pair.common, pair.first_only, pair.second_only) == (4, 1, 1)
    assert pair.p == pytest.approx(1.0)


def test_reference_is_the_second_of_every_pair_and_correction_counts_these_only() -> None:
    rows = {
        "default": make_rows("a", [True] * 6),
        "x": make_rows("a", [False] * 6),
        "y": make_rows("a", [True] * 6),
    }
    x, y = compare_with("default", rows)
    assert (x.first, x.second, x.success_difference) == ("x", "default", -1.0)
    assert x.p == pytest.approx(2 / 2**6)
    assert x.corrected_p == pytest.approx(2 * 2 / 2**6)
    assert y.verdict == "no difference shown (p = 1.000)"
