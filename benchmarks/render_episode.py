"""What ``icd-bench render episode`` does: a strip or a film of one episode of any agent."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.beginning import begin, episode_for
from benchmarks.conditions import parse_options
from benchmarks.contact_env import contact_env
from benchmarks.errors import blaming
from benchmarks.figures import new_figure, save_figure
from benchmarks.registry import Offer, make_agent
from icd_envs.api import Agent, SimState
from icd_envs.errors import InvalidOptionError
from icd_envs.tasks.env import ContactEnv

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PICTURES: Final = 8


class Played(NamedTuple):
    """An episode.

    Attributes:
        states: at the start and after every step.
        rates: complete rate in each.
        success: whether the last one is a success.
    """

    states: list[SimState]
    rates: list[float]
    success: bool


def render(
    agent_name: str,
    env_id: str,
    out: Path,
    *,
    seed: int,
    options: Sequence[str] = (),
    trust_pickle: bool = False,
) -> None:
    """Run one test episode and draw it.

    Args:
        agent_name: any agent that ``icd-bench run`` takes.
        env_id: which environment, with a task of this package or of your own.
        out: PNG file, for eight pictures at equal intervals, first and last state included; or GIF
            file, for a film.
        seed: of scene and agent.
        options: of the task, each as ``name=value``.
        trust_pickle: whether the agent may be unpickled.

    Raises:
        InvalidOptionError: unknown agent, environment or option, a file that is neither, or no
            Matplotlib or Pillow.
        AgentFailedError: the agent raised.
    """
    if out.suffix not in (".png", ".gif"):
        raise InvalidOptionError(
            f"out={str(out)!r} cannot be used: give a name that ends in .png or .gif"
        )
    if out.suffix == ".gif" and find_spec("PIL") is None:
        raise InvalidOptionError(
            "films need Pillow: pip install 'implicit-contact-diffuser[figures]'"
        )
    figure = new_figure(out, (16, 6.4)) if out.suffix == ".png" else None
    told = (*parse_options(options), ("render_mode", "rgb_array"))
    with contact_env(env_id, told) as env:
        with blaming(agent_name):
            agent = make_agent(agent_name, Offer(env_id, trust_pickle=trust_pickle))
            played = _play(env, agent, seed)
        if figure is None:
            _film(env, played, out)
        else:
            _strip(env, played, figure)
            ending = "success" if played.success else "no success"
            figure.suptitle(f"{agent_name} in {env_id}, test scene {seed}: {ending}")
            save_figure(figure, out)


def _play(env: ContactEnv[Any], agent: Agent, seed: int) -> Played:
    observation, info = env.reset(seed=seed)
    begin(agent, episode_for(env, agent), seed)
    states, rates, over = [env.snapshot()], [float(info["complete_rate"])], False
    while not over:
        action = np.asarray(agent.act(observation))
        observation, _, terminated, truncated, info = env.step(action)
        over = terminated or truncated
        states.append(env.snapshot())
        rates.append(float(info["complete_rate"]))
    return Played(states, rates, bool(info["is_success"]))


def _strip(env: ContactEnv[Any], played: Played, figure: Figure) -> None:
    axes = figure.subplots(2, PICTURES // 2).flat
    shown = np.linspace(0, len(played.states) - 1, PICTURES).astype(int)
    for axis, step in zip(axes, shown, strict=True):
        axis.imshow(_picture(env, played.states[step]))
        axis.set_axis_off()
        axis.set_title(f"step {step}, complete {played.rates[step]:.0%}")


def _film(env: ContactEnv[Any], played: Played, out: Path) -> None:
    from benchmarks.gif import write_gif

    write_gif(out, [_picture(env, state) for state in played.states])


def _picture(env: ContactEnv[Any], state: SimState) -> NDArray[np.uint8]:
    env.restore(state)
    picture = env.render()
    assert picture is not None
    return picture.astype(np.uint8, copy=False)
