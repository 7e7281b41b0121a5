"""The contract of a check of a curve: it looks at one thing and returns at most one finding.

A check is asked about a fitted curve and returns a `CurveFinding`, or None where nothing is wrong.
The refusal of the check with the lowest order is the one that the user reads. A check must not
block, keeps no state, and changes none of its arguments.

A thick strip, or one of which little is stated, is found between its edges. The checks of the stage
`OUTLINE`, and those of other distributions, are then asked once, with a `SeenOutline`, which has
what both kinds share and more.
"""

# ruff: noqa: ARG002 - the method that a check overrides does nothing with what it is given

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import numpy.typing as npt

from labrig.vision.checks.seen_curve import SeenCurve

FloatArray = npt.NDArray[np.float64]
Pixel = tuple[float, float]  # column, row


class CheckStage(StrEnum):
    """When a check is asked."""

    CANDIDATE = "candidate"  # each fitted curve, to choose between them
    CHOSEN = "chosen"  # the chosen curve, once what lies along and beside it was measured
    UNCERTAINTY = "uncertainty"  # the same with its whole uncertainty, after all widening
    OUTLINE = "outline"  # a curve between two edges, in place of all of these


@dataclass(frozen=True, eq=False, kw_only=True)
class CurveFinding:
    """What a check says of one curve: a refusal, a warning, a widening, or several of them."""

    refusal: str = ""  # a sentence; empty: no reason to refuse it
    refused_at_px: Pixel | None = None  # where that shows; None: nowhere in particular
    warning: str = ""  # a sentence without its full stop; empty: none
    widening_px: FloatArray | None = None  # (nodes,): added to the uncertainty, in quadrature
    end_widening_px: float = 0.0  # along the curve, to that of a measured end, in quadrature


@dataclass(frozen=True, kw_only=True)
class CurveCheck:
    """One kind of fault of a curve.

    `refusal` and `warning` are what it says, with a place for each value: `{beyond_mm:.1f}`.
    """

    name: str  # also of its file
    looks_at: str  # a noun phrase
    refusal: str = ""  # names the step that failed, and what mends it
    warning: str = ""
    stage: CheckStage = CheckStage.CANDIDATE
    order: int  # of the sentences; of several refusals the first is told

    def finding(self, seen: SeenCurve) -> CurveFinding | None:
        """Return what is wrong with this curve; None: nothing."""
        return None

    def refuse(self, at_px: Pixel | None = None, **values: float | str) -> CurveFinding:
        """Return its refusal with these values, and the pixel where it shows.

        Raises ValueError where it has none, or one with a place for another value.
        """
        return CurveFinding(refusal=_text("refusal", self.refusal, values), refused_at_px=at_px)

    def warn(
        self,
        widening_px: FloatArray | None = None,
        end_widening_px: float = 0.0,
        **values: float | str,
    ) -> CurveFinding:
        """Return its warning with these values, and what it adds to the uncertainties.

        Raises ValueError where it has none, or one with a place for another value.
        """
        return CurveFinding(
            warning=_text("warning", self.warning, values),
            widening_px=widening_px,
            end_widening_px=end_widening_px,
        )


def _text(what: str, text: str, values: Mapping[str, float | str]) -> str:
    if not text:
        raise ValueError(f"its {what} is empty, so nothing can be said with it")
    try:
        return text.format(**values)
    except KeyError as error:
        raise ValueError(f"its {what} has a place for {error}, which is given no value") from None
