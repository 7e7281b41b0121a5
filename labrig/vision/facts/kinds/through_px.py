"""Places on the strip, which its curve passes."""

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
class Through(StripFact):
    """Places on the strip's middle."""

    def constraints(self, value: tuple[Point, ...]) -> SearchConstraints:
        """See `StripFact.constraints`."""
        return SearchConstraints(through_px=value)


FACT = Through(
    name="through_px",
    meaning="raw pixels on the strip's middle between clamp and tip, in this order: the curve "
    "passes them",
    shape=FactShape.POINTS,
    option=FactOption(
        flag="--through",
        help="'U,V U,V ...': pixels on the strip's middle, from the clamp on; the curve passes "
        "them",
    ),
    example="40,30 60,35",
    tool=FactTool(
        label="On the strip",
        hint="On the strip: where a curve leaves it, click places on its middle, from the clamp "
        "on. For this photograph alone.",
        noun="place on the strip",
    ),
    order=30,
)
