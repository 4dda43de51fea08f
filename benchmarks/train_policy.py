"""What ``icd-bench train diffusion-policy`` and ``train dp3`` do."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from benchmarks.console import Values
from benchmarks.described import about_of, read_demonstrations
from benchmarks.parts import keep_beside, local_field
from benchmarks.training_order import TrainingOrder
from benchmarks.training_progress import training
from icd_agent.checkpoints import weights_sha256
from icd_agent.field.train import load_field
from icd_agent.policy.config import PolicyConfig, Sees
from icd_agent.policy.data import PolicyData
from icd_agent.policy.look import Look
from icd_agent.policy.train import train_policy
from icd_agent.scene_tokens import SURFACE
from icd_agent.training.config import TrainingConfig
from icd_agent.training.device import check_device
from icd_agent.weights import DIFFUSION_POLICY, DP3
from icd_envs.errors import InvalidOptionError

KEY_POINTS: Final = 25
POINTS: Final = 128
"""Of each of four clouds: 512 in all."""
LEARNING_RATE: Final = 3e-4
TEMPERATURE: Final = 0.5
"""Demonstrated actions are noisy; with all of that noise, policies run out of time."""


def train(name: str, order: TrainingOrder, *, field: Path | None, solved_only: bool) -> Values:
    """Train a policy on recorded actions, save.

    Args:
        name: ``diffusion-policy`` or ``dp3``.
        order: what to train on, and where to.
        field: folder of the field by which scenes are seen; None is the package's. One that is
            given is copied beside the weights.
        solved_only: imitate only those of the episodes that solved their task.

    Returns:
        Names and values for the user.

    Raises:
        IcdError: unfitting data, a field for ``dp3``, which has none, unusable device, see also
            ``train_policy``.
    """
    check_device(order.device)
    if name != DIFFUSION_POLICY and field is not None:
        raise InvalidOptionError(f"field={str(field)!r} cannot be used: {name} sees points")
    demonstrations = read_demonstrations(order.env_id, order.data, order.split)
    about = {**about_of(demonstrations, order.episodes), "solved_only": solved_only}
    network = None
    if name == DIFFUSION_POLICY:
        folder = local_field(order.env_id, field)
        network, about["field"] = load_field(folder), weights_sha256(folder)
    config = policy_config(name, 0 if network is None else network.config.descriptor)
    windows = PolicyData(
        demonstrations,
        Look(config, network),
        config,
        episodes=order.episodes,
        solved_only=solved_only,
    )
    settings = TrainingConfig(
        steps=order.steps,
        learning_rate=LEARNING_RATE,
        warmup=500,
        weight_decay=1e-6,
        seed=order.seed,
    )
    with training(f"{name} of {order.env_id}", order.steps) as seen:
        trained = train_policy(
            windows, config, settings, order.out, about=about, device=order.device, seen=seen
        )
    keep_beside(field, order.out)
    return {
        "out": str(order.out),
        "episodes": windows.episodes,
        "parameters": trained.parameters,
        **trained.terms,
    }


def policy_config(name: str, scene_features: int) -> PolicyConfig:
    """Sizes of the policy of that name.

    Args:
        name: ``diffusion-policy`` or ``dp3``.
        scene_features: numbers by which the field describes a point; 0 without one.
    """
    sees: Sees = "points" if name == DP3 else "key points"
    return PolicyConfig(
        sees,
        scene_features,
        POINTS if name == DP3 else KEY_POINTS,
        POINTS if name == DP3 else SURFACE,
        prediction="sample",
        denoising_steps=10 if name == DP3 else 16,
        eta=0.0,
        temperature=TEMPERATURE,
    )
