"""The faults of a simulated rig: the `[[faults]]` of a world.toml begin and end in time."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial

from drivers.interfaces import Clock
from sim_hardware.camera import CameraFaults
from sim_hardware.camera.faults import FaultSpan, from_frame
from sim_hardware.clock import VirtualClock
from sim_hardware.families.contract import SimulatedBoards, switch_of
from sim_hardware.serial_devices import SerialFaults
from sim_hardware.world import CellFault, FaultSettings, World

_FOR_GOOD_S = 1e12
_BEYOND_RANGE_V = 11.0
_ALL = from_frame(0)
# What of a `CameraFaults` each is.
_CAMERA = {
    "camera_late": "late",
    "camera_dropped": "drop",
    "camera_frozen": "freeze",
    "camera_black": "black",
    "camera_wrong_size": "wrong_size",
    "camera_gone": "gone",
}
_SERIAL = {
    "serial_garbage": "garbage",
    "serial_half_line": "half_line",
    "serial_silent": "silent",
}


@dataclass(kw_only=True)
class FaultyRig:
    """A simulated rig's parts, as far as something can go wrong with them."""

    clock: Clock
    world: World
    boards: SimulatedBoards
    camera: CameraFaults = field(default_factory=CameraFaults)
    serial: SerialFaults = field(default_factory=SerialFaults)
    # Those that act now. No lock: the world may call `_arm` under its own.
    _acting: list[FaultSettings] = field(default_factory=list, init=False)

    def begin(self) -> None:
        """From now on the world's faults come about at their times."""
        faults = self.world.settings.faults
        late = [fault for fault in faults if fault.since == "first_voltage"]
        self._arm([fault for fault in faults if fault.since == "beginning"], self.clock.now())
        if late:
            self.world.when_first_driven(lambda when: self._arm(late, when))

    def _arm(self, faults: Iterable[FaultSettings], origin_s: float) -> None:
        moments: list[tuple[float, Callable[[], None]]] = []
        for fault in faults:
            from_s = origin_s + fault.from_s
            until_s = _FOR_GOOD_S if fault.until_s is None else origin_s + fault.until_s
            if fault.what in _CAMERA:
                what = _CAMERA[fault.what]
                late_s = fault.amount_s if what == "late" else 0.0
                self.camera.spans.append(
                    FaultSpan(what=what, from_s=from_s, until_s=until_s, late_s=late_s)
                )
                continue
            self._switch(fault)  # raises now where the boards do not have this fault
            moments.append((from_s, partial(self._begin, fault)))
            if fault.until_s is not None:
                moments.append((until_s, partial(self._end, fault)))
        moments.sort(key=lambda moment: moment[0])
        while moments and moments[0][0] <= self.clock.now():
            moments.pop(0)[1]()
        if moments:
            self.clock.start_thread(lambda: self._live_through(moments), "faults")

    def _live_through(self, moments: list[tuple[float, Callable[[], None]]]) -> None:
        for when, act in moments:
            self.clock.sleep_until(when)
            act()

    def _begin(self, fault: FaultSettings) -> None:
        self._acting.append(fault)
        self._switch(fault)[0]()

    def _end(self, fault: FaultSettings) -> None:
        """End a fault, and not what others of its kind, or of the same device, do meanwhile."""
        self._acting.remove(fault)
        if all(other.what != fault.what for other in self._acting):
            self._switch(fault)[1]()
        for other in list(self._acting):
            if other.what != "clock_jump" and _device_of(other) == _device_of(fault):
                self._switch(other)[0]()

    def _switch(self, fault: FaultSettings) -> tuple[Callable[[], None], Callable[[], None]]:
        """Return how it begins, and how it ends."""
        what = fault.what
        if what in _SERIAL:
            name = _SERIAL[what]
            return (
                lambda: setattr(self.serial, name, _ALL),
                lambda: setattr(self.serial, name, ()),
            )
        if what == "serial_unplugged":
            return switch_of(self.serial, "unplugged", on=True, off=False)
        if what == "clock_jump":
            return lambda: self._jump(fault.amount_s), _nothing
        if what.startswith("cell_"):
            kind = CellFault.OPEN if what == "cell_unplugged" else CellFault.OVERLOADED
            world = self.world
            return (
                lambda: world.break_load_cell(kind),
                lambda: world.break_load_cell(CellFault.NONE),
            )
        if what == "current_saturated":
            world = self.world
            return (
                lambda: world.break_input("current", _BEYOND_RANGE_V),
                lambda: world.break_input("current", None),
            )
        return self.boards.fault(what, fault.amount_s)

    def _jump(self, seconds: float) -> None:
        if isinstance(self.clock, VirtualClock):  # the computer's clock cannot be made to
            self.clock.jump(seconds)


def _device_of(fault: FaultSettings) -> str:
    return fault.what.partition("_")[0]


def _nothing() -> None:
    """Do nothing: the fault ends by itself."""
