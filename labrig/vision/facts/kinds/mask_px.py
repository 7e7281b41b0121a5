"""What is not used of the pictures: polygons around what confuses."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.facts.contract import (
    FactOf,
    FactOption,
    FactShape,
    FactTool,
    Polygon,
    SearchConstraints,
    StripFact,
)


@dataclass(frozen=True, kw_only=True)
class Mask(StripFact):
    """Pixels that are not used."""

    def joined(
        self, before: tuple[Polygon, ...], stated: tuple[Polygon, ...]
    ) -> tuple[Polygon, ...]:
        """See `StripFact.joined`: what is masked in the file stays masked."""
        return before + stated

    def constraints(self, value: tuple[Polygon, ...]) -> SearchConstraints:
        """See `StripFact.constraints`."""
        return SearchConstraints(hidden_px=value)


FACT = Mask(
    name="mask_px",
    meaning="polygons of raw pixels; what is inside of them is not used",
    shape=FactShape.POLYGONS,
    of=FactOf.PICTURE,
    option=FactOption(
        flag="--mask",
        help="what is not used: a JSON file of polygons, or one polygon 'U,V U,V U,V'; "
        "may be repeated",
        repeated=True,
    ),
    example="0,0 20,0 20,10",
    tool=FactTool(
        label="Mask",
        hint="Mask: click the corners around what confuses; then close the polygon.",
        noun="mask",
    ),
    order=10,
)
