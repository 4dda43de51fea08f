"""Principal components of training states: the linear part of the autoencoder."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch

from icd_agent.options import require
from icd_envs.api import Float32Array


class Principal(NamedTuple):
    """What training states vary in most.

    Attributes:
        mean: (N, D) of the features.
        scale: root mean square, over states and points, of what is left.
        components: (Z, N, D) orthogonal, the first explains most; each has a mean square of N / Z
            over the points, so that coefficients have one of about 1 over components and states.
    """

    mean: Float32Array
    scale: float
    components: Float32Array


def principal(features: Float32Array, latent: int) -> Principal:
    """Components of object states.

    Args:
        features: (S, N, D) of the states.
        latent: Z.

    Raises:
        InvalidOptionError: more components than numbers in a state.
    """
    count, numbers = len(features), int(np.prod(features.shape[1:]))
    require(latent <= numbers, "latent", latent, f"at most {numbers}, the numbers of a state")
    mean = features.mean(axis=0)
    features = features - mean
    scale = float(np.sqrt(np.square(features).sum(-1).mean()))
    flat = torch.from_numpy(features.reshape(count, -1) / scale)
    if flat.shape[0] < flat.shape[1]:  # of the two products, the smaller one
        axes = flat.T @ torch.linalg.eigh(flat @ flat.T).eigenvectors.flip(-1)[:, :latent]
    else:
        axes = torch.linalg.eigh(flat.T @ flat).eigenvectors.flip(-1)[:, :latent]
    axes = torch.nn.functional.pad(axes, (0, latent - axes.shape[1]))
    axes = torch.linalg.qr(axes).Q.T  # of length 1, and orthogonal even where nothing varies
    largest = axes.gather(1, axes.abs().argmax(dim=1, keepdim=True))
    axes = axes * largest.sign()  # an axis has no direction of its own
    components = axes.numpy().reshape(latent, *mean.shape) * np.sqrt(len(mean) / latent)
    return Principal(mean, scale, components.astype(np.float32))
