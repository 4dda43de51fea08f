"""The loss of the denoiser, by a network whose errors are known."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor, nn

from icd_agent.diffusion.chains import Chains
from icd_agent.diffusion.code import SubgoalCode
from icd_agent.diffusion.config import DiffusionConfig
from icd_agent.diffusion.denoiser import COARSE, GIVEN, UNKNOWN, Known
from icd_agent.diffusion.schedule import make_schedule
from icd_agent.diffusion.train import denoising_loss


class Off(nn.Module):
    """Predicts the clean subgoals, but for a known error; remembers what it was shown."""

    def __init__(self, clean: Tensor, error: Tensor) -> None:
        super().__init__()
        self.answer = clean + error
        self.code = SubgoalCode(DiffusionConfig(2, 4, 12, 2, places=1))
        self.code.deviation = torch.tensor([1.0, 2.0, 3.0])  # of latents, 1 / 5 and 4 / 5 count

    def forward(self, noisy: Tensor, time: Tensor, known: Known) -> Tensor:
        self.shown = noisy
        return self.answer


def test_given_subgoals_are_shown_as_they_are_and_only_the_others_are_counted() -> None:
    draw, schedule = torch.Generator().manual_seed(0), make_schedule(100)
    clean, noise = (torch.randn(2, 3, 3, generator=draw) for _ in range(2))
    kinds = torch.tensor([[GIVEN, UNKNOWN, GIVEN], [GIVEN, UNKNOWN, COARSE]])
    error = torch.full((2, 3, 3), 100.0)
    error[0, 1] = torch.tensor([1.0, 0.0, 2.0])  # squared and weighted: 0.2 and 4
    error[1, 1] = torch.tensor([0.0, 1.0, 0.0])  # 0.8 and 0
    error[1, 2] = torch.tensor([1.0, 1.0, 1.0])  # 1 and 1
    empty, time = torch.zeros(0), torch.tensor([89, 90])  # the second is of the noisiest tenth
    model = Off(clean, error)
    chains = Chains(clean, Known(empty, kinds, empty, empty, empty, empty))
    found = denoising_loss(model, schedule, chains, noise, time)
    assert float(found["latents"]) == pytest.approx((0.2 + 0.8 + 1.0) / 3)
    assert float(found["places"]) == pytest.approx((4.0 + 0.0 + 1.0) / 3)
    assert float(found["loss"]) == pytest.approx((2.0 + 5.0) / 3)
    assert float(found["from_noise"]) == pytest.approx((0.8 + 1.0) / 2)
    left = schedule.alphas_cumprod[time][:, None, None]
    noisy = left.sqrt() * clean + (1.0 - left).sqrt() * noise
    expected = torch.where((kinds == GIVEN)[..., None], clean, noisy)
    torch.testing.assert_close(model.shown, expected)
    none = denoising_loss(model, schedule, chains, noise, torch.tensor([0, 50]))
    assert float(none["from_noise"]) == 0.0
