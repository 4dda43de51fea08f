"""A moment in words, for every view."""

from __future__ import annotations

from typing import Final

from benchmarks.watch.session import Moment

NAMES: Final = ("episode", "step", "success", "complete", "plan", "end")


def describe(moment: Moment) -> dict[str, str]:
    """Names and values for the person watching."""
    values = (
        f"{moment.episode} (seed {moment.seed})",
        f"{moment.step} of {moment.budget}",
        "yes" if moment.success else "no",
        f"{moment.complete_rate:.0%}",
        moment.plan.status if moment.plan is not None else "none shown",
        moment.end or "not yet",
    )
    return dict(zip(NAMES, values, strict=True))
