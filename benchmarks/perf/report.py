"""Where the time of a planning step goes, measured side by side in one process.

Every figure is a median over interleaved repeats: absolute times belong to the machine they were
measured on, ratios carry over.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from statistics import median
from typing import Any, Final, cast

import gymnasium as gym
import mujoco
import numpy as np
from mujoco import rollout

import icd_envs  # noqa: F401  registers the environments
from baselines.pc_mppi import make_pc_mppi
from benchmarks.perf.naive_cable import make_naive
from benchmarks.provenance import cpu_count
from icd_agent.diffused import DiffusedSource
from icd_agent.diffusion.config import ChainConfig
from icd_agent.diffusion.denoiser import Denoiser
from icd_agent.diffusion.generate import Generated, Generator, Task
from icd_agent.field.space import ExactFieldSpace, FieldSpace
from icd_agent.latent.model import LatentModel
from icd_agent.networks import load_shipped
from icd_agent.plan_info import PlanInfo
from icd_agent.presets import PRESETS, best_preset
from icd_envs.api import Episode, FloatArray, Observation, Oracle, Rollout, SimState
from icd_envs.physics.simulator import RolloutSimulator
from icd_envs.scenes.arena import SUBSTEPS
from icd_envs.scenes.cable_routing import CableRoutingScene
from icd_envs.tasks.env import ContactEnv

ENV_ID: Final = "ICDCableRouting-v0"
PHYSICS_SAMPLES: Final = 16
HORIZON: Final = 10


def measure(repeats: int = 5) -> dict[str, float]:
    """Time physics and planning in a routed, that is contact-rich, state.

    Args:
        repeats: interleaved measurements of each figure.

    Returns:
        figure name -> value; the names end in their unit.
    """
    env = gym.make(ENV_ID, split="test")
    try:
        observation, _ = env.reset(seed=0)
        unwrapped = cast("ContactEnv[Any]", env.unwrapped)
        episode = unwrapped.episode(oracle=True)
        assert episode.oracle is not None
        for action in episode.oracle.actions:
            observation = env.step(action)[0]
        figures = _measure_physics(unwrapped, episode.oracle, repeats)
        figures.update(_measure_planner(unwrapped, observation, repeats))
    finally:
        env.close()
    return figures


def _measure_physics(env: ContactEnv[Any], oracle: Oracle, repeats: int) -> dict[str, float]:
    simulator = env.episode(simulator=True, threads=1).simulator
    assert isinstance(simulator, RolloutSimulator)
    assert isinstance(oracle.scene, CableRoutingScene)
    state = env.snapshot()
    actions = np.random.default_rng(0).uniform(-1, 1, (PHYSICS_SAMPLES, HORIZON, 3))
    naive_model, naive_state = make_naive(oracle.scene, oracle.points[-1])
    naive_data = mujoco.MjData(naive_model)
    speed = env.task.action_scale / (SUBSTEPS * float(naive_model.opt.timestep))
    control = np.repeat(actions * speed, SUBSTEPS, axis=1)

    def run_naive() -> None:
        rollout.rollout(naive_model, [naive_data], naive_state, control)

    ours, naive = _interleave(repeats, lambda: simulator.integrate(state, actions), run_naive)
    steps = PHYSICS_SAMPLES * HORIZON * SUBSTEPS
    return {
        "physics_us_per_step": 1e6 * median(ours) / (steps + PHYSICS_SAMPLES),
        "naive_chain_us_per_step": 1e6 * median(naive) / steps,
        "naive_over_ours": median(b / a for a, b in zip(ours, naive, strict=True)),
    }


def _measure_planner(
    env: ContactEnv[Any], observation: Observation, repeats: int
) -> dict[str, float]:
    threads = cpu_count()
    episode = env.episode(simulator=True, threads=threads)
    assert isinstance(episode.simulator, RolloutSimulator)
    recorder = _Recorder(episode.simulator)
    agent = make_pc_mppi()
    agent.reset(replace(episode, simulator=recorder), seed=0)
    parts: list[PlanInfo] = []

    def act() -> None:
        agent.act(observation)
        assert agent.plan_info is not None
        parts.append(agent.plan_info)

    whole, bare = _interleave(repeats, act, recorder.repeat_bare)
    replanning = _measure_replanning(episode, observation, act, repeats)
    return (
        _measure_field(observation, recorder, repeats)
        | replanning
        | {
            "planner_threads": float(threads),
            "mppi_step_ms": 1e3 * median(whole),
            "rollout_ms": 1e3 * median(part.rollout_seconds for part in parts),
            "cost_ms": 1e3 * median(part.cost_seconds for part in parts),
            "update_ms": 1e3 * median(part.update_seconds for part in parts),
            "bare_rollout_ms": 1e3 * median(bare),
            "step_over_bare_rollout": median(a / b for a, b in zip(whole, bare, strict=True)),
        }
    )


def _measure_field(observation: Observation, recorder: _Recorder, repeats: int) -> dict[str, float]:
    """Descriptors of the last rollout's object points, beside its physics."""
    space = FieldSpace.shipped(ENV_ID)
    before = time.perf_counter()
    features = space.place(observation).here
    bake = time.perf_counter() - before
    points = recorder.last_points
    lookup, bare = _interleave(repeats, lambda: features(points), recorder.repeat_bare)
    return {
        "bake_s": bake,
        "descriptors_ms": 1e3 * median(lookup),
        "descriptors_over_bare_rollout": median(a / b for a, b in zip(lookup, bare, strict=True)),
    }


