"""The direction at the clamp: a second place on the strip near it."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.facts.contract import (
    Directed,
    FactOf,
    FactOption,
    FactShape,
    Point,
    StripFact,
)

ALONG_SIGMA_RAD = 0.1  # of a direction that is read from a photograph


@dataclass(frozen=True, kw_only=True)
class Along(StripFact):
    """A direction, which optics.json keeps as such."""

    def directed(self, optics: Directed, value: Point) -> Directed:
        """See `StripFact.directed`."""
        return optics.leading_to(value, ALONG_SIGMA_RAD)


FACT = Along(
    name="along_px",
    meaning="a raw pixel further along the clamped strip's line; states its direction",
    shape=FactShape.POINT,
    of=FactOf.PICTURE,
    option=FactOption(
        flag="--along-px",
        help="U,V: a second pixel on the strip near the clamp: its direction, and the x axis",
    ),
    example="40,30",
    order=20,
)
