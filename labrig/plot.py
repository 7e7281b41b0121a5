"""Figures for scripts and notebooks: each function draws into matplotlib axes and returns them.

The drawing is that of the reports. `ax`: axes to draw into; by default a new figure of pyplot.
Lengths are drawn in mm, forces in mN, moments in µN·m.

Example:
    >>> ax = labrig.plot.forces("session.h5", found, configuration="long")  # doctest: +SKIP
    >>> ax.figure.savefig("forces.png")  # doctest: +SKIP

"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from labrig.api.data import Data, measurements_of, model_of
from labrig.errors import BadInputError, type_in_words
from labrig.files import AnyPath
from labrig.motion.simulated import SimulatedRun
from labrig.report.data.models import ALONG, CONSTANT, kind_of
from labrig.report.data.selection import configurations
from labrig.report.diagnosis.candidates import draw_ranking
from labrig.report.diagnosis.fits import draw_forces_before_and_after
from labrig.report.diagnosis.maps import configurations as configurations_of
from labrig.report.figures.force import draw_forces
from labrig.report.figures.moment import draw_moments
from labrig.report.figures.shapes import draw_curve, draw_curves, draw_setup
from labrig.report.parts.style import INK, colour_of, label_of, styled
from model import Curve, Fit, Prediction, SheetModel
from model.discrepancy import Diagnosis
from model.dynamics import SheetMotion
from model.measurements.known_arguments import known_arguments

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["curves", "diagnosis", "diagnosis_forces", "eibm", "forces", "motion", "shapes"]


def __dir__() -> list[str]:
    """Return what draws, and not what is imported for it."""
    return list(__all__)


# quantity of a motion -> label, and the factor to its unit
_QUANTITIES = {
    "force_N": ("force F (mN)", 1e3),
    "reading_N": ("reading of the load cell (mN)", 1e3),
    "normal_N": ("normal force N (mN)", 1e3),
    "current_A": ("current (mA)", 1e3),
    "drive_V": ("voltage of the source (V)", 1.0),
    "sheet_V": ("voltage of the sheet (V)", 1.0),
    "s_hat_m": ("contact along the sheet (mm)", 1e3),
    "tip_x_m": ("tip x (mm)", 1e3),
    "tip_y_m": ("tip y (mm)", 1e3),
}


@known_arguments
def forces(
    data: Data,
    model: Fit | SheetModel | AnyPath | None = None,
    *,
    configuration: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw forces over position: means, standard deviation of the readings, simulated lines.

    Args:
        data: a session file or `Measurements`.
        model: a `Fit` (both its models are drawn), a model or a model file; None: no lines.
        configuration: which sheet; needed where several were measured.
        ax: axes to draw into.

    Returns:
        The axes. Raises LabrigError for a configuration that was not measured.

    """
    measurements = measurements_of(data, None)
    name = _chosen(configuration, configurations(measurements))
    with _axes(ax) as axes:
        draw_forces(axes, measurements, name, list(_models(model)))
        axes.set_ylabel("force F (mN)")
        axes.legend()
    return axes


@known_arguments
def curves(data: Data, *, configuration: str | None = None, ax: Axes | None = None) -> Axes:
    """Draw the measured neutral curves of all conditions, the arc and the clamp.

    Args:
        data: a session file or `Measurements`.
        configuration: which sheet; needed where several were measured.
        ax: axes to draw into.

    Returns:
        The axes, with equal aspect. Raises LabrigError for a configuration not measured.

    """
    measurements = measurements_of(data, None)
    name = _chosen(configuration, configurations(measurements))
    with _axes(ax) as axes:
        draw_curves(axes, measurements, name)
        axes.legend()
    return axes


