"""All figures of a diagnosis."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from labrig.report.diagnosis.candidates import form_figure, ranking_figure, signatures_figure
from labrig.report.diagnosis.fits import curves_figure, forces_figure
from labrig.report.diagnosis.maps import residual_maps
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Drawn
from model.discrepancy.verdict.result import Diagnosis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIGURES: dict[str, tuple[str, str, Callable[[Diagnosis], Figure | None]]] = {
    "diagnosis-maps": (
        "Where the curves miss the simulation",
        (
            "Distance of the measured curve from the simulated one along its normal, a row for each"
            " position, before and with what was found; one scale for both."
        ),
        residual_maps,
    ),
    "diagnosis-forces": (
        "Forces before and after",
        (
            "Points: means of the readings. Lines: simulated before (dashed) and with what was"
            " found. Below: what is left; bars: 90 %, with the set-ups' scatter."
        ),
        forces_figure,
    ),
    "diagnosis-curves": (
        "Neutral curves before and after",
        "At the position that was missed most, all voltages.",
        curves_figure,
    ),
    "diagnosis-ranking": (
        "Candidates",
        "What the data say for each candidate; linear up to 10, logarithmic beyond.",
        ranking_figure,
    ),
    "diagnosis-form": (
        "The form as the data have it",
        "With its 90 % band. A family is found, not a formula.",
        form_figure,
    ),
    "diagnosis-signatures": (
        "What these data can tell apart",
        (
            "Effects whose signatures are alike cannot be told apart where they are weak; dashed:"
            " from here on one would be found."
        ),
        signatures_figure,
    ),
}


def draw_diagnosis(found: Diagnosis, figures: FigureFolder) -> dict[str, Drawn]:
    """Return every figure for which the diagnosis has data, by name."""
    return {
        one.name: one
        for name, (title, caption, draw) in FIGURES.items()
        for one in figures.draw(name, title, caption, partial(draw, found))
    }
