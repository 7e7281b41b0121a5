"""That the strip is seen to its end, so that its length is measured."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.facts.contract import FactOf, FactOption, FactShape, SearchConstraints, StripFact


@dataclass(frozen=True, kw_only=True)
class ToEnd(StripFact):
    """Whatever length is stated, the strip is followed to its visible end."""

    def constraints(self, value: bool) -> SearchConstraints:
        """See `StripFact.constraints`."""
        return SearchConstraints(length_measured=value)


FACT = ToEnd(
    name="to_end",
    meaning="true: whatever length is stated, the strip is followed to its visible end",
    shape=FactShape.FLAG,
    of=FactOf.PICTURE,
    option=FactOption(
        flag="--to-end", help="follow the strip to its visible end; no length need be stated"
    ),
    order=50,
)
