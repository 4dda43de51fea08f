"""Without OpenGL everything works but pictures, for every environment."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from icd_envs import ENV_IDS
from icd_envs.rendering import FIX
from tests.envs.making import digest, make, play, random_actions

ROOT = Path(__file__).parents[2]
LIBRARIES = ("EGL", "GL", "GLESv2", "GLX", "OSMesa", "OpenGL")

SCRIPT = """
import json, sys, warnings
from icd_envs import ENV_IDS
from icd_envs.errors import RenderingUnavailableError
from tests.envs.making import digest, make, play, random_actions

def physics(env):
    return digest([env.reset(seed=0)[0], *play(env, random_actions(0, 5))])

found = {}
for env_id in ENV_IDS:
    env = make(env_id, obs_mode="partial", render_mode="rgb_array", width=64, height=48)
    seen = physics(env)
    simulator = env.episode(simulator=True).simulator
    rollout = simulator.rollout(env.snapshot(), random_actions(1, 2, 3))
    assert not rollout.diverged.any()
    try:
        answer = str(env.render().shape)
    except RenderingUnavailableError as error:
        answer = str(error)
    assert env.step([0.0, 0.0, 0.0])[4]["diverged"] is False
    env.close()
    found[env_id] = [seen, answer]
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def expected() -> dict[str, str]:
    """What is observed here."""
    found = {}
    for env_id in ENV_IDS:
        env = make(env_id, obs_mode="partial")
        found[env_id] = digest([env.reset(seed=0)[0], *play(env, random_actions(0, 5))])
        env.close()
    return found


@pytest.fixture(scope="module")
def broken(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of libraries that hide the system's and do not load."""
    folder = tmp_path_factory.mktemp("libraries")
    for name in LIBRARIES:
        for version in ("", *(f".{i}" for i in range(10))):
            (folder / f"lib{name}.so{version}").touch()
    return folder


def environment(backend: str | None, libraries: Path | None) -> dict[str, str]:
    """Variables of a process without a display."""
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "MUJOCO_GL", "PYOPENGL_PLATFORM")
    variables = {name: value for name, value in os.environ.items() if name not in hidden}
    if backend is not None:
        variables["MUJOCO_GL"] = backend
    if libraries is not None:
        variables["LD_LIBRARY_PATH"] = str(libraries)
    return variables


@pytest.mark.parametrize(
    ("backend", "has_libraries"),
    [(None, True), ("nonsense", True), (None, False), ("egl", False)],
)
def test_physics_is_the_same_and_only_pictures_are_missing(
    expected: dict[str, str], broken: Path, backend: str | None, has_libraries: bool
) -> None:
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        cwd=ROOT,
        env=environment(backend, None if has_libraries else broken),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout.splitlines()[-1])
    assert {env_id: seen for env_id, (seen, _) in found.items()} == expected
    for _, answer in found.values():
        assert FIX in answer or (has_libraries and answer == "(48, 64, 3)")
    warned = "MUJOCO_GL" in done.stderr and "not available" in done.stderr
    assert warned == (backend is not None)


def test_benchmark_runs_without_opengl(broken: Path, tmp_path: Path) -> None:
    command = ["run", "--agent", "expert", "--episodes", "1", "--out", str(tmp_path / "out")]
    for env_id in ENV_IDS:
        command += ["--env", env_id]
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks", *command, "--json"],
        cwd=ROOT,
        env=environment("egl", broken),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    rows = json.loads(done.stdout)
    assert sorted((row["env"], row["errors"]) for row in rows) == [(i, 0) for i in sorted(ENV_IDS)]
