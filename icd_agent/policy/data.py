"""Windows of recorded episodes: what was seen, and the actions that followed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from icd_agent.episodes import Goals, sound_episodes
from icd_agent.options import require
from icd_agent.policy.config import PolicyConfig
from icd_agent.policy.encoders import Seen
from icd_agent.policy.look import Look
from icd_envs.api import Float32Array
from icd_envs.demonstrations import Demonstrations


class Windows(NamedTuple):
    """A batch.

    Attributes:
        seen: what was seen [m].
        actions: (B, H, 3) in [-1, 1], the first for the oldest observation; 0 after the end.
    """

    seen: Seen
    actions: Tensor


class PolicyData:
    """Recorded episodes, the last state of each as its goal: whatever was done was wanted.

    Attributes:
        limits: (3,) [m] each, smallest and largest places in all of the folder's episodes but those
            that diverged; never the same.
        episodes: how many there are.
        steps: control steps in all.
    """

    def __init__(
        self,
        demonstrations: Demonstrations,
        look: Look,
        config: PolicyConfig,
        *,
        episodes: int,
        solved_only: bool,
    ) -> None:
        """Look at every scene once.

        Args:
            demonstrations: states and actions.
            look: thins clouds.
            config: of the policy.
            episodes: the first so many are looked at; those that diverged are left out.
            solved_only: use those that solved their task.

        Raises:
            InvalidOptionError: none did.
            DemonstrationsError: all diverged.
        """
        used = sound_episodes(demonstrations, episodes)
        if solved_only:
            used = used[demonstrations.success[used]]
        fix = "others, or more of them, or --all-episodes"
        require(len(used) > 0, "data", "no episode that solved its task", fix)
        self._demonstrations = demonstrations
        self._look = look
        self._config = config
        self._used = used
        self._scenes = np.stack([look.scene(demonstrations.scene(int(i)).cloud) for i in used])
        self._end = np.cumsum(demonstrations.lengths[used])
        self.episodes, self.steps = len(used), int(self._end[-1])
        self._last = demonstrations.first_state[used + 1] - 1
        self._goals = look.object(demonstrations.points(demonstrations.nodes[self._last]))
        self._whose = Goals(demonstrations.solved[self._last])
        self.limits = self._limits()

    def draw(self, count: int, rng: np.random.Generator, device: str = "cpu") -> Windows:
        """A batch of windows, every recorded step as likely.

        Args:
            count: B.
            rng: source of every draw.
            device: where the tensors go.
        """
        recorded, config = self._demonstrations, self._config
        flat = rng.integers(self.steps, size=count)
        i = np.searchsorted(self._end, flat, side="right")
        episode = self._used[i]
        step = flat - (self._end[i] - recorded.lengths[episode])
        back = np.arange(1 - config.observed, 1)
        states = recorded.first_state[episode][:, None] + np.maximum(step[:, None] + back, 0)
        clouds = self._look.object(recorded.points(recorded.nodes[states.ravel()]))
        goal, _ = self._whose.draw(i, rng)
        seen = Seen(
            _tensor(recorded.gripper[states, :3], device),
            _tensor(clouds.reshape(*states.shape, *clouds.shape[1:]), device),
            _tensor(self._goals[goal], device),
            _tensor(self._scenes[i], device),
            _tensor(self._scenes[goal], device),
        )
        ahead = step[:, None] + back[0] + np.arange(config.horizon)
        last = recorded.lengths[episode][:, None]
        rows = recorded.first_step[episode][:, None] + np.clip(ahead, 0, last - 1)
        actions = np.where((ahead < last)[..., None], recorded.actions[rows], np.float32(0.0))
        return Windows(seen, _tensor(actions, device))

    def _limits(self) -> tuple[Tensor, Tensor]:
        recorded = self._demonstrations
        sound = np.repeat(~np.asarray(recorded.diverged, bool), recorded.lengths + 1)
        places = [
            recorded.nodes[sound].reshape(-1, 3),
            recorded.gripper[sound, :3],
            self._scenes[..., :3].reshape(-1, 3),
        ]
        low = np.min([each.min(axis=0) for each in places], axis=0)
        high = np.max([each.max(axis=0) for each in places], axis=0)
        apart = high > low
        half = np.float32(0.5)  # [m] where all are the same
        return (
            torch.from_numpy(np.where(apart, low, low - half)),
            torch.from_numpy(np.where(apart, high, high + half)),
        )


def _tensor(values: Float32Array, device: str) -> Tensor:
    return torch.from_numpy(np.ascontiguousarray(values, np.float32)).to(device)
