"""``icd-bench train``, ``diagnose`` and ``render``: the networks that methods are made of."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Final, Literal

import typer

from benchmarks.console import AsJson, errors_in_one_line

GROUPS: Final = {
    "train": typer.Typer(help="Train a network from recorded demonstrations."),
    "diagnose": typer.Typer(help="Measure a network in test scenes."),
    "render": typer.Typer(help="Draw what a network has learned."),
}
Env = Annotated[str, typer.Option(help="Environment id.")]
Weights = Annotated[
    Path | None,
    typer.Option(help="Folder of a trained network.", show_default="those of the package"),
]
AS_SHIPPED: Final = "as for the package's weights"
Seed = Annotated[int, typer.Option(min=0, help="Of every draw.")]


@GROUPS["train"].callback()
@GROUPS["diagnose"].callback()
@GROUPS["render"].callback()
def _group() -> None:
    """Make Typer keep the name of a group's only command."""


@GROUPS["train"].command("field")
def train_field(
    env: Env,
    data: Annotated[Path, typer.Option(help="Folder that icd-bench collect has filled.")],
    out: Annotated[Path, typer.Option(help="Folder of the run; a killed one goes on.")],
    device: Annotated[str, typer.Option(help="cpu, or cuda.")] = "cpu",
    steps: Annotated[
        int | None, typer.Option(min=1, help="Optimiser steps.", show_default=AS_SHIPPED)
    ] = None,
    scenes: Annotated[int, typer.Option(min=1, help="Episodes whose scenes are used.")] = 1500,
    seed: Seed = 0,
    scope: Annotated[
        Literal["local", "global"], typer.Option(help="global: one code for the whole scene.")
    ] = "local",
    length_scale: Annotated[
        float | None,
        typer.Option(help="Metres beyond which distances count less.", show_default=AS_SHIPPED),
    ] = None,
    outlook_scale: Annotated[
        float | None,
        typer.Option(help="Metres a point at a surface looks out.", show_default=AS_SHIPPED),
    ] = None,
    near_spread: Annotated[
        float | None,
        typer.Option(help="Metres around surfaces to learn about.", show_default=AS_SHIPPED),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Train the scene descriptor field."""
    with errors_in_one_line():
        from benchmarks.tables import print_values
        from benchmarks.train_field import Scales, scales_of, train

        usual = scales_of(env)
        scales = Scales(
            usual.length if length_scale is None else length_scale,
            usual.outlook if outlook_scale is None else outlook_scale,
            usual.near if near_spread is None else near_spread,
            usual.steps if steps is None else steps,
        )
        values = train(env, data, out, scope, scales, device=device, scenes=scenes, seed=seed)
    if as_json:
        typer.echo(json.dumps(values))
    else:
        print_values(values)


@GROUPS["diagnose"].command("field")
def diagnose_field(
    env: Env,
    scenes: Annotated[int, typer.Option(min=1, help="Test scenes.")] = 10,
    seed: Seed = 0,
    weights: Weights = None,
    as_json: AsJson = False,
) -> None:
    """Measure the scene descriptor field: truth, invariance, interpolation, ranking of plans."""
    with errors_in_one_line():
        from benchmarks.diagnose_field import diagnose
        from benchmarks.tables import print_values

        values = diagnose(env, scenes, seed=seed, weights=weights)
    if as_json:
        typer.echo(json.dumps(values))
    else:
        print_values(values)


@GROUPS["render"].command("field")
def render_field(
    env: Env,
    out: Annotated[Path, typer.Option(help="PNG file to write.")],
    seed: Seed = 0,
    weights: Weights = None,
) -> None:
    """Draw slices of the field, its gradients, and the object coloured by descriptor."""
    with errors_in_one_line():
        from benchmarks.render_field import render

        render(env, out, seed=seed, weights=weights)
