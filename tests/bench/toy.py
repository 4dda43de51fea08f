"""A point mass and agents that behave and misbehave, importable by worker processes."""

from __future__ import annotations

import ctypes
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
from filelock import FileLock

from icd_envs.api import Episode
from icd_envs.errors import InvalidActionError, RenderingUnavailableError, SceneGenerationError

ENV = "tests.bench.toy:Toy-v0"
UNSOLVABLE = "tests.bench.toy:ToyUnsolvable-v0"
CRASHING = "tests.bench.toy:ToyCrashing-v0"
NAN_RATE = "tests.bench.toy:ToyNanRate-v0"
PICTURELESS = "tests.bench.toy:ToyPictureless-v0"
BLIND = "tests.bench.toy:ToyBlind-v0"
HANGING_PICTURES = "tests.bench.toy:ToyHangingPictures-v0"
CRASHING_PICTURES = "tests.bench.toy:ToyCrashingPictures-v0"
MAX_STEPS = 12
LOCKS = "ICD_TOY_LOCKS"


class ToyEnv(gym.Env[dict[str, np.ndarray], np.ndarray]):
    """Reach the goal within 0.2; half complete when half the way is done."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}  # noqa: RUF012

    def __init__(
        self, split: str = "train", fault: str = "", render_mode: str | None = None
    ) -> None:
        """Make one with or without a fault."""
        assert split == "test", "the benchmark must run on test scenes"
        box = gym.spaces.Box(-10.0, 10.0, (3,), np.float64)
        self.observation_space = gym.spaces.Dict({"observation": box, "desired_goal": box})
        self.action_space = gym.spaces.Box(-1.0, 1.0, (3,), np.float64)
        self._fault = fault
        self.render_mode = render_mode

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        super().reset(seed=seed)
        if self._fault == "unsolvable":
            raise SceneGenerationError(f"no solvable scene for seed {seed}")
        self._position = np.zeros(3)
        self._goal = self.np_random.uniform(-2.0, 2.0, 3)
        return self._observation(), self._info()

    def step(
        self, action: np.ndarray
    ) -> tuple[dict[str, np.ndarray], float, bool, bool, dict[str, Any]]:
        if self._fault == "crashing":
            raise RuntimeError("physics on fire")
        action = np.asarray(action, dtype=float)
        if action.shape != (3,) or not np.isfinite(action).all():
            raise InvalidActionError(f"action must be (3,) and finite, got {action!r}")
        self._position = self._position + 0.5 * np.clip(action, -1.0, 1.0)
        info = self._info()
        return self._observation(), -1.0, info["is_success"], False, info

    def render(self) -> np.ndarray:
        if self._fault == "blind":
            raise RenderingUnavailableError("OpenGL did not start")
        if self._fault == "hanging pictures":
            time.sleep(60.0)
        if self._fault == "crashing pictures":
            os.kill(os.getpid(), signal.SIGSEGV)
        return np.full((32, 48, 3), 255 * bool(self._position.any()), np.uint8)

    def episode(self, simulator: bool, oracle: bool, threads: int) -> Episode:
        return Episode(
            env_id="Toy-v0",
            action_scale=0.5,
            control_period=0.05,
            max_steps=MAX_STEPS,
            canonical_cloud=np.zeros((1, 3), np.float32),
            gripper_spheres=np.zeros((1, 4), np.float32),
            simulator="simulator" if simulator else None,
            oracle="oracle" if oracle else None,
        )

    def _observation(self) -> dict[str, np.ndarray]:
        return {"observation": self._position, "desired_goal": self._goal}

    def _info(self) -> dict[str, Any]:
        left = float(np.linalg.norm(self._goal - self._position))
        done = left < 0.2
        half = left < 0.5 * float(np.linalg.norm(self._goal))
        rate = float("nan") if self._fault == "nan rate" else 1.0 if done else 0.5 * half
        return {"is_success": done, "complete_rate": rate, "diverged": False}


class PicturelessToyEnv(ToyEnv):
    """Has never heard of pictures."""

    metadata = {"render_modes": []}  # noqa: RUF012

    def __init__(self, split: str = "train", fault: str = "") -> None:
        """Make one."""
        super().__init__(split, fault)


def _register() -> None:
    ids = {ENV: "", UNSOLVABLE: "unsolvable", CRASHING: "crashing", NAN_RATE: "nan rate"}
    ids |= {
        PICTURELESS: "pictureless",
        BLIND: "blind",
        HANGING_PICTURES: "hanging pictures",
        CRASHING_PICTURES: "crashing pictures",
    }
    for env_id, fault in ids.items():
        gym.register(
            env_id.partition(":")[2],
            f"tests.bench.toy:{'PicturelessToyEnv' if fault == 'pictureless' else 'ToyEnv'}",
            max_episode_steps=MAX_STEPS,
            kwargs={"fault": fault},
        )


_register()


class Straight:
    """Goes to the goal."""

    def reset(self, episode: Episode, seed: int) -> None:
        self.episode, self.seed = episode, seed

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        return np.clip(2.0 * (observation["desired_goal"] - observation["observation"]), -1, 1)


class Drunk(Straight):
    """Goes to the goal, more or less."""

    def reset(self, episode: Episode, seed: int) -> None:
        super().reset(episode, seed)
        self._rng = np.random.default_rng(seed)

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        return super().act(observation) + self._rng.normal(0.0, 0.7, 3)


class Slow(Drunk):
    """Takes its time, and shows by a lock that its process is alive."""

    def __init__(self) -> None:
        """Take the lock, if the test gave a folder for it."""
        if LOCKS in os.environ:
            folder = Path(os.environ[LOCKS])
            folder.mkdir(exist_ok=True)
            self._alive = FileLock(folder / str(os.getpid()))
            self._alive.acquire()

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        time.sleep(0.02)
        return super().act(observation)


class Planner(Straight):
    """Asks for the simulator."""

    needs_simulator = True

    def reset(self, episode: Episode, seed: int) -> None:
        assert episode.simulator is not None
        assert episode.oracle is None
        super().reset(episode, seed)


class Chatty(Straight):
    """Prints."""

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        print("thinking")
        return super().act(observation)


class Sleeper(Slow):
    """Falls asleep."""

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        time.sleep(60.0)
        return super().act(observation)


class Vandal(Straight):
    """Writes into what it is shown."""

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        action = super().act(observation)
        for array in observation.values():
            array[:] = 1e9
        return action


class Raiser(Straight):
    """Raises in every other episode of one instance, and would stay broken after that."""

    broken = False

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        if self.broken or self.seed % 2:
            self.broken = True
            raise ZeroDivisionError("odd seeds are not for me")
        return super().act(observation)


class Quitter(Straight):
    """Leaves the program."""

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        raise SystemExit(4)


class Nan(Straight):
    """Acts with NaN."""

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        return np.full(3, np.nan)


class Flat(Straight):
    """Acts with two numbers."""

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        return np.zeros(2)


class Killer(Straight):
    """Ends its process in episodes of odd seed."""

    def end(self) -> None:
        os._exit(11)

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        if self.seed % 2:
            self.end()
        return super().act(observation)


class Killed(Killer):
    """Is killed, as the system does when memory runs out."""

    def end(self) -> None:
        os.kill(os.getpid(), signal.SIGKILL)


class Crasher(Killer):
    """Reads where nothing is."""

    def end(self) -> None:
        ctypes.string_at(0)


class Meddler(Straight):
    """Changes whatever a process has: what it prints to, its folder, variables, generators."""

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        os.chdir("/")
        os.environ.clear()
        random.seed(0)
        np.random.seed(0)  # noqa: NPY002
        np.seterr(all="raise")
        sys.stdout = sys.stderr = None
        sys.path.clear()
        gym.registry.clear()
        return np.zeros(3)


class Gambler(Straight):
    """Draws from generators that are not its own."""

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        if random.random() < 0.5:
            return np.zeros(3)
        return super().act(observation) + np.random.normal(0.0, 0.7, 3)  # noqa: NPY002


class Homebody(Straight):
    """Needs its folder and its variables."""

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        assert Path.cwd() != Path("/")
        assert os.environ["PATH"]
        return super().act(observation)


class Parent(Sleeper):
    """Starts a process that would outlive it, and leaves its id in a file of a fixed name."""

    def act(self, observation: dict[str, np.ndarray]) -> np.ndarray:
        child = subprocess.Popen(["sleep", "60"])
        Path(os.environ[LOCKS], "child").write_text(str(child.pid))
        return super().act(observation)


class Unready:
    """Lacks act."""

    def reset(self, episode: Episode, seed: int) -> None:
        pass


def make_straight() -> Straight:
    """A factory."""
    return Straight()


def spec(agent: type | str) -> str:
    """Name by which the benchmark finds an agent of this module."""
    return f"tests.bench.toy:{agent if isinstance(agent, str) else agent.__name__}"