def _measure_replanning(
    episode: Episode, observation: Observation, act: Callable[[], object], repeats: int
) -> dict[str, float]:
    """A whole new chain of 17 (encode, diffuse, ask the field), beside a step of MPPI."""
    networks = load_shipped(ENV_ID)
    space = FieldSpace(networks.field).place(observation)
    settings = replace(PRESETS[best_preset(ENV_ID)].chain, reachable=None)
    generator = _TimedGenerator(networks.diffusion, networks.latent, settings)
    encoded_in = ExactFieldSpace(networks.encoded)
    source = DiffusedSource(networks.encoded, networks.latent, generator, encoded_in=encoded_in)
    rng = np.random.default_rng(0)
    source.chain(episode, observation, space, rng)
    replan, step = _interleave(
        repeats, lambda: source.again(episode, observation, space, rng, 0), act
    )
    return {
        "replan_ms": 1e3 * median(replan),
        "replan_diffusion_ms": 1e3 * median(generator.seconds[2:]),
        "replan_over_mppi_step": median(a / b for a, b in zip(replan, step, strict=True)),
    }


class _TimedGenerator(Generator):
    """A generator that remembers how long each chain took."""

    def __init__(self, denoiser: Denoiser, latent: LatentModel, config: ChainConfig) -> None:
        super().__init__(denoiser, latent, config)
        self.seconds: list[float] = []

    def generate(self, task: Task, rng: np.random.Generator) -> Generated:
        start = time.perf_counter()
        found = super().generate(task, rng)
        self.seconds.append(time.perf_counter() - start)
        return found


class _Recorder:
    """A simulator that remembers what it was last asked."""

    def __init__(self, simulator: RolloutSimulator) -> None:
        self._simulator = simulator
        self.snapshot = simulator.snapshot
        self.signed_distance = simulator.signed_distance

    def rollout(self, state: SimState, actions: FloatArray) -> Rollout:
        self._last = (state, np.asarray(actions, dtype=np.float64))
        found = self._simulator.rollout(state, actions)
        self.last_points = found.points
        return found

    def repeat_bare(self) -> None:
        """The physics of the last rollout again, and nothing else."""
        self._simulator.integrate(*self._last)


def _interleave(
    repeats: int, first: Callable[[], object], second: Callable[[], object]
) -> tuple[list[float], list[float]]:
    """Seconds of each of ``repeats`` runs of two functions in turn, after a warm-up of both."""
    times: tuple[list[float], list[float]] = ([], [])
    for run in range(repeats + 1):
        for function, record in zip((first, second), times, strict=True):
            start = time.perf_counter()
            function()
            if run:
                record.append(time.perf_counter() - start)
    return times
