"""Parts that commands are given: kept where an agent finds them, refused early if they misfit."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.parts import chain_parts, check_places, keep_beside, local_field, part
from icd_agent.checkpoints import save_checkpoint, weights_sha256
from icd_agent.diffusion.config import DiffusionConfig
from icd_agent.diffusion.denoiser import Denoiser
from icd_agent.field.train import load_field
from icd_agent.weights import LOCAL_FIELD, SUBGOAL_DIFFUSER, shipped_chains, shipped_folder
from icd_envs.errors import CheckpointError
from tests.agent.field.small import SMALL, small_field
from tests.bench.making import icd_bench

NOTEBOOK = "ICDNotebookFolding-v0"
PLACES = shipped_folder(NOTEBOOK, SUBGOAL_DIFFUSER) / "latent"


def test_what_is_given_is_taken_and_else_what_the_package_has() -> None:
    given = Path("anywhere")
    assert part("MyTask-v0", "field", given) == local_field("MyTask-v0", given) == given
    assert part(NOTEBOOK, "field", None) == shipped_chains(NOTEBOOK, "field")
    assert chain_parts(NOTEBOOK, None, None).latent == shipped_chains(NOTEBOOK, "latent")
    for find in (lambda: part("MyTask-v0", "field", None), lambda: local_field("MyTask-v0", None)):
        with pytest.raises(CheckpointError, match="environment with shipped weights"):
            find()


@pytest.mark.parametrize(
    ("command", "name"),
    [
        (("train", "diffusion", "--data", "d", "--out", "o"), "--latent"),
        (("train", "bank", "--data", "d", "--out", "o"), "--latent"),
        (("diagnose", "latent"), "--weights"),
        (("diagnose", "diffusion"), "--latent"),
    ],
)
def test_latents_of_places_are_refused_where_those_of_descriptors_are_wanted(
    command: tuple[str, ...], name: str
) -> None:
    refused = icd_bench(*command, "--env", NOTEBOOK, name, PLACES)
    assert refused.exit_code == 2
    assert "takes 3 numbers a point, but the field in" in refused.stderr
    assert len(refused.stderr.strip().splitlines()) == 1


def test_chains_of_a_single_scene_are_not_diagnosed() -> None:
    refused = icd_bench("diagnose", "diffusion", "--env", NOTEBOOK, "--scenes", 1)
    assert refused.exit_code == 2
    assert "scenes=1 cannot be used: give at least 2" in refused.stderr


def test_a_denoiser_without_places_is_refused() -> None:
    config = DiffusionConfig(8, 8, 20, 4, places=0, width=8, layers=1, heads=1)
    with pytest.raises(CheckpointError, match="places=0"):
        check_places(Denoiser(config))


def test_a_field_is_kept_beside_what_was_trained_with_it(tmp_path: Path) -> None:
    field, out = tmp_path / "mine", tmp_path / "out"
    save_checkpoint(field, "field", small_field(), SMALL, {"terms": {}}, half=True)
    keep_beside(None, out)
    assert not out.exists()
    for given in (field, out / "field"):  # its own copy, too
        keep_beside(given, out)
        assert weights_sha256(out / "field") == weights_sha256(field)
    load_field(out / "field")


def test_a_policy_that_sees_points_takes_no_field(tmp_path: Path) -> None:
    field = shipped_folder(NOTEBOOK, LOCAL_FIELD)
    given = ("--data", tmp_path, "--out", tmp_path / "out", "--field", field)
    refused = icd_bench("train", "dp3", "--env", NOTEBOOK, *given)
    assert refused.exit_code == 2
    assert "dp3 sees points" in refused.stderr
