"""What every extra must keep to: the checks that a new one is put through."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice
from numbers import Real

from protocols.errors import ScheduleError
from protocols.extras.contract import Extra, ExtraRun
from protocols.kinds.conformance import accepted_out_of_bounds, declared_faults, planned
from protocols.kinds.pulse_train import PulseTrain
from protocols.planning.limits import structure_faults
from protocols.planning.schedule import Purpose

LARGEST_POSITION_M = 1.0  # either way along the arc; a place of a protocol goes no farther
_MAX_FAULTS = 5  # that are worth reporting at once


def faults(extra: object) -> list[str]:
    """Return what is wrong with an extra, a phrase each; empty for a good one.

    It is a class: `faults(Release)`. Never raises, but for what the extra's own code raises other
    than ScheduleError.
    """
    if not (isinstance(extra, type) and issubclass(extra, Extra)):
        return ["it is no subclass of protocols.extras.contract.Extra"]
    found = list(declared_faults(extra, Extra, "runs"))
    if found:
        return found
    try:
        made = extra()
        found = list(islice(_run_faults(made), _MAX_FAULTS))
    except ScheduleError as error:
        return [f"its defaults are refused: {error}"]
    return found or list(accepted_out_of_bounds(made))


def _run_faults(extra: Extra) -> Iterator[str]:
    returned: object = extra.runs(PulseTrain(), (0.0, 0.01))
    if not isinstance(returned, Iterable):  # other people's may return anything
        yield f"`runs` returned {type(returned).__name__}; it must yield each ExtraRun"
        return
    runs = list(returned)
    if not runs:
        yield "by default it adds no run to two positions"
    wrong = [fault for run in runs for fault in _faults_of(run)]
    if wrong:
        yield from wrong
        return
    for run in runs:
        free = run.position_m is None
        yield from structure_faults(
            planned(
                run.parts,
                position_m=run.position_m,
                purpose=Purpose.FREE_SHAPE if free else Purpose.MEASUREMENT,
                move=run.move,
            )
        )
    if runs != list(extra.runs(PulseTrain(), (0.0, 0.01))):
        yield "its runs differ from one call to the next"
    yield from _faults_without_positions(extra)


def _faults_of(run: object) -> Iterator[str]:
    """Yield what is wrong with one run that an extra yielded."""
    if not isinstance(run, ExtraRun):
        yield f"`runs` must yield each ExtraRun; it yielded {type(run).__name__}"
        return
    position_m: object = run.position_m
    if position_m is None:
        return
    if isinstance(position_m, bool) or not isinstance(position_m, Real):
        yield f"position_m of a run is {position_m!r}, no number in m"
    elif abs(float(position_m)) > LARGEST_POSITION_M:
        yield f"position_m of a run is {float(position_m):g} m: is it in mm?"


def _faults_without_positions(extra: Extra) -> Iterator[str]:
    """Yield what it does where a place has free shapes alone."""
    try:
        runs = list(extra.runs(PulseTrain(), ()))
    except ScheduleError:
        raise
    except Exception as error:  # noqa: BLE001 - the usual one is positions_m[0]
        yield (
            f"where there are no positions (positions_m is empty) `runs` raised "
            f"{type(error).__name__}: {error}"
        )
        return
    if any(run.position_m is not None for run in runs):
        yield "by default it goes to a position where there are none"
