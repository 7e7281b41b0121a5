"""What an extra is: the contract of every file in this folder.

An extra adds runs to the measurements of each configuration. It is one frozen, keyword-only
dataclass, handed on as the module's `EXTRA`. In protocol.toml it is a key of [extras]: `true`, or
a table whose keys are the dataclass's fields. Fields are declared as those of a kind of protocol
(`protocols.kinds.contract`). Nothing here blocks or touches hardware; all methods may be called at
any time and from any thread, and may raise ScheduleError, whose text is one sentence part for the
user.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, ClassVar

from protocols.errors import ScheduleError
from protocols.kinds.bounds import require_bounds
from protocols.kinds.contract import ProtocolKind
from protocols.kinds.fields import LARGEST_COUNT, LARGEST_VOLTAGE_V
from protocols.planning.builder import StepsAndReadings
from protocols.planning.schedule import PlannedMove


@dataclass(frozen=True, kw_only=True)
class ExtraRun:
    """A run that an extra adds. Without readings it is recorded as series and frames alone."""

    parts: StepsAndReadings  # as a kind of protocol returns them
    position_m: float | None = None  # along the arc; None: the load cell is away from the sheet
    keep_all_frames: bool = False  # whatever [camera] says; such a run needs a camera
    move: PlannedMove | None = None  # of the load cell, while the run is acquired at 0 V


@dataclass(frozen=True, kw_only=True)
class Extra(ABC):
    """One extra, with the values of its keys; checked when it is created."""

    name: ClassVar[str]  # of its key in [extras] and of its module or entry point
    by_default: ClassVar[bool] = False  # whether mode "default" has it
    dynamic: ClassVar[bool] = False  # whether it is recorded for the model of the sheet in time

    def __post_init__(self) -> None:
        require_bounds(self)
        self.check()

    def check(self) -> None:  # noqa: B027 - most extras need none
        """Raise ScheduleError where values that are within their bounds do not fit together."""

    @abstractmethod
    def runs(self, protocol: ProtocolKind, positions_m: tuple[float, ...]) -> Iterator[ExtraRun]:
        """Yield the runs of one configuration that `protocol` measures at these positions.

        Those without the load cell take place before the measurements, the others after them.
        """


def voltages_or_own(description: str) -> Any:
    """Return a field for voltages at the sheet; without any the extra takes the protocol's."""
    return field(
        default=(),
        metadata={
            "items": {"ge": -LARGEST_VOLTAGE_V, "le": LARGEST_VOLTAGE_V},
            "max_length": LARGEST_COUNT,
            "unit": "V",
            "description": description,
        },
    )


def positions_or_middle(description: str) -> Any:
    """Return a field for positions in mm; without any the extra takes the place's middle one."""
    return field(
        default=(),
        metadata={
            "items": {"ge": -1000.0, "le": 1000.0},
            "max_length": LARGEST_COUNT,
            "unit": "mm",
            "description": description,
        },
    )


def largest_V(protocol: ProtocolKind) -> float:
    """Return the largest positive voltage of a protocol; the largest of all where none is.

    Raises ScheduleError for a protocol that applies none.
    """
    if not protocol.driven_V:
        raise ScheduleError(f"the {protocol.name} applies no voltage; state the extra's own")
    return max(protocol.driven_V, key=lambda voltage_V: (voltage_V > 0, abs(voltage_V)))


def middle(positions_m: tuple[float, ...]) -> tuple[float, ...]:
    """Return the middle one of some positions; none of none."""
    return tuple(sorted(positions_m)[len(positions_m) // 2 :][:1])
