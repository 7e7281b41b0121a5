"""Where the strip ends."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.facts.contract import (
    FactOption,
    FactShape,
    FactTool,
    Point,
    SearchConstraints,
    StripFact,
)


@dataclass(frozen=True, kw_only=True)
class Tip(StripFact):
    """The strip's end; its length is measured up to there."""

    def constraints(self, value: Point) -> SearchConstraints:
        """See `StripFact.constraints`."""
        return SearchConstraints(tip_px=value)


FACT = Tip(
    name="tip_px",
    meaning="the raw pixel where the strip ends; its length is measured up to there",
    shape=FactShape.POINT,
    option=FactOption(flag="--tip-px", help="U,V: where the strip ends; no length need be stated"),
    example="90,40",
    tool=FactTool(
        label="Tip",
        hint="Tip: click where the strip ends; no length need be stated then. For this photograph "
        "alone.",
        noun="tip",
    ),
    order=40,
)
