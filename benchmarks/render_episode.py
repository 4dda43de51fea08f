"""What ``icd-bench render episode`` does: a strip of pictures of one episode of any agent."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.conditions import Condition, TaskSpec, make_env, parse_options
from benchmarks.figures import new_figure, save_figure
from benchmarks.registry import Offer, make_agent
from icd_envs import ENV_IDS
from icd_envs.errors import InvalidOptionError, unknown_name
from icd_envs.tasks.env import ContactEnv

PICTURES: Final = 8


def render(
    agent_name: str, env_id: str, out: Path, *, seed: int, options: Sequence[str] = ()
) -> None:
    """Run one test episode and draw it at equal intervals, its first and last state included.

    Args:
        agent_name: any agent that ``icd-bench run`` takes.
        env_id: which environment of this package.
        out: PNG file.
        seed: of scene and agent.
        options: of the task, each as ``name=value``.

    Raises:
        InvalidOptionError: unknown agent, environment or option, a file that is no PNG, or no
            Matplotlib.
    """
    if env_id not in ENV_IDS:
        raise InvalidOptionError(unknown_name("environment id", env_id, ENV_IDS))
    figure = new_figure(out, (16, 6.4))
    agent = make_agent(agent_name, Offer(env_id))
    told = (*parse_options(options), ("render_mode", "rgb_array"))
    env: Any = make_env(TaskSpec(env_id, Condition("drawn", told))).unwrapped
    assert isinstance(env, ContactEnv)
    try:
        observation, info = env.reset(seed=seed)
        agent.reset(
            env.episode(
                simulator=getattr(agent, "needs_simulator", False),
                oracle=getattr(agent, "needs_oracle", False),
            ),
            seed,
        )
        states, rates, over = [env.snapshot()], [info["complete_rate"]], False
        while not over:
            observation, _, terminated, truncated, info = env.step(
                np.asarray(agent.act(observation))
            )
            over = terminated or truncated
            states.append(env.snapshot())
            rates.append(info["complete_rate"])
        axes = figure.subplots(2, PICTURES // 2).flat
        shown = np.linspace(0, len(states) - 1, PICTURES).astype(int)
        for axis, step in zip(axes, shown, strict=True):
            env.restore(states[step])
            axis.imshow(env.render())
            axis.set_axis_off()
            axis.set_title(f"step {step}, complete {rates[step]:.0%}")
    finally:
        env.close()
    ending = "success" if info["is_success"] else "no success"
    figure.suptitle(f"{agent_name} in {env_id}, test scene {seed}: {ending}")
    save_figure(figure, out)
