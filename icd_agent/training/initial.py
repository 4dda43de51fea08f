"""Initial weights from a generator; PyTorch's own layers draw from a global one."""

from __future__ import annotations

import math

import torch
from torch import Generator, nn


@torch.no_grad()
def initialise(model: nn.Module, generator: Generator) -> None:
    """Draw every weight anew, as PyTorch's defaults would: uniform within 1 / sqrt(fan in).

    Args:
        model: of linear, convolution, embedding and normalisation layers; other parameters are
            left alone.
        generator: source of every draw.
    """
    for layer in model.modules():
        if isinstance(layer, nn.Linear | nn.Conv1d):
            bound = 1.0 / math.sqrt(layer.weight[0].numel())
            nn.init.uniform_(layer.weight, -bound, bound, generator=generator)
            if layer.bias is not None:
                nn.init.uniform_(layer.bias, -bound, bound, generator=generator)
        elif isinstance(layer, nn.Embedding):
            nn.init.normal_(layer.weight, generator=generator)
