from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import pytest

from icd_envs import ENV_IDS
from icd_envs.errors import EpisodeStateError, IcdError, InvalidOptionError, SceneExportError
from icd_envs.export import export_glb
from tests.envs.glb import check_meshes, reloaded
from tests.envs.making import CABLE, make


@pytest.mark.parametrize("env_id", ENV_IDS)
def test_file_holds_what_the_model_holds(env_id: str, tmp_path: Path) -> None:
    env = make(env_id)
    observation, _ = env.reset(seed=0)
    oracle = env.episode(oracle=True).oracle
    assert oracle is not None
    for action in oracle.actions[:60]:
        observation, *_ = env.step(action)
    count = export_glb(env, tmp_path / "scene.glb")
    meshes = reloaded(tmp_path / "scene.glb")
    check_meshes(meshes, env.model, env.data)
    assert count == len(meshes)
    assert meshes["floor"].bounds[1, 2] == pytest.approx(0.0, abs=1e-6)
    fingertip = meshes["finger_left"].bounds[0, 2]
    assert fingertip == pytest.approx(observation["observation"][2], abs=1e-6)
    env.close()


@pytest.mark.parametrize(
    ("name", "error", "message"),
    [
        ("scene.obj", InvalidOptionError, r"must end in \.glb"),
        ("nowhere/scene.glb", SceneExportError, "folder that exists"),
    ],
)
def test_path_that_cannot_be_is_refused(
    tmp_path: Path, name: str, error: type[IcdError], message: str
) -> None:
    env = make()
    env.reset(seed=0)
    with pytest.raises(error, match=message):
        export_glb(env, tmp_path / name)
    assert list(tmp_path.iterdir()) == []
    env.close()


def test_environment_that_cannot_be_exported_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "scene.glb"
    with pytest.raises(InvalidOptionError, match="environment of this project"):
        export_glb(gym.make("CartPole-v1"), path)
    env = gym.make(CABLE)
    with pytest.raises(EpisodeStateError, match="reset"):
        export_glb(env, path)
    env.reset(seed=0)
    assert export_glb(env, path) > 0
    env.close()
    with pytest.raises(EpisodeStateError, match="close"):
        export_glb(env, path)


def test_importing_it_first_chooses_a_gl_backend_all_the_same() -> None:
    code = "import os, icd_envs.export; print(os.environ['MUJOCO_GL'])"
    environment = {name: value for name, value in os.environ.items() if name != "MUJOCO_GL"}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip()
