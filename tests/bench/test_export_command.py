"""``icd-bench export-scene``."""

import json
from pathlib import Path

import numpy as np
import pytest

from icd_envs.export import export_glb
from tests.bench.making import icd_bench
from tests.envs.glb import reloaded
from tests.envs.making import CABLE, make

EXPORT = ("export-scene", "--env", CABLE, "--split", "test")


def test_file_is_the_scene_that_reset_draws(tmp_path: Path) -> None:
    written, expected = tmp_path / "späce d.glb", tmp_path / "expected.glb"
    exported = icd_bench(*EXPORT, "--seed", 3, "--out", written, "--json")
    assert exported.exit_code == 0, exported.stderr
    env = make(CABLE)
    env.reset(seed=3)
    geoms = export_glb(env, expected)
    env.close()
    assert written.read_bytes() == expected.read_bytes()
    kilobytes = written.stat().st_size / 1e3
    values = {"file": str(written), "geoms": geoms, "kilobytes": kilobytes}
    assert json.loads(exported.stdout) == values


def test_another_seed_is_another_scene_and_replaces_the_file(tmp_path: Path) -> None:
    out = tmp_path / "scene.glb"
    walls = []
    for seed in (0, 1):
        exported = icd_bench(*EXPORT, "--seed", seed, "--out", out)
        assert exported.exit_code == 0, exported.stderr
        assert "geoms" in exported.stdout
        walls.append({name: mesh.bounds for name, mesh in reloaded(out).items()})
    assert walls[0].keys() == walls[1].keys()
    assert not all(np.allclose(walls[0][name], walls[1][name]) for name in walls[0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--env", "ICDCableRoutin-v0", "--out", "a.glb"], "did you mean 'ICDCableRouting-v0'"),
        (["--env", "CartPole-v1", "--out", "a.glb"], "is a CartPoleEnv, which has no task"),
        (["--env", CABLE, "--split", "tset", "--out", "a.glb"], "did you mean 'test'"),
        (["--env", CABLE, "--seed", "-1", "--out", "a.glb"], "--seed"),
        (["--env", CABLE, "--seed", str(2**64), "--out", "a.glb"], "seed must be in"),
        (["--env", CABLE, "--out", "a.obj"], "must end in .glb"),
        (["--env", CABLE, "--out", "nowhere/a.glb"], "cannot write nowhere/a.glb"),
        (["--env", CABLE], "--out"),
    ],
)
def test_usage_errors_exit_2_and_write_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    refused = icd_bench("export-scene", *arguments)
    assert (refused.exit_code, refused.stdout) == (2, "")
    assert message in " ".join(refused.stderr.split())
    assert list(tmp_path.iterdir()) == []
