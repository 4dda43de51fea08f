"""Run one episode in this process and say how it ended."""

from __future__ import annotations

import atexit
import warnings
from contextlib import suppress
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np

from benchmarks.attempt import Attempt, Played, Settings
from benchmarks.beginning import begin, episode_for, privileges
from benchmarks.conditions import TaskSpec, make_env
from benchmarks.errors import ResultsWarning, reason
from benchmarks.filming import Camera, Env, in_pictures
from benchmarks.plan import Job
from benchmarks.pulse import Pulse
from benchmarks.registry import Offer, make_agent
from benchmarks.rows import Row, error_row
from icd_envs.api import Agent


@dataclass
class _Kept:
    """What a worker process keeps between episodes; scenes and weights are slow to load."""

    envs: dict[TaskSpec, Env] = field(default_factory=dict)
    agents: dict[tuple[str, str], Agent] = field(default_factory=dict)

    def env(self, task: TaskSpec) -> Env:
        if task not in self.envs:
            self.envs[task] = make_env(task)
        return self.envs[task]

    def agent(self, name: str, offer: Offer) -> Agent:
        if (name, offer.env_id) not in self.agents:
            self.agents[name, offer.env_id] = make_agent(name, offer)
        return self.agents[name, offer.env_id]

    def close(self) -> None:
        """Free what is there, while OpenGL is still there to free its part."""
        while self.envs:
            with suppress(Exception):
                self.envs.popitem()[1].close()

    def drop(self, job: Job) -> None:
        """Forget agent and environment of a job that went wrong: their state is unknown."""
        self.agents.pop((job.agent, job.env), None)
        for task in (job.task, in_pictures(job.task)):
            if task in self.envs:
                with suppress(Exception):
                    self.envs.pop(task).close()


@dataclass
class _Tally:
    """What there is to tell of an episode so far."""

    return_: float = 0.0
    act_seconds: float = 0.0
    privileged: str = ""


_kept = _Kept()
atexit.register(_kept.close)


def play(attempt: Attempt, pulse: Pulse, settings: Settings) -> Played:
    """Play one episode; whatever agent or environment do wrong becomes a row of status "error".

    Args:
        attempt: which agent, environment and seed.
        pulse: is told what is being done.
        settings: budget of one ``act``, threads, and what the agent's factory may ask for.
    """
    job = attempt.job
    start = perf_counter()
    tally = _Tally()
    camera = Camera(pulse, settings.render_seconds) if attempt.film else None
    try:
        pulse.doing = "making the environment"
        info = _play(_stage(job, camera), job, settings, pulse, tally)
        row = Row(
            agent=job.agent,
            env=job.env,
            condition=job.condition.name,
            index=job.index,
            repeat=job.repeat,
            seed=job.seed,
            status="ok",
            success=bool(info["is_success"]),
            complete=float(info["complete_rate"]),
            steps=pulse.step,
            return_=tally.return_,
            diverged=bool(info["diverged"]),
            buffer_overflows=info.get("buffer_overflows"),
            message="",
            seconds=perf_counter() - start,
            act_seconds=tally.act_seconds / max(1, pulse.step),
            privileged=tally.privileged,
        )
    except (Exception, SystemExit) as error:
        row = error_row(
            job,
            f"{pulse.doing}, step {pulse.step}: {reason(error)}",
            steps=pulse.step,
            return_=tally.return_,
            seconds=perf_counter() - start,
            act_seconds=tally.act_seconds / max(1, pulse.step),
            privileged=tally.privileged,
        )
    video = camera.develop() if camera else b""
    if row.status == "error":
        _kept.drop(job)
    return Played(row, video)


def _stage(job: Job, camera: Camera | None) -> Env:
    """The environment, drawn and recorded if that is possible."""
    if camera is not None:
        try:
            return camera.watch(_kept.env(in_pictures(job.task)))
        except Exception as error:
            warnings.warn(f"no videos of {job.env}: {reason(error)}", ResultsWarning, stacklevel=2)
    return _kept.env(job.task)


def _play(env: Env, job: Job, settings: Settings, pulse: Pulse, tally: _Tally) -> dict[str, Any]:
    """Act until the episode ends and return its last info."""
    pulse.doing = "making the agent"
    agent = _kept.agent(job.agent, Offer(job.env, settings.device, settings.trust_pickle))
    tally.privileged = "+".join(name for name, asked in privileges(agent).items() if asked)

    pulse.doing = "resetting the environment"
    observation, _ = env.reset(seed=job.seed)
    episode = episode_for(env, agent, settings.threads)
    pulse.doing = "resetting the agent"
    begin(agent, episode, job.agent_seed)

    for _ in range(episode.max_steps):
        given = {name: np.array(value) for name, value in observation.items()}
        before = perf_counter()
        with pulse.limited("act", settings.act_seconds):
            action = agent.act(given)  # type: ignore[arg-type]
        tally.act_seconds += perf_counter() - before
        pulse.doing = "env.step"
        observation, reward, terminated, truncated, info = env.step(action)
        pulse.step += 1
        tally.return_ += float(reward)
        if terminated or truncated:
            pulse.doing = "reading the last info"
            return info
    raise RuntimeError(f"the episode did not end within its max_steps={episode.max_steps}")
