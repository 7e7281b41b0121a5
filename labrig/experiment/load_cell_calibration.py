"""Calibrate the load cell of a rig with dead weights."""

from __future__ import annotations

import datetime as dt
import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drivers.interfaces import Prompt
from drivers.load_cell import CalibrationError, LoadCellCalibration
from drivers.load_cell_fit import CalibrationFit, fit_calibration
from labrig.config.load_cell import FORCE_UNIT
from labrig.config.templates import NOT_CALIBRATED
from labrig.errors import BadInputError, NotReadyError, StoppedError
from labrig.experiment.plan import Plan
from labrig.experiment.rig.rig import Rig, opened
from labrig.files import discard, not_written, part_of
from protocols.execution.operator import NoAnswerError

LISTEN_S = 2.0  # to each weight
# A cell's sensitivity stays within a percent for years; a factor is a wrong weight or another cell.
LARGEST_CHANGE = 1.5


def _nothing_more(load_N: float, mean_V: float) -> None:
    """Nobody draws the line while it grows."""


@dataclass(frozen=True)
class DeadWeightSeries:
    """Each weight with the mean voltage it gave, and the line through them."""

    loads_N: tuple[float, ...]
    volts: tuple[float, ...]
    fit: CalibrationFit
    calibration: LoadCellCalibration


def weigh(
    rig: Rig,
    plan: Plan,
    loads_N: Sequence[float],
    tell: Callable[[str], None],
    on_mean: Callable[[float, float], None] = _nothing_more,
) -> DeadWeightSeries:
    """Ask for one weight after the other, listen to each, fit a line. The output stays at 0 V.

    `on_mean` is called with each weight in N and the mean voltage it gave.
    """
    if plan.resolved()[FORCE_UNIT] == "N":
        raise BadInputError(
            f'rig.toml: [force_sensor] kind = "{plan.rig.force_sensor.kind}" reports newtons by '
            "itself; calibrate it as its manual says, or leave [force_sensor] out."
        )
    _check_loads(loads_N, plan.calibration.capacity_N)
    volts: list[float] = []
    with _answered(), opened(rig):
        for load_N in loads_N:
            volts.append(_listen(rig, load_N, tell))
            on_mean(load_N, volts[-1])
        range_V = rig.signals.ranges_V[list(rig.signals.channels).index("force")]
        rig.operator.ask(
            Prompt(kind="dead_weight", text="Take every weight off the load cell.", load_N=0.0)
        )
    try:
        fit = fit_calibration(loads_N, volts)
    except CalibrationError as error:
        raise BadInputError(f"{error}.") from None
    before = plan.calibration
    _check_sensitivity(fit.sensitivity_V_per_N, before)
    made = fit.calibration(
        date=dt.datetime.now(dt.UTC).date(),
        capacity_N=before.capacity_N,
        input_range_V=range_V,
        excitation_V=before.excitation_V,
        gain=before.gain,
        serial=before.serial,
    )
    return DeadWeightSeries(tuple(loads_N), tuple(volts), fit, made)


@contextmanager
def _answered() -> Iterator[None]:
    """Raise NotReadyError where the operator cannot be asked: a session ends by itself then."""
    try:
        yield
    except NoAnswerError as error:
        raise NotReadyError(f"{str(error).rstrip('.')}.") from None


def _check_loads(loads_N: Sequence[float], capacity_N: float) -> None:
    """Refuse what would harm the cell, before anybody hangs it there."""
    largest_N = max(loads_N, key=abs)
    if not abs(largest_N) <= capacity_N:
        raise BadInputError(
            f"a weight of {1e3 * largest_N:g} mN is above the load cell's capacity of "
            f"{1e3 * capacity_N:g} mN (load_cell.toml); weights are given in mN, 9.81 for a gram."
        )


def _check_sensitivity(found_V_per_N: float, before: LoadCellCalibration) -> None:
    """Refuse a line that is far from the last calibration's, if there ever was one."""
    if before.date == NOT_CALIBRATED:
        return
    ratio = found_V_per_N / before.sensitivity_V_per_N
    if not 1 / LARGEST_CHANGE < ratio < LARGEST_CHANGE:
        raise BadInputError(
            f"these weights give {found_V_per_N:.4g} V/N, the last calibration "
            f"{before.sensitivity_V_per_N:.4g} V/N; check the weights, or for another cell set "
            "sensitivity_V_per_N in load_cell.toml to its nominal value."
        )


def _listen(rig: Rig, load_N: float, tell: Callable[[str], None]) -> float:
    what = f"Hang {1e3 * load_N:g} mN on the load cell" if load_N else "Take every weight off"
    prompt = Prompt(kind="dead_weight", text=f"{what} and wait until it is still.", load_N=load_N)
    if not rig.operator.ask(prompt):
        raise StoppedError("stopped; no calibration was written.")
    row = list(rig.signals.channels).index("force")
    volts = rig.signals.measure(LISTEN_S)[row]
    if rig.load_cell.is_at_the_rail(volts):
        raise BadInputError(
            f"with {1e3 * load_N:g} mN the force input is at the end of its range; use less weight "
            f"or a larger [{rig.config.boards_kind}] ranges_V force, or look for a broken wire."
        )
    mean_V = float(np.mean(volts))
    tell(f"{1e3 * load_N:8.2f} mN  {1e3 * mean_V:+.5f} mV")
    return mean_V


def write_calibration(made: LoadCellCalibration, path: Path) -> Path | None:
    """Write load_cell.toml, beside its place first; an older one is kept as NAME.DATE.toml.

    Returns that of the older one; None where there was none.
    """
    lines = [
        "# Calibration of the load cell with dead weights: volts = offset + sensitivity * force.",
        f"date = {made.date.isoformat()}",
        f"capacity_mN = {1e3 * made.capacity_N!r}",
        f"sensitivity_V_per_N = {made.sensitivity_V_per_N!r}",
        f"sensitivity_sigma_V_per_N = {made.sensitivity_sigma_V_per_N!r}",
        f"offset_V = {made.offset_V!r}",
        f"offset_sigma_V = {made.offset_sigma_V!r}",
        f"excitation_V = {made.excitation_V!r}",
        f"gain = {made.gain!r}",
        f"serial = {json.dumps(made.serial)}",
    ]
    part = part_of(path)
    try:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")
        kept = path.replace(_kept_name(path)) if path.exists() else None
        part.replace(path)
    except OSError as error:
        discard(part)
        raise not_written(path, error) from None
    return kept


def _kept_name(path: Path) -> Path:
    """Return a free name for the calibration that is replaced."""
    day = dt.datetime.fromtimestamp(path.stat().st_mtime, dt.UTC).date().isoformat()
    names = (f"{path.stem}.{day}{n}.toml" for n in ("", *(f".{i}" for i in range(1, 1000))))
    return next(path.with_name(name) for name in names if not path.with_name(name).exists())
