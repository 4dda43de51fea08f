"""``icd-bench train`` for the learned baselines."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from typing import Annotated

import typer

from benchmarks.console import AsJson, errors_in_one_line, say
from benchmarks.network_commands import (
    AS_SHIPPED,
    Data,
    Device,
    Env,
    Episodes,
    Field,
    Out,
    Seed,
    Steps,
)
from benchmarks.training_order import TrainingOrder

LatentSteps = Annotated[int, typer.Option(min=1, help="Optimiser steps of the autoencoder.")]


def train_subgoal_diffuser(
    env: Env,
    data: Data,
    out: Out,
    field: Field = None,
    device: Device = "cpu",
    latent_steps: LatentSteps = 4000,
    steps: Steps = 8000,
    episodes: Episodes = 1500,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Train the baseline Subgoal Diffuser: autoencoder and denoiser of object clouds."""
    with errors_in_one_line():
        from benchmarks.train_subgoal_diffuser import train

        order = TrainingOrder(env, data, out, device, steps, episodes, seed)
        say(train(order, field=field, latent_steps=latent_steps), as_json)


def train_global_ndf(
    env: Env,
    data: Data,
    out: Out,
    device: Device = "cpu",
    field_steps: Annotated[
        int | None,
        typer.Option(min=1, help="Optimiser steps of the field.", show_default=AS_SHIPPED),
    ] = None,
    latent_steps: LatentSteps = 4000,
    steps: Steps = 8000,
    episodes: Episodes = 1500,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Train the baseline Global NDF: a field with one code a scene, and ICD's networks on it."""
    with errors_in_one_line():
        from benchmarks.train_global_ndf import train

        order = TrainingOrder(env, data, out, device, steps, episodes, seed)
        say(train(order, field_steps=field_steps, latent_steps=latent_steps), as_json)


def _policy_command(name: str) -> Callable[..., None]:
    """Make the command that trains an action-chunk policy."""

    def train_policy(
        env: Env,
        data: Data,
        out: Out,
        field: Field = None,
        device: Device = "cpu",
        steps: Steps = 8000,
        episodes: Episodes = 1500,
        solved_only: Annotated[
            bool,
            typer.Option(
                "--solved-only/--all-episodes", help="Which recorded episodes are imitated."
            ),
        ] = True,
        seed: Seed = 0,
        as_json: AsJson = False,
    ) -> None:
        with errors_in_one_line():
            from benchmarks.train_policy import train

            order = TrainingOrder(env, data, out, device, steps, episodes, seed)
            say(train(name, order, field=field, solved_only=solved_only), as_json)

    return train_policy


def train_sac_her(
    env: Env,
    out: Out,
    device: Device = "cpu",
    steps: Annotated[int, typer.Option(min=1, help="Control steps.")] = 60_000,
    seed: Seed = 0,
    as_json: AsJson = False,
) -> None:
    """Train the baseline SAC with hindsight, in training scenes; needs the extra rl."""
    with errors_in_one_line():
        from icd_envs.errors import InvalidOptionError

        if importlib.util.find_spec("stable_baselines3") is None:
            raise InvalidOptionError("it needs pip install 'implicit-contact-diffuser[rl]'")
        from benchmarks.train_sac import train

        say(train(env, out, device=device, steps=steps, seed=seed), as_json)


def offer(train: typer.Typer) -> None:
    """Add the commands to ``icd-bench train``."""
    train.command("subgoal-diffuser")(train_subgoal_diffuser)
    train.command("global-ndf")(train_global_ndf)
    train.command("sac-her")(train_sac_her)
    for name, paper_name in (
        ("diffusion-policy", "Diffusion Policy"),
        ("dp3", "3D Diffusion Policy"),
    ):
        help_text = f"Train the baseline {paper_name} on recorded actions."
        train.command(name, help=help_text)(_policy_command(name))
