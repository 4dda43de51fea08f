"""No version of an environment changes silently."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from icd_envs import ENV_IDS
from tests.contracts.golden import FOLDER, UNIT, record, record_variant, tolerance, variants

ADVICE = (
    "{env_id} no longer does what it did ({where}, seed {seed}, {moment}: up to {most:.2e} away). "
    "If this was meant, results of before and after cannot be compared: register it under the next "
    "-vN, add a line to its version history and record that id with "
    "`python -m tests.contracts.golden NEW_ID`. Never record an old id anew."
)
VARIANTS = [(env_id, name) for env_id in ENV_IDS for name in variants(env_id)]


def read(name: str, env_id: str) -> dict[str, Any]:
    path = FOLDER / f"{name}.json"
    assert path.exists(), f"record it once: python -m tests.contracts.golden {env_id}"
    return json.loads(path.read_text(encoding="utf-8"))


def compare(found: dict[str, Any], golden: dict[str, Any], env_id: str, where: str) -> None:
    assert found.keys() == golden.keys()
    for seed, moments in golden.items():
        assert found[seed].keys() == moments.keys()
        for moment, points in moments.items():
            assert np.shape(found[seed][moment]) == np.shape(points)
            most = int(np.abs(np.subtract(found[seed][moment], points)).max())
            assert most <= tolerance(moment), ADVICE.format(
                env_id=env_id, where=where, seed=seed, moment=moment, most=most * UNIT
            )


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_environment_does_what_its_version_has_always_done(env_id: str) -> None:
    compare(record(env_id), read(env_id, env_id), env_id, "as it is")


@pytest.mark.parametrize(("env_id", "name"), VARIANTS)
def test_options_do_what_they_have_always_done(env_id: str, name: str) -> None:
    golden = read(f"{env_id}-options", env_id)
    assert golden.keys() == variants(env_id).keys()
    compare(record_variant(env_id, name), golden[name], env_id, name)
