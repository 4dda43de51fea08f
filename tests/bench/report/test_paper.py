"""The paper's numbers, against what is known of its protocol."""

import pytest

from benchmarks.report.paper import method_of, paper_of, paper_results
from benchmarks.report.summaries import summarise
from icd_envs.registration import ENV_IDS
from tests.bench.making import make_rows


def test_every_number_is_a_count_of_20_runs() -> None:
    assert len(paper_results()) == 16
    for result in paper_results():
        assert result.env in ENV_IDS
        assert result.successes == pytest.approx(result.success * result.runs)
        if result.complete is not None:  # of two clips
            assert 2 * result.complete * result.runs == pytest.approx(
                round(2 * result.complete * result.runs)
            )
            assert result.complete >= result.success


def test_interval_of_the_papers_best_is_the_known_one() -> None:
    icd = paper_of("ICDCableRouting-v0")["icd"]
    assert (icd.success, icd.complete) == (0.9, 0.95)
    assert icd.success_ci == pytest.approx((0.70, 0.97), abs=5e-3)


def test_conditions_and_other_tasks_are_not_in_the_paper() -> None:
    assert paper_of("ICDCableRouting-v0", "action noise") == {}
    assert paper_of("ICDNotebookFoldingAdaptation-v0") == {}
    assert set(paper_of("icd_envs:ICDCableRoutingAdaptation-v0")) == {"icd", "subgoal-diffuser"}


@pytest.mark.parametrize(
    ("agent", "method"),
    [
        ("icd", "icd"),
        ("icd-paper", "icd"),
        ("ndf-mppi-improved", "ndf-mppi"),
        ("icd-local", "icd-local"),
        ("my-paper-agent", "my-paper-agent"),
    ],
)
def test_the_papers_numbers_stand_beside_every_way_to_run_its_method(
    agent: str, method: str
) -> None:
    assert method_of(agent) == method


def test_p_against_the_paper_is_fishers() -> None:
    subgoals = paper_of("ICDCableRouting-v0")["subgoal-diffuser"]
    ours = summarise("a", "E-v0", "default", make_rows("a", [True] * 18 + [False] * 2))
    assert subgoals.p_against(ours) == pytest.approx(0.127, abs=5e-4)
    assert subgoals.p_against(summarise("a", "E-v0", "default", [])) is None
