"""What a kind of protocol is: the contract of every file in this folder.

A kind is one frozen, keyword-only dataclass, handed on as the module's `PROTOCOL`. Its fields are
the keys of its table in protocol.toml; configuration, forms and JSON Schema are derived from them.
A field states in its metadata:

`description`   what it means; shown beside the form's field
`unit`          "V", "s", ...; fields in V are scaled by `scaled`
`gt` `ge` `lt` `le`   bounds of a number
`min_length` `max_length` `items`   bounds of a tuple's length, and those of each entry (a dict)
`repeats`       True where the number of readings grows with the field; used by `longer`

Fields are of type float, int, bool, str or tuple[float, ...], each with a default. Nothing here
blocks or touches hardware; all methods may be called at any time and from any thread, and may
raise ScheduleError, whose text is one sentence part for the user.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Self

from protocols.errors import ScheduleError
from protocols.kinds.bounds import require_bounds
from protocols.planning.builder import StepsAndReadings
from protocols.planning.pulses import Pulses

# What planning adds to a protocol that says nothing else: the paper's pulses, as measured there.
PULSE_S = 0.6
SAMPLE_AT_S = 0.5
HALF_WINDOW_S = 0.1
PULSES_DISCARDED = 2
ZERO_READINGS = 10
READINGS_PER_VOLTAGE = 10


@dataclass(frozen=True, kw_only=True)
class ProtocolKind(ABC):
    """One kind of protocol, with the values of its keys; checked when it is created."""

    name: ClassVar[str]  # of its table in protocol.toml and of its module or entry point

    def __post_init__(self) -> None:
        require_bounds(self)
        self.check()

    def check(self) -> None:  # noqa: B027 - most kinds need it, none has to have it
        """Raise ScheduleError where values that are within their bounds do not fit together."""

    @abstractmethod
    def steps_and_readings(self) -> StepsAndReadings:
        """Return steps, readings and duration (s) of one run, the last step at 0 V.

        The first step is at 0 s, times ascend, and each reading's window lies within its step.
        """

    def pulses(self) -> Pulses:
        """Return the pulses for what planning adds: free shapes and the load cell's zero.

        One pulse for each voltage of this protocol, unless a kind has pulses of its own.
        """
        voltages_V = self.driven_V
        return Pulses(
            voltages_V=voltages_V,
            zero_readings=ZERO_READINGS,
            pulses_discarded=PULSES_DISCARDED,
            readings_per_voltage=READINGS_PER_VOLTAGE,
            pulse_s=PULSE_S,
            sample_at_s=SAMPLE_AT_S,
            half_window_s=HALF_WINDOW_S,
            rest_s=PULSE_S if len(voltages_V) == 1 else 0.0,  # edges between equal voltages
        )

    @property
    def driven_V(self) -> tuple[float, ...]:
        """Voltages of the steps in the order in which they first appear, 0 V left out."""
        steps = self.steps_and_readings()[0]
        return tuple(dict.fromkeys(step.voltage_V for step in steps if step.voltage_V))

    def scaled(self, factor: float) -> Self:
        """Return the same protocol with all voltages multiplied by `factor`."""
        return replace(self, **self._changed("unit", "V", factor))

    def at_voltages(self, voltages_V: tuple[float, ...]) -> Self:
        """Return the same protocol at these voltages."""
        names = [field.name for field in fields(self) if field.metadata.get("unit") == "V"]
        if len(names) == 1 and isinstance(getattr(self, names[0]), tuple):
            return replace(self, **{names[0]: voltages_V})
        if len(names) == len(voltages_V):
            return replace(self, **dict(zip(names, voltages_V, strict=True)))
        raise ScheduleError(f"{len(voltages_V)} voltages do not fit into its keys")

    def longer(self, factor: int) -> Self:
        """Return the same protocol with `factor` times the readings at each voltage."""
        changed = self._changed("repeats", True, factor)  # noqa: FBT003 - a value of metadata
        if not changed:
            raise ScheduleError("no key makes it take more readings")
        return replace(self, **changed)

    def _changed(self, key: str, value: Any, factor: float) -> dict[str, Any]:
        """Return the fields with this metadata, multiplied by `factor`."""
        return {
            field.name: _multiplied(getattr(self, field.name), factor)
            for field in fields(self)
            if field.metadata.get(key) == value
        }


def _multiplied(value: Any, factor: float) -> Any:
    return tuple(factor * each for each in value) if isinstance(value, tuple) else factor * value
