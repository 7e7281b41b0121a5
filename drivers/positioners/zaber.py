"""A Zaber rotary stage that carries the load cell along the arc, by Zaber's ASCII protocol.

The position on the arc is angle times radius. A command is `/1 1 move abs 12800`; its reply
`@01 1 OK BUSY -- 0`: device, axis, accepted (OK) or rejected (RJ), state, gravest warning, data.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from drivers.interfaces import (
    Clock,
    DeviceError,
    DeviceIdentity,
    DeviceTimeoutError,
    LimitError,
    Operator,
    Positioner,
    Prompt,
)
from drivers.positioners.contract import PositionerKind, Surroundings
from drivers.positioners.zaber_warnings import HARMLESS, NO_REFERENCE, in_words, is_fault
from drivers.serial_port import SerialLine

BAUD_RATE = 115200
RST_MICROSTEP_RAD = math.radians(0.000234375)  # X-RST and X-RSW stages at 64 microsteps
_SPEED_UNIT = 1.6384  # a speed setting is this many times microsteps per second
_REPLY = re.compile(r"^@(\d\d) (\d) (OK|RJ) (BUSY|IDLE) (--|[A-Z]{2}) (.*)$")
_POLL_S = 0.05
_MARGIN_S = 2.0
_REPLY_S = 1.0
_HOMING_S = 120.0
_MOVE_MOST_S = 300.0
_MOST = 2**31  # of any setting, and of its reverse
_MOST_UNASKED = 100  # alerts before an answer
_SHOWN = 80  # characters of a reply in an error


@dataclass(frozen=True, kw_only=True)
class ZaberSettings:
    """A rotary stage on a serial line, by Zaber's ASCII protocol."""

    port: str = field(
        metadata={"description": "serial port, such as COM3 or /dev/ttyUSB0, or simulated"}
    )
    address: int = field(
        default=1, metadata={"ge": 1, "le": 99, "description": "device number on the Zaber chain"}
    )
    origin_deg: float = field(
        default=0.0, metadata={"unit": "deg", "description": "stage angle at position 0 of the arc"}
    )
    home: bool = field(
        default=False,
        metadata={
            "description": "sweep to the home sensor when the stage has lost its reference; "
            "nothing may stand in its way"
        },
    )


@dataclass(frozen=True)
class _Reply:
    busy: bool
    warning: str
    data: str