@known_arguments
def eibm(
    model: Fit | SheetModel | AnyPath,
    *,
    configuration: str | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the EIBM along the sheet with its 90 % band; of a `Fit` the constant one, too (dashed).

    Args:
        model: a `Fit`, a model or a model file.
        configuration: which sheet; needed where the model has several.
        ax: axes to draw into.

    Returns:
        The axes. Raises LabrigError for a configuration that the model lacks.

    """
    known = model.varying_model if isinstance(model, Fit) else model_of(model)
    name = _chosen(configuration, list(known.sheets))
    with _axes(ax) as axes:
        draw_moments(axes, known, name, model.model if isinstance(model, Fit) else None)
        axes.set_ylabel("EIBM (µN·m)")
        axes.legend()
    return axes


@known_arguments
def shapes(
    predictions: Prediction | Iterable[Prediction],
    model: SheetModel | AnyPath,
    *,
    ax: Axes | None = None,
) -> Axes:
    """Draw predicted shapes with the arc and the clamp; what is not reachable is left out.

    Args:
        predictions: one prediction, or several of one configuration (`labrig.simulate`).
        model: the model that they are of, for the sheet's lengths and the arc.
        ax: axes to draw into.

    Returns:
        The axes, with equal aspect. Raises LabrigError where there are several configurations.

    """
    every = _predictions(predictions)
    name = _only([one.configuration for one in every])
    sheet = model_of(model).sheet(name).sheet
    with _axes(ax) as axes:
        draw_setup(axes, sheet, sorted({one.position_m for one in every}))
        drawn: set[float] = set()
        among = {one.voltage_V for one in every}
        for one in every:
            if one.reachable:
                label = None if one.voltage_V in drawn else label_of(one.voltage_V)
                drawn.add(one.voltage_V)
                shape = Curve(s_m=one.s_m, x_m=one.x_m, y_m=one.y_m)
                colour = colour_of(one.voltage_V, among)
                draw_curve(axes, shape, sheet, colour=colour, label=label)
        axes.legend()
    return axes


def _predictions(given: Prediction | Iterable[Prediction]) -> list[Prediction]:
    if isinstance(given, Prediction):
        return [given]
    every = list(given) if isinstance(given, Iterable) else [given]
    for one in every:
        if not isinstance(one, Prediction):  # a caller may give anything
            raise BadInputError(
                "predictions are needed, as labrig.predict and labrig.simulate return them, not "
                f"{type_in_words(one)}."
            )
    return every


@known_arguments
def diagnosis(found: Diagnosis, *, ax: Axes | None = None) -> Axes:
    """Draw the evidence for each candidate; named effects are green.

    Args:
        found: what `labrig.diagnose` returned.
        ax: axes to draw into.

    Returns:
        The axes. Raises LabrigError where nothing was searched.

    """
    _require_diagnosis(found)
    if not found.ranking:
        raise BadInputError(f"there is no ranking to draw: {found.sentence}")
    with _axes(ax) as axes:
        draw_ranking(axes, found)
    return axes


@known_arguments
def diagnosis_forces(
    found: Diagnosis, *, configuration: str | None = None, ax: Axes | None = None
) -> Axes:
    """Draw measured forces (points), and those simulated before (dashed) and after the diagnosis.

    Args:
        found: what `labrig.diagnose` returned.
        configuration: which sheet; needed where several were measured.
        ax: axes to draw into.

    Returns:
        The axes. Raises LabrigError for a configuration that was not measured.

    """
    _require_diagnosis(found)
    name = _chosen(configuration, configurations_of(found))
    with _axes(ax) as axes:
        draw_forces_before_and_after(axes, found, name)
        axes.set(xlabel="position p (mm)", ylabel="force F (mN)")
        axes.legend()
    return axes


@known_arguments
def motion(
    run: SimulatedRun | SheetMotion, quantity: str = "force_N", *, ax: Axes | None = None
) -> Axes:
    """Draw one quantity of a simulated motion over time.

    Args:
        run: what `labrig.simulate_in_time` returned.
        quantity: force_N, reading_N, normal_N, current_A, drive_V, sheet_V, s_hat_m, tip_x_m or
            tip_y_m.
        ax: axes to draw into.

    Returns:
        The axes. Raises LabrigError for another quantity.

    """
    if quantity not in _QUANTITIES:
        raise BadInputError(f"a motion has no {quantity!r}; give one of {', '.join(_QUANTITIES)}.")
    moved = run.motion if isinstance(run, SimulatedRun) else run
    name = quantity.removeprefix("tip_")
    values = np.asarray(getattr(moved, name))
    label, factor = _QUANTITIES[quantity]
    with _axes(ax) as axes:
        axes.plot(moved.time_s, factor * (values if values.ndim == 1 else values[:, -1]), color=INK)
        axes.set(xlabel="time (s)", ylabel=label)
    return axes


@contextmanager
def _axes(ax: Axes | None) -> Iterator[Axes]:
    """Yield the axes to draw into, in the style of the reports where they are new."""
    if ax is not None:
        from matplotlib.axes import Axes as AnyAxes

        if not isinstance(ax, AnyAxes):  # a caller may give anything, such as an array of them
            raise BadInputError(f"ax: one matplotlib Axes is needed, not {type_in_words(ax)}.")
        yield ax
        return
    from matplotlib import pyplot as plt

    with styled():
        yield plt.subplots()[1]


def _require_diagnosis(found: object) -> None:
    if not isinstance(found, Diagnosis):
        raise BadInputError(
            f"found: what labrig.diagnose returns is needed, not {type_in_words(found)}."
        )


def _chosen(configuration: str | None, known: list[str]) -> str:
    if configuration is None and len(known) == 1:
        return known[0]
    if configuration in known and configuration is not None:
        return configuration
    given = "give configuration=" if configuration is None else f"there is no {configuration!r}; "
    raise BadInputError(f"{given}one of {', '.join(known) or 'none: nothing was measured'}.")


def _only(names: list[str]) -> str:
    """Return the one configuration that predictions are of."""
    known = list(dict.fromkeys(names))
    if not known:
        raise BadInputError("there is no prediction to draw.")
    if len(known) > 1:
        raise BadInputError(
            f"the predictions are of {', '.join(known)}; draw those of one configuration."
        )
    return known[0]


def _models(model: Fit | SheetModel | AnyPath | None) -> Iterator[tuple[str, SheetModel]]:
    if isinstance(model, Fit):
        yield ALONG, model.varying_model
        yield CONSTANT, model.model
    elif model is not None:
        given = model_of(model)
        yield kind_of(given), given
