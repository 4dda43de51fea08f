"""No version of an environment changes silently."""

from __future__ import annotations

import json

import numpy as np
import pytest

from icd_envs import ENV_IDS
from tests.contracts.golden import EXACT, FOLDER, LOOSE, UNIT, record

ADVICE = (
    "{env_id} no longer does what it did (seed {seed}, {moment}: up to {most:.2e} m away). If this "
    "was meant, results of before and after cannot be compared: register it under the next -vN, "
    "add a line to its version history and record that id with "
    "`python -m tests.contracts.golden NEW_ID`. Never record an old id anew."
)


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_environment_does_what_its_version_has_always_done(env_id: str) -> None:
    path = FOLDER / f"{env_id}.json"
    assert path.exists(), f"record it once: python -m tests.contracts.golden {env_id}"
    golden, found = json.loads(path.read_text(encoding="utf-8")), record(env_id)
    assert found.keys() == golden.keys()
    for seed, moments in golden.items():
        assert found[seed].keys() == moments.keys()
        for moment, points in moments.items():
            assert np.shape(found[seed][moment]) == np.shape(points)
            most = int(np.abs(np.subtract(found[seed][moment], points)).max())
            message = ADVICE.format(env_id=env_id, seed=seed, moment=moment, most=most * UNIT)
            assert most <= (LOOSE if moment == "goal" else EXACT), message
