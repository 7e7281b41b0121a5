"""A controlled run: controller.toml and the reference of the force, made into a schedule."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from labrig.control.controller_file import ControllerConfig
from labrig.errors import BadInputError
from labrig.session.tables.decimals import from_milli, from_plain
from labrig.session.tables.table import table_of
from labrig.session.tables.text.meaning import ExpectedColumns
from protocols import ScheduleError
from protocols.planning.controlled import controlled
from protocols.planning.schedule import ForceStep, Schedule

CONTROLLER, REFERENCE = "controller.toml", "reference.csv"  # names among a session's texts
_COLUMNS = ExpectedColumns(kind="reference", required=("time_s", "force_mN"), renamed=False)
_MOST_ROWS = 100_000


def parse_reference(text: str, name: str) -> tuple[tuple[ForceStep, ...], float]:
    """Return the force's steps, N above that at 0 V, and the run's end in s: the last row's time.

    Raises BadInputError naming the line.
    """
    steps: list[ForceStep] = []
    for row in table_of(text, Path(name), _COLUMNS).rows():
        time_s = row.get("time_s", from_plain, "a number")
        if not steps and time_s != 0.0:
            raise row.fault(f"time_s = {time_s:g}: a reference begins at 0")
        if steps and time_s <= steps[-1].time_s:
            raise row.fault(f"time_s = {time_s:g} does not come after {steps[-1].time_s:g}")
        steps.append(ForceStep(time_s, row.get("force_mN", from_milli, "a number")))
        if len(steps) > _MOST_ROWS:
            raise BadInputError(f"{name}: a reference has at most {_MOST_ROWS} rows.")
    if len(steps) < 2:
        raise BadInputError(
            f"{name}: a reference has two rows at least; the time of the last one is the run's end."
        )
    return tuple(steps[:-1]), steps[-1].time_s


def controlled_schedule(
    schedule: Schedule, controller: ControllerConfig, reference: str, called: Mapping[str, str]
) -> Schedule:
    """Return the protocol's runs at the controller's place, with the reference for their pulses.

    called: what errors call the files.
    """
    steps, end_s = parse_reference(reference, called[REFERENCE])
    try:
        return controlled(
            schedule, controller.configuration, 1e-3 * controller.position_mm, steps, end_s
        )
    except ScheduleError as error:
        raise BadInputError(f"{called['protocol.toml']}: {error}.") from None
