"""All figures of a diagnosis."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from labrig.report.diagnosis.candidates import form_figure, ranking_figure, signatures_figure
from labrig.report.diagnosis.fits import at_set_ups, curves_figure, forces_figure
from labrig.report.diagnosis.maps import residual_maps
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Drawn
from model.discrepancy.verdict.result import Diagnosis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURES: dict[str, tuple[str, str, Callable[[Diagnosis], Figure | None]]] = {
    "diagnosis-maps": (
        "Residuals of the neutral curves",
        (
            "Distance of the measured curve from the simulated one along its normal, a row for each"
            " position, before and after; one scale for both. The set-ups are nominal."
        ),
        residual_maps,
    ),
    "diagnosis-forces": (
        "Forces before and after",
        (
            "Points: means of the readings. Lines: simulated before (dashed) and after (solid),"
            " {at}. Below: measured − simulated with nominal set-ups; bars: 90 %, with the scatter"
            " between set-ups."
        ),
        forces_figure,
    ),
    "diagnosis-curves": (
        "Neutral curves before and after",
        "The position with the largest error, all voltages; simulated {at}.",
        curves_figure,
    ),
    "diagnosis-ranking": (
        "Candidates",
        "Evidence for each candidate; the axis is linear up to 10 and logarithmic beyond.",
        ranking_figure,
    ),
    "diagnosis-form": (
        "Form of the effect, estimated and in the catalogue",
        "Band: 90 %. The kind of effect is found, not its formula.",
        form_figure,
    ),
    "diagnosis-signatures": (
        "Similarity and detectability of the effects",
        (
            "Effects with similar signatures cannot be told apart where they are weak. Dashed: the"
            " detectability from which on an effect would be found."
        ),
        signatures_figure,
    ),
}


_AT_SET_UPS = (
    "at each set-up's estimated offsets (position, tilt, zero, B and EIBM of that mounting)"
)
_NOMINAL = "with nominal set-ups, whose offsets this diagnosis does not hold"


def draw_diagnosis(found: Diagnosis, figures: FigureFolder) -> dict[str, Drawn]:
    """Return every figure for which the diagnosis has data, by name."""
    at = _AT_SET_UPS if at_set_ups(found) else _NOMINAL
    return {
        one.name: one
        for name, (title, caption, draw) in FIGURES.items()
        for one in figures.draw(name, title, caption.format(at=at), partial(draw, found))
    }
