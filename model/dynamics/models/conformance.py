"""What every published model must fulfil: `faults` finds nothing in a good one."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import isfinite

import numpy as np

from model.dynamics.models.contract import QUANTITIES, DrivenSheet, PublishedModel, Response
from model.measurements import FloatArray, SheetGeometry
from model.plugins import first_faults

TEXTS = ("title", "source", "equations")
SHEET = SheetGeometry(
    configuration="example", free_length_m=0.05, width_m=0.011, thickness_m=3e-4,
    elongation_m=0.0, arc_radius_m=0.04, arc_origin_rad=0.0,
    initial_curvature=(np.array([0.0, 0.05]), np.array([5.0, 2.0])),
)  # fmt: skip
FRAMES = np.array([0, 300, 599])


def example_run(position_m: float | None, drive_V: FloatArray | float = 1.0) -> DrivenSheet:
    """Return 0.6 s of an example, at 1 kHz."""
    time: FloatArray = np.linspace(0.0, 0.599, 600)
    drive = np.broadcast_to(np.asarray(drive_V, dtype=float), time.shape).copy()
    return DrivenSheet(
        sheet=SHEET, position_m=position_m, time_s=time, drive_V=drive, frames=FRAMES
    )


def faults(model: object) -> list[str]:
    """Return what is wrong with a model, a sentence each without its full stop."""
    if not isinstance(model, PublishedModel):
        return [f"it is of type {type(model).__name__}, not a model.dynamics.models.PublishedModel"]
    checks = (_description, _parameters, _responses, _rest)
    return first_faults(partial(check, model) for check in checks)


def _description(model: PublishedModel) -> Iterator[str]:
    if not (isinstance(model.name, str) and model.name.isidentifier()):
        yield f"its name {model.name!r} must be one word of letters, digits and underscores"
    for name in TEXTS:
        text = getattr(model, name)
        if not (isinstance(text, str) and text.strip()):
            yield f"its {name} is empty"
    if not model.from_source and not str(model.title).startswith("after "):
        yield "its equations are not from the source, so its title must begin with 'after'"
    for name in sorted((model.predicts_in_contact | model.predicts_free) - {*QUANTITIES}):
        yield f"'{name}' is no quantity: {', '.join(QUANTITIES)}"
    if not model.predicts_in_contact | model.predicts_free:
        yield "it predicts nothing"


def _parameters(model: PublishedModel) -> Iterator[str]:
    names = [one.name for one in model.parameters]
    if len({*names}) < len(names) or not names:
        yield "it needs parameters of different names"
    for one in model.parameters:
        if not (one.unit and one.meaning):
            yield f"its parameter '{one.name}' needs a unit and a meaning"
        if not (isfinite(one.low) and one.low <= one.start <= one.high < np.inf):
            yield f"the start of its parameter '{one.name}' is not between finite bounds"
        if not one.prior_scale > 0.0:
            yield f"the prior scale of its parameter '{one.name}' is not positive"


def _responses(model: PublishedModel) -> Iterator[str]:
    """Check that it predicts what it says, of the right shape, finite, and twice the same."""
    for run, where in ((example_run(0.01), "in contact"), (example_run(None), "free")):
        before = run.time_s.copy(), run.drive_V.copy(), run.frames.copy()
        response, again = (model.simulate(model.start(), run) for _ in range(2))
        if not isinstance(response, Response):
            yield "its `simulate` must return a Response"  # type: ignore[unreachable]
            return
        given = dict(_quantities(response))
        if {*given} != model.predicts(run):
            yield (
                f"{where} it says that it predicts {sorted(model.predicts(run))},"
                f" but it returns {sorted(given)}"
            )
        for name, value in given.items():
            first = len(FRAMES) if name == "curve" else len(run.time_s)
            if value.ndim != 1 + (name == "curve") or len(value) != first:
                yield f"{where} its {name} has the shape {value.shape}"
            elif not np.all(np.isfinite(value)):
                yield f"{where} its {name} is not finite"
        if any(
            not np.array_equal(a, b)
            for (_, a), (_, b) in zip(_quantities(response), _quantities(again), strict=True)
        ):
            yield "it does not return the same twice"
        after = run.time_s, run.drive_V, run.frames
        if not all(np.array_equal(a, b) for a, b in zip(before, after, strict=True)):
            yield "it changes its arguments"


def _rest(model: PublishedModel) -> Iterator[str]:
    """Without voltage nothing changes and no current flows."""
    for position_m in (0.01, None):
        for name, value in _quantities(model.simulate(model.start(), example_run(position_m, 0.0))):
            if np.ptp(value, axis=0).max() > 1e-9 * max(1e-6, float(np.max(np.abs(value)))):
                yield f"without voltage its {name} changes"
            if name == "current" and np.any(value != 0.0):
                yield "without voltage it predicts a current"


def _quantities(response: Response) -> Iterator[tuple[str, FloatArray]]:
    given = (response.force_N, response.current_A, response.tip_m)
    for name, value in zip(QUANTITIES, given, strict=False):
        if value is not None:
            yield name, value
    if response.curves_m is not None:
        yield "curve", response.curves_m[1]
