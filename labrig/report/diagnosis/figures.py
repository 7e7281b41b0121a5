"""All figures of a diagnosis: drawn, written as PNG and SVG, and handed on for a page."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.report.diagnosis.candidates import form_figure, ranking_figure, signatures_figure
from labrig.report.diagnosis.fits import curves_figure, forces_figure
from labrig.report.diagnosis.maps import residual_maps
from labrig.report.figures.all_figures import Drawn
from labrig.report.parts.style import save_pair
from labrig.report.parts.svg import inline
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


def draw_diagnosis(found: Diagnosis, folder: Path) -> dict[str, Drawn]:
    """Every figure that there is something for, by name; files of the others are removed."""
    folder.mkdir(parents=True, exist_ok=True)
    drawn = {}
    for name, (title, caption, draw) in FIGURES.items():
        fig = draw(found)
        if fig is None:
            for ending in ("png", "svg"):
                (folder / f"{name}.{ending}").unlink(missing_ok=True)
            continue
        save_pair(fig, folder, name)
        svg = (folder / f"{name}.svg").read_text(encoding="utf-8")
        drawn[name] = Drawn(name, title, caption, inline(svg, name, f"{title}. {caption}"))
    return drawn
