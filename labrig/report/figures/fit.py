"""Figures 8 and 9 of a fit alone, without a report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from labrig.report.data.models import Models
from labrig.report.figures.force import force_figure
from labrig.report.figures.moment import moment_figure
from labrig.report.parts.style import DEFAULT_FORMATS, save_all
from model import Fit, Measurements

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ABREAST = 4  # panels; further ones go to a figure of their own


def write_fit_figures(
    folder: Path,
    fit: Fit,
    measurements: Measurements,
    formats: Sequence[str] = DEFAULT_FORMATS,
) -> list[Path]:
    """Write them into a folder that is there and return their paths.

    Figure 8 shows those sheets whose EIBM is known to vary; without neutral curves there are none.
    """
    models = Models(fit.varying_model, fit.model)
    names = list(fit.configurations)
    varying = [n for n in names if _varies(fit, n)]
    return [
        *_write(folder, "figure-8", varying, lambda some: moment_figure(models, some), formats),
        *_write(
            folder,
            "figure-9",
            names,
            lambda some: force_figure(measurements, some, models),
            formats,
        ),
    ]


def _varies(fit: Fit, name: str) -> bool:
    return any(np.ptp(Me) > 0 for Me, _ in fit.configurations[name].eibm_along_Nm.values())


def _write(
    folder: Path,
    name: str,
    sheets: Sequence[str],
    draw: Callable[[list[str]], Figure],
    formats: Sequence[str],
) -> list[Path]:
    written = []
    for number, first in enumerate(range(0, len(sheets), ABREAST), start=1):
        own = name if number == 1 else f"{name}-{number}"
        written += save_all(draw(list(sheets[first : first + ABREAST])), folder, own, formats)
    return written