class ZaberStage:
    """A `Positioner` on a rotary stage.

    `origin_rad`: the stage's angle where position 0 of the arc lies; `direction` is -1 where its
    angle grows against the arc. A stage without its reference (after power-up) must be homed, which
    sweeps it to its end: `home` does so, and `open` only when `home_on_open`, or when there is an
    `operator` who confirms that nothing is in the way.
    """

    def __init__(
        self,
        port: str,
        clock: Clock,
        radius_m: float,
        origin_rad: float = 0.0,
        direction: int = 1,
        microstep_rad: float = RST_MICROSTEP_RAD,
        device: int = 1,
        home_on_open: bool = False,
        operator: Operator | None = None,
        serial_factory: Callable[..., Any] | None = None,
    ) -> None:
        self._line = SerialLine("Zaber stage", port, BAUD_RATE, _REPLY_S, serial_factory)
        self._clock = clock
        self._steps_per_m = direction / (radius_m * microstep_rad)
        self._origin_steps = origin_rad / microstep_rad
        self._device = device
        self._home_on_open = home_on_open
        self._operator = operator
        self._range_steps = (0, 0)
        self._steps_per_s = 1.0
        self.warnings: list[str] = []  # in words, as they came up; the caller may clear it

    def open(self) -> None:
        """See `Positioner.open`."""
        self._line.open()
        try:
            self._line.drop_input()
            self._range_steps = (self._get("limit.min"), self._get("limit.max"))
            self._steps_per_s = max(1.0, self._get("maxspeed") / _SPEED_UNIT)
            self._check_reference()
        except DeviceError:
            self._line.close()
            raise

    def home(self) -> None:
        """Sweep to the home sensor, which makes positions known. Nothing may stand in the way."""
        self._forget_fault()
        self._ask("home")
        self._wait_until_idle(_HOMING_S, "homing")

    def move_to(self, position_m: float) -> bool:
        """See `Positioner.move_to`."""
        target = self._target_steps(position_m)
        distance = abs(target - self._get("pos"))
        self._forget_fault()
        self._ask(f"move abs {target}")
        # Twice: it accelerates too. What it says of itself may be nonsense, so there is an end.
        allowed_s = min(2.0 * distance / self._steps_per_s + _MARGIN_S, _MOVE_MOST_S)
        what = f"moving to {position_m * 1e3:g} mm"
        self._wait_until_idle(allowed_s, what)
        reached = self._get("pos")
        if abs(reached - target) > 1:
            raise DeviceError(
                f"{self._line.name}: {what} ended at {self._metres(reached) * 1e3:.3f} mm; free "
                "its way and repeat"
            )
        return True

    def position(self) -> float | None:
        """See `Positioner.position`."""
        return self._metres(self._get("pos"))

    def travel_m(self) -> tuple[float, float]:
        """See `LimitedTravel.travel_m`."""
        low_m, high_m = sorted(self._metres(steps) for steps in self._range_steps)
        return low_m, high_m

    def identities(self) -> tuple[DeviceIdentity, ...]:
        """See `Identified.identities`. A stage tells numbers; its maker lists what they name."""
        device = self._told("device.id") or self._told("deviceid")
        return (
            DeviceIdentity(
                name=self._line.name,
                maker="Zaber",
                product=f"device {device}" if device else "",
                serial=self._told("system.serial"),
                driver=f"firmware {self._told('version')}",
            ),
        )

    def close(self) -> None:
        """See `Positioner.close`; it stays where it is."""
        self._line.close()

    def _may_home(self) -> bool:
        if self._operator is None:
            return False
        text = (
            "The stage has no reference position and must be homed: move the sheet and all else "
            "out of its way."
        )
        return self._operator.ask(Prompt(kind="confirm", text=text))

    def _forget_fault(self) -> None:
        """Clear a fault that was reported before; one that lasts comes again."""
        if is_fault(self._ask("").warning):
            self._ask("warnings clear")

    def _check_reference(self) -> None:
        warning = self._ask("").warning
        if is_fault(warning):
            raise DeviceError(f"{self._line.name} cannot move: {in_words(warning)}")
        if warning not in NO_REFERENCE:
            return
        if not (self._home_on_open or self._may_home()):
            raise DeviceError(
                f"{self._line.name} has no reference position: move everything out of its way and "
                "home it"
            )
        self.home()

    def _metres(self, steps: float) -> float:
        return (steps - self._origin_steps) / self._steps_per_m

    def _target_steps(self, position_m: float) -> int:
        exact = self._origin_steps + position_m * self._steps_per_m
        low, high = self._range_steps
        if not low <= exact <= high:  # NaN is refused too
            low_m, high_m = self.travel_m()
            raise LimitError(
                f"{self._line.name}: position {position_m * 1e3:g} mm is outside its range of "
                f"{low_m * 1e3:.2f} to {high_m * 1e3:.2f} mm; it was not moved"
            )
        return round(exact)

    def _wait_until_idle(self, allowed_s: float, what: str) -> None:
        began_s = self._clock.now()
        while True:
            reply = self._ask("")
            if is_fault(reply.warning):
                self._stop()
                raise DeviceError(
                    f"{self._line.name}: {what} failed: {in_words(reply.warning)}; free its way "
                    "and home it"
                )
            if not reply.busy:
                return
            if self._clock.now() - began_s > allowed_s:
                self._stop()
                raise DeviceTimeoutError(
                    f"{self._line.name}: {what} took more than {allowed_s:.1f} s; it was stopped"
                )
            self._clock.sleep_until(self._clock.now() + _POLL_S)

    def _stop(self) -> None:
        """Best effort; the failure that led here is the one to report."""
        with suppress(DeviceError):
            self._ask("stop")

    def _told(self, setting: str) -> str:
        """Return a setting of the device; empty where its firmware does not have it."""
        try:
            return self._ask(f"get {setting}", axis=0).data.split()[0][:_SHOWN]
        except (DeviceError, IndexError):
            return ""

    def _get(self, setting: str) -> int:
        data = self._ask(f"get {setting}").data
        try:
            number = float(data.split()[0])
            if abs(number) <= _MOST:  # so written, NaN is refused too
                return round(number)
        except (ValueError, IndexError):
            pass
        raise DeviceError(
            f"{self._line.name} answered '{data[:_SHOWN]}' when asked for {setting}; a number of "
            "at most 32 bits was expected"
        )

    def _ask(self, command: str, axis: int = 1) -> _Reply:
        self._line.write(f"/{self._device} {axis} {command}".rstrip().encode("ascii") + b"\n")
        for _ in range(_MOST_UNASKED):
            line = self._line.read_line(b"\n").decode("ascii", errors="replace")
            if not line.endswith("\n"):
                raise DeviceTimeoutError(
                    f"{self._line.name} did not answer '{command or 'status'}' (got "
                    f"{line[:_SHOWN]!r}); check power, cable, baud rate and that its protocol is "
                    "ASCII"
                )
            if not line.startswith(("!", "#")):  # alerts and info come unasked
                return self._reply(command, line.strip())
        raise DeviceTimeoutError(
            f"{self._line.name} sends alerts without end (the last is {line[:_SHOWN]!r}) and no "
            f"answer to '{command or 'status'}'; switch it off and on again"
        )

    def _reply(self, command: str, line: str) -> _Reply:
        match = _REPLY.match(_without_checksum(line))
        if match is None or int(match.group(1)) != self._device:
            raise DeviceError(
                f"{self._line.name} answered '{line[:_SHOWN]}' to '{command or 'status'}', which "
                f"is no reply of device {self._device}"
            )
        accepted, busy, warning, data = match.groups()[2:]
        if accepted == "RJ":
            raise DeviceError(
                f"{self._line.name} rejected '{command or 'status'}': {data[:_SHOWN]}"
            )
        if warning not in HARMLESS and in_words(warning) not in self.warnings:
            self.warnings.append(in_words(warning))
        return _Reply(busy == "BUSY", warning, data)


def _without_checksum(line: str) -> str:
    """Return the reply without the checksum, `:` and two hexadecimal digits."""
    return re.sub(r":[0-9A-F]{2}$", "", line)


def _make(settings: ZaberSettings, around: Surroundings) -> Positioner:
    return ZaberStage(
        settings.port,
        around.clock,
        around.arc_radius_m,
        origin_rad=math.radians(settings.origin_deg),
        device=settings.address,
        home_on_open=settings.home,
        operator=around.operator,
        serial_factory=around.transport,
    )


POSITIONER = PositionerKind(
    kind="zaber",
    help="a Zaber rotary stage on a serial port",
    settings=ZaberSettings,
    make=_make,
)
