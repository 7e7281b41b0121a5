"""What every extra must keep to: the checks that a new one is put through."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from protocols.errors import ScheduleError
from protocols.extras.contract import Extra
from protocols.kinds.conformance import accepted_out_of_bounds, declared_faults, planned
from protocols.kinds.pulse_train import PulseTrain
from protocols.planning.limits import structure_faults
from protocols.planning.schedule import Purpose

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
    runs = list(extra.runs(PulseTrain(), (0.0, 0.01)))
    if not runs:
        yield "by default it adds no run to two positions"
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
    if any(run.position_m is not None for run in extra.runs(PulseTrain(), ())):
        yield "by default it goes to a position where there are none"
