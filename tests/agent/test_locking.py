from __future__ import annotations

from pathlib import Path

import pytest

from icd_agent.latent.train import train_latent
from icd_agent.locking import alone
from icd_agent.training.config import TrainingConfig
from icd_envs.errors import DemonstrationsError, IcdError, TrainingError
from tests.agent.diffusion.test_diffusion import LATENT
from tests.agent.toy_states import toy_states


def test_a_second_training_in_a_folder_is_refused_until_the_first_is_done(tmp_path: Path) -> None:
    def train() -> None:
        train_latent(toy_states(3), LATENT, TrainingConfig(steps=1), tmp_path / "run", about={})

    with alone(tmp_path / "run"), pytest.raises(TrainingError, match="in use by another training"):
        train()
    train()
    assert (tmp_path / "run" / "config.json").exists()


@pytest.mark.parametrize("error", [TrainingError, DemonstrationsError])
def test_second_writer_is_refused_until_the_first_is_done(
    tmp_path: Path, error: type[IcdError]
) -> None:
    out = tmp_path / "a" / "b"
    with (
        alone(out, "run", error),
        pytest.raises(error, match="in use by another run"),
        alone(out, "run", error),
    ):
        pass
    with alone(out, "run", error):
        pass


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for out in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(TrainingError, match="choose another --out"), alone(out):
            pass
