"""The Gymnasium environment around any task."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Generic, Literal

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.envs.registration import EnvSpec
from numpy.typing import NDArray

from icd_envs.api import (
    BoolArray,
    CommonInfo,
    Episode,
    Float32Array,
    Float64Array,
    FloatArray,
    Observation,
    PartialObservation,
    PlanView,
    SimState,
)
from icd_envs.errors import (
    EpisodeStateError,
    IncompatibleStateError,
    NoSceneError,
)
from icd_envs.geometry.sdf import BoxUnion
from icd_envs.physics.plant import check_snapshot
from icd_envs.physics.simulator import RolloutSimulator
from icd_envs.physics.threads import RolloutThreads
from icd_envs.scenes.gripper import gripper_spheres
from icd_envs.screen import CONTROL_PERIOD, RENDER_MODES, Screen
from icd_envs.tasks.base import HOLD_STEPS, SceneT, Task
from icd_envs.tasks.checks import (
    check_action,
    check_choice,
    check_goals,
    check_integer,
    check_reset_options,
    check_seed,
    stack_parameters,
)
from icd_envs.tasks.observation import SceneClouds, observation_space, observe, sample_boxes
from icd_envs.tasks.partial import look
from icd_envs.tasks.problem import (
    SPLITS,
    Problem,
    Split,
    draw_problem,
    matched_parts,
    scene_rng,
    sensor_rng,
)

if TYPE_CHECKING:
    import mujoco

RewardType = Literal["sparse", "dense"]
ObservationMode = Literal["full", "partial"]

Info = dict[str, Any]


class ContactEnv(gym.Env[Observation, NDArray[np.float32]], Generic[SceneT]):
    """Goal-conditioned manipulation of a deformable object by a translating gripper."""

    metadata: dict[str, Any] = {  # noqa: RUF012  Gymnasium's own declaration
        "render_modes": list(RENDER_MODES),
        "render_fps": round(1 / CONTROL_PERIOD),
    }

    def __init__(
        self,
        task: Task[SceneT],
        *,
        split: Split,
        reward_type: RewardType,
        obs_mode: ObservationMode,
        render_mode: str | None,
        width: int,
        height: int,
        camera: str,
    ) -> None:
        """Set spaces up; see a task's own environment for the arguments."""
        check_choice("split", split, SPLITS)
        check_choice("reward_type", reward_type, ("sparse", "dense"))
        check_choice("obs_mode", obs_mode, ("full", "partial"))
        self.task = task
        self.max_steps = task.max_steps
        """Control steps to truncation; another number if ``gymnasium.make`` was given one."""
        self.split = split
        self.reward_type = reward_type
        self.obs_mode = obs_mode
        self.render_mode = render_mode
        self._screen = Screen(render_mode, width, height, camera)
        self.action_space = spaces.Box(-1.0, 1.0, (3,), np.float32)
        cloud = task.canonical_cloud().shape
        space = observation_space(cloud, partial=obs_mode == "partial")
        self.observation_space = space  # type: ignore[assignment]
        self._spec: EnvSpec | None = None
        self._problem: Problem[SceneT] | None = None
        self._threads: dict[int, RolloutThreads] = {}
        self._closed = False
        self._steps = self._held = 0
        self._diverged = False

    @property
    def spec(self) -> EnvSpec | None:
        """Gymnasium's recipe for this environment, with its budget of steps.

        The budget depends on the options, and a restored snapshot brings the steps taken with it,
        so that the environment truncates itself; libraries that ask the spec get the same number.
        """
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec | None) -> None:
        self._spec = spec
        if spec is not None and spec.max_episode_steps is None:
            spec.max_episode_steps = self.max_steps

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, Info]:
        """Draw a scene that the expert can solve, and a goal in it.

        Args:
            seed: fixes scene and goal, whatever happened before; None continues this
                environment's own sequence of seeds.
            options: no key is known yet.

        Raises:
            InvalidSeedError: if ``seed`` is not an integer in [0, 2**64).
            InvalidOptionError: on any key in ``options``, or if it is no dictionary.
            EpisodeStateError: after ``close``.
            SceneGenerationError: if no solvable scene was found.
        """
        if self._closed:
            raise EpisodeStateError("reset after close: make a new environment")
        check_reset_options(options)
        if seed is not None:
            seed = check_seed(seed)
        super().reset(seed=seed)
        if seed is None:
            seed = int(self.np_random.integers(2**32))
        rng = scene_rng(self.split, seed)
        self._release()
        problem = draw_problem(self.task, rng, seed)
        boxes = self.task.boxes(problem.scene)
        self._problem = problem
        self._seed = seed
        self._signed_distance = BoxUnion(boxes)
        scene = goal_scene = sample_boxes(boxes, rng)
        if problem.goal_scene is not problem.scene:
            goal_scene = sample_boxes(self.task.boxes(problem.goal_scene), rng)
        self._clouds = SceneClouds(scene, goal_scene)
        self._steps = self._held = 0
        self._diverged = False
        self._observation = self._observe(problem)
        self._screen.follow(problem.plant, problem.goal)
        return self._copy_observation(), self._info(self._match(), action_clipped=False)

    def step(self, action: NDArray[np.float32]) -> tuple[Observation, float, bool, bool, Info]:
        """Move the gripper for one control step.

        Stepping on after success is allowed: the episode simply goes on.

        Args:
            action: (3,) translation in units of ``action_scale``; clipped to [-1, 1].

        Raises:
            InvalidActionError: if it is not 3 finite numbers; nothing has changed then.
            EpisodeStateError: before ``reset``, after a divergence, after ``close``.
        """
        problem = self._require_problem("step")
        if self._diverged:
            raise EpisodeStateError("step after the physics diverged: call reset first")
        wanted = check_action(action)
        clipped = np.clip(wanted, -1.0, 1.0)
        problem.plant.step(clipped)
        self._steps += 1
        self._diverged = problem.plant.diverged()
        if not self._diverged:
            self._observation = self._observe(problem)
            self._screen.follow(problem.plant, problem.goal)
        matched = self._match()
        info = self._info(matched, action_clipped=bool(np.any(clipped != wanted)))
        self._held = self._held + 1 if info["is_success"] else 0
        reward = self._reward(
            matched, self._observation["achieved_goal"], self._observation["desired_goal"]
        )
        reached = self.task.ends_on_success and self._held >= HOLD_STEPS
        terminated = self._diverged or reached
        truncated = self._steps >= self.max_steps
        return self._copy_observation(), float(reward), terminated, truncated, info

    def compute_reward(
        self,
        achieved_goal: FloatArray,
        desired_goal: FloatArray,
        info: Mapping[str, Any] | Sequence[Mapping[str, Any]] | NDArray[np.object_],
    ) -> float | Float64Array:
        """Reward from its arguments alone, for single items and batches (relabelling).

        It does not know of divergence: on the step on which the physics diverged, ``step`` pays as
        for a goal of which nothing is reached, whatever the last good cloud, which is observed.

        Args:
            achieved_goal: (N, 3) or (B, N, 3) [m].
            desired_goal: the same shape.
            info: the step's ``info``, or B of them.

        Returns:
            a float, or (B,) float64.

        Raises:
            InvalidObservationError: on clouds of another shape, NaN or infinite values, or an
                info that does not say where the clouds are.
        """
        achieved, desired = check_goals(achieved_goal, desired_goal)
        single = achieved.ndim == 2
        if single:
            achieved, desired = achieved[None], desired[None]
        if len(achieved) == 0:
            return np.zeros(0)
        names = [p + name for name in self.task.parameter_names for p in ("", "goal_")]
        infos = [info] if isinstance(info, Mapping) else list(info)
        parameters = stack_parameters(infos, names, len(achieved))
        matched = self.task.matches(achieved, desired, parameters)
        reward = self._reward(matched, achieved, desired)
        return float(reward[0]) if single else reward

    def _reward(
        self, matched: BoolArray, achieved: FloatArray, desired: FloatArray
    ) -> Float64Array:
        """Reward (...) of parts matched (..., F) and clouds (..., N, 3)."""
        if self.reward_type == "sparse":
            return np.asarray(matched.all(axis=-1) - 1.0, dtype=np.float64)
        distance = np.linalg.norm(achieved - desired, axis=-1).mean(axis=-1)
        return np.asarray(matched.mean(axis=-1) - 1.0 - distance, dtype=np.float64)

    def episode(
        self, *, simulator: bool = False, oracle: bool = False, threads: int = 1
    ) -> Episode:
        """What an agent is told at the start of this episode.

        Args:
            simulator: hand the simulator out (privileged).
            oracle: hand the expert's solution out (privileged).
            threads: for the simulator's rollouts; results do not depend on it. The simulators of
                one episode share them.

        Raises:
            EpisodeStateError: before ``reset`` or after ``close``.
            InvalidOptionError: no number of threads.
        """
        problem = self._require_problem("episode")
        handle = None
        if simulator:
            check_integer("threads", threads, 1, 4096)
            if threads not in self._threads:
                self._threads[threads] = RolloutThreads(problem.plant.model, threads)
            handle = RolloutSimulator(
                problem.plant, self.snapshot, self._signed_distance, self._threads[threads]
            )
        return Episode(
            env_id=self.task.env_id,
            action_scale=self.task.action_scale,
            control_period=problem.plant.control_period,
            max_steps=self.max_steps,
            canonical_cloud=self.task.canonical_cloud(),
            gripper_spheres=gripper_spheres(),
            simulator=handle,
            oracle=problem.oracle if oracle else None,
            goal_oracle=problem.goal_oracle if oracle else None,
            ends_on_success=self.task.ends_on_success,
            foreign_goal=problem.goal_scene is not problem.scene,
        )

    def snapshot(self) -> SimState:
        """The whole state, to come back to with ``restore``."""
        plant = self._require_problem("snapshot").plant
        return SimState(
            self.task.env_id, plant.scene_id, plant.get_state(), self._steps, self._held
        )

    def restore(self, state: SimState) -> Observation:
        """Return to a state of this scene; what follows is the same bit for bit.

        Raises:
            IncompatibleStateError: if it is no snapshot, or of another environment or scene.
            EpisodeStateError: before ``reset`` or after ``close``.
        """
        problem = self._require_problem("restore")
        check_snapshot(state)
        mine = (self.task.env_id, problem.plant.scene_id)
        if (state.env_id, state.scene_id) != mine:
            raise IncompatibleStateError(
                f"state is of {(state.env_id, state.scene_id)}, this environment is at {mine}: "
                "reset with the seed, split and options that the state was taken under"
            )
        problem.plant.set_state(state.physics)
        self._steps, self._held, self._diverged = state.steps, state.held, False
        self._observation = self._observe(problem)
        return self._copy_observation()

    @property
    def model(self) -> mujoco.MjModel:
        """MuJoCo's model of the present scene, to look at; another one after every reset.

        Raises:
            NoSceneError: before ``reset`` or after ``close``; ``hasattr`` is False then.
        """
        return self._require_problem("model", NoSceneError).plant.model

    @property
    def data(self) -> mujoco.MjData:
        """MuJoCo's state of it, to look at; change it by ``step`` and ``restore`` alone.

        Raises:
            NoSceneError: as for ``model``.
        """
        return self._require_problem("data", NoSceneError).plant.data

    @property
    def goal(self) -> Float32Array:
        """(N, 3) [m] the object's cloud at the goal of this episode, as it is observed.

        Raises:
            NoSceneError: as for ``model``.
        """
        return self._require_problem("goal", NoSceneError).goal.copy()

    def render(self) -> NDArray[np.uint8] | Float32Array | None:
        """(height, width, 3) uint8 picture or (height, width) float32 depth [m], or None.

        Raises:
            RenderingUnavailableError: if OpenGL does not start, or no window opens.
            EpisodeStateError: before ``reset`` or after ``close``.
        """
        problem = self._require_problem("render")
        return self._screen.render(problem.plant, problem.goal)

    def show_plan(self, plan: PlanView | None) -> None:
        """Draw an agent's plan into pictures, until the next plan or reset; None draws none."""
        self._screen.plan = plan

    def close(self) -> None:
        """Free threads and GL; a second call does nothing."""
        self._release()
        self._problem = None
        self._closed = True

    def __getstate__(self) -> dict[str, Any]:
        """What a copy needs to go on bit for bit; it starts threads of its own when asked."""
        return {**self.__dict__, "_threads": {}}

    def _require_problem(
        self, call: str, error: type[EpisodeStateError] = EpisodeStateError
    ) -> Problem[SceneT]:
        if self._closed:
            raise error(f"{call} after close: make a new environment")
        if self._problem is None:
            raise error(f"{call} before the first reset: call reset(seed=...) first")
        return self._problem

    def _release(self) -> None:
        for threads in self._threads.values():
            threads.close()
        self._threads.clear()
        self._screen.close()

    def _observe(self, problem: Problem[SceneT]) -> Observation:
        """The full observation; what is shown of it is kept as well."""
        full = observe(problem.plant, problem.goal, self._clouds)
        self._shown: Observation | PartialObservation = full
        if self.obs_mode == "partial":
            rng = sensor_rng(self.split, self._seed, self._steps)
            self._shown = look(problem.plant.model, problem.plant.data, full, rng)
        return full

    def _copy_observation(self) -> Observation:
        return {name: value.copy() for name, value in self._shown.items()}  # type: ignore

    def _match(self) -> BoolArray:
        """(F,) parts of the goal that are reached now; none after a divergence."""
        problem = self._require_problem("match")
        matched = matched_parts(self.task, problem, self._observation["achieved_goal"])
        return matched & (not self._diverged)

    def _info(self, matched: BoolArray, *, action_clipped: bool) -> Info:
        problem = self._require_problem("info")
        common: CommonInfo = {
            "is_success": bool(matched.all()),
            "complete_rate": float(matched.mean()),
            "diverged": self._diverged,
            "action_clipped": action_clipped,
            "buffer_overflows": problem.plant.buffer_overflows(),
        }
        return {**common, **{name: value.copy() for name, value in problem.parameters.items()}}
