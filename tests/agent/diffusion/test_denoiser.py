"""What the denoiser has seen of a scene once serves all steps and levels, to the bit."""

from __future__ import annotations

import torch

from icd_agent.diffusion.config import DiffusionConfig
from icd_agent.diffusion.denoiser import Denoiser, Known
from icd_agent.training.initial import initialise

CONFIG = DiffusionConfig(4, 5, 20, 12, places=3, memory=16, width=16, layers=2, heads=2)


def test_looking_before_is_looking_now_and_what_is_seen_counts() -> None:
    draw = torch.Generator().manual_seed(0)
    model = Denoiser(CONFIG).eval()
    initialise(model, draw)
    goal, scene = torch.randn(3, 7, generator=draw), torch.randn(3, 12, 8, generator=draw)
    foreign = torch.tensor([True, False, True])
    for length, level, time in ((3, 1, 90), (9, 3, 10)):
        noisy = torch.randn(3, length, 7, generator=draw)
        kinds, levels = torch.ones(3, length, dtype=torch.long), torch.full((3,), level)
        known = Known(noisy, kinds, goal, foreign, scene, levels)
        steps = torch.full((3,), time)
        with torch.no_grad():
            seen = model.look(goal, foreign, scene)
            now = model(noisy, steps, known)
            assert torch.equal(model(noisy, steps, known, seen), now)
            other = model.look(goal, foreign, scene + 1.0)
            assert not torch.equal(model(noisy, steps, known, other), now)
