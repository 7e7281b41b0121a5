"""The simulated world: what the boards, the camera and the serial devices are wired to."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from drivers.interfaces import Clock
from sim_hardware.optics import Renderer
from sim_hardware.world.history import history_of
from sim_hardware.world.loading import WorldError
from sim_hardware.world.mechanics import Stage
from sim_hardware.world.record import Record
from sim_hardware.world.settings import Signal, WorldSettings
from sim_hardware.world.setup import MountedSheet, Scatter
from sim_hardware.world.sheet_states import ObservableStates
from sim_hardware.world.signals.amplifier import SimulatedAmplifier
from sim_hardware.world.signals.electrical import ElectricalSignals
from sim_hardware.world.signals.load_cell import CellFault, SimulatedLoadCell
from sim_hardware.world.signals.supply_relay import SupplyRelay
from sim_hardware.world.view import contact_of, shape_of

FloatArray = npt.NDArray[np.float64]

_INPUTS: tuple[Signal, ...] = ("force", "current", "readback")
_DRIVEN_V = 0.05
_ROWS_PER_S = 100


class World:
    """One sheet in its clamp, with amplifier, load cell and camera.

    It is the `AnalogSide` and the `OpticalSide` of a simulated rig. It begins with the first
    configuration mounted, the load cell away, and 0 V. May be used by several threads. The same
    calls at the same clock times give the same values, bit by bit.
    """

    def __init__(self, settings: WorldSettings, clock: Clock) -> None:
        self.settings = settings
        self._clock = clock
        self._lock = threading.RLock()
        self._render_lock = threading.Lock()
        self._renderer = Renderer(settings.camera, settings.seed)
        self._record: Record | None = None
        self._recorded_s = -np.inf
        self._drawn = 0
        self._turned_over = False
        self._amplifier = SimulatedAmplifier(settings.amplifier, clock.now())
        self._cell = SimulatedLoadCell(settings.load_cell, settings.seed)
        self._relay = SupplyRelay(settings.interlock.hold_s, closed=not settings.interlock.line)
        if settings.interlock.line:
            self._amplifier.supply(clock.now(), on=False)
        self._driven_calls: list[Callable[[float], None]] = []
        self._broken: dict[str, float] = {}
        self._exposure_s = settings.camera.exposure_s
        self._trigger_calls: list[Callable[[float], None]] = []
        self._electrical = ElectricalSignals(settings.electrical, self._amplifier, settings.seed)
        first = Stage(
            start_s=clock.now(), setup=self._new_setup(next(iter(settings.configurations)), None)
        )
        self._history = history_of(settings, self._amplifier, self._cell, first, self._watch)
        self._warm_up()

    # ------------------------------------------------------------------------- the operator's

    @property
    def configuration(self) -> str:
        """The configuration that is mounted."""
        with self._lock:
            return self._history.stage.setup.configuration

    @property
    def position_m(self) -> float | None:
        """The position of the load cell; None: away from the sheet."""
        with self._lock:
            return self._history.stage.setup.position_m

    def mount(self, configuration: str) -> None:
        """Put another configuration into the clamp; the load cell is away afterwards."""
        if configuration not in self.settings.configurations:
            names = ", ".join(self.settings.configurations)
            raise WorldError(f"the simulated world has no configuration {configuration}: {names}")
        self._set_up(configuration, None)

    def place(self, position_m: float | None, approach: Literal["up", "down"] = "up") -> None:
        """Put the load cell to a position along the arc, from below or above; None: away."""
        with self._lock:
            self._set_up(self.configuration, position_m, moved_up=approach == "up")

    def remount(self) -> None:
        """Take the sheet out and put it back, the load cell to where it was."""
        with self._lock:
            self._set_up(self.configuration, self.position_m)

    def turn_over(self) -> None:
        """Turn the rig over about the sheet's long axis: weight pulls the other way.

        What is mounted stays as it is. A rig that is turned over already stays so.
        """
        with self._lock:
            self._turned_over = True
            now, stage = self._now(), self._history.stage
            setup = replace(stage.setup, turned_over=True)
            self._history.begin(
                Stage(start_s=now, setup=setup, load_N=stage.load_N, moved_up=stage.moved_up)
            )
            self._write_row(now)

    def moisten(self) -> None:
        """Moisten the sheet."""
        with self._lock:
            self._now()
            self._history.moisten()

    def hang(self, load_N: float) -> None:
        """Hang a dead weight on the load cell (0: take it off); `place` and `mount` take it off."""
        with self._lock:
            now = self._now()
            self._history.begin(replace(self._history.stage, start_s=now, load_N=load_N))
            self._write_row(now)

    def break_load_cell(self, fault: CellFault) -> None:
        """Give the load cell this fault from now on."""
        with self._lock:
            self._cell.fail(fault, self._now() - self._history.start_s)

    def break_input(self, signal: Signal, volts: float | None) -> None:
        """Let a signal's input read these volts from now on; None: what is wired to it."""
        with self._lock:
            self._broken.pop(signal, None)
            if volts is not None:
                self._broken[signal] = volts

    def when_first_driven(self, call: Callable[[float], None]) -> None:
        """Call this, once, with the time at which a voltage other than 0 is first written."""
        with self._lock:
            self._driven_calls.append(call)

    # --------------------------------------------------------------------------------- boards

    def edge(self, line: str, when: float, *, high: bool = True) -> None:
        """Pass on the edge of a digital line (such as PCI6703/port0/line0)."""
        self._trigger(line.partition("/")[2], when, high=high)
        wired = self.settings.interlock.line
        if not wired or line.partition("/")[2] != wired:
            return
        with self._lock:
            self._watch_supply(when)
            if not self._relay.closed:
                self._history.advance(when)
                self._amplifier.supply(max(when, self._history.reached_s), on=True)
            self._relay.edge(when)
            self._write_row(when)

    def level(self, line: str, *, high: bool, when: float) -> None:
        """Pass on the level of a digital line that holds the relay by itself (such as EIO0)."""
        self._trigger(line, when, high=high)
        if not self.settings.interlock.line or line != self.settings.interlock.line:
            return
        with self._lock:
            self._history.advance(when)
            self._relay.hold(on=high)
            self._amplifier.supply(max(when, self._history.reached_s), on=high)
            self._write_row(when)

    def _trigger(self, line: str, when: float, *, high: bool) -> None:
        if high and line in self.settings.trigger.lines:
            for call in self._trigger_calls:
                call(when)

    def _watch_supply(self, until_s: float) -> None:
        """Before anything is asked of a time: the relay may have opened by then."""
        dropped_s = self._relay.drop(until_s)
        if dropped_s is not None:
            self._history.advance(dropped_s)
            self._amplifier.supply(max(dropped_s, self._history.reached_s), on=False)
            self._write_row(dropped_s)

    def write(self, device: str, channel: str, volts: float, when: float) -> None:
        """See `AnalogSide.write`. Only the terminal wired to the amplifier has an effect."""
        if self.settings.wiring.signal_at(device, channel) != "drive":
            return
        with self._lock:
            self._watch_supply(when)
            if volts != 0.0 and self._driven_calls:
                calls, self._driven_calls = self._driven_calls, []
                for call in calls:
                    call(when)
            self._history.advance(when)
            when = max(when, self._history.reached_s)
            before = self._amplifier.asked_V
            self._amplifier.write(volts, when)
            if self._amplifier.asked_V != before:
                self._write_row(when)

    def read(self, device: str, channel: str, times: FloatArray) -> FloatArray:
        """See `AnalogSide.read`. Inputs that nothing is wired to read 0 V."""
        signal = self.settings.wiring.signal_at(device, channel)
        times = np.asarray(times, dtype=np.float64)
        if times.size == 0 or signal in (None, "drive"):
            return np.zeros(times.shape)
        return self._volts(signal, times)

    def _volts(self, signal: Signal, times: FloatArray) -> FloatArray:
        """Volts at the input to which a signal is wired."""
        with self._lock:
            if signal in self._broken:
                return np.full(times.shape, self._broken[signal])
            self._watch_supply(float(times[-1]))
            since = times - self._history.start_s
            if signal == "force":
                states = self._history.at(times)
                return self._cell.volts(np.concatenate([m.felt_N for m in states]), since)
            if signal == "current":
                return self._electrical.current_V(self._history.current_A(times), since)
            self._history.advance(float(times[-1]))
            return self._electrical.readback_V(times, since)

    def true_force_N(self, when: float) -> float:
        """Force along the load cell's axis, without noise or faults of the cell."""
        with self._lock:
            return float(self._sheet_states(when).true_N[0])

    def true_shape(self, when: float) -> FloatArray:
        """Return the neutral curve (n, 2) in m, from the clamp's end to the visible end."""
        with self._lock:
            return shape_of(self._sheet_states(when), 0)

    # --------------------------------------------------------------------------------- camera

    @property
    def frame_shape(self) -> tuple[int, int]:
        """See `OpticalSide.frame_shape`."""
        columns, rows = self.settings.camera.image_size
        return rows, columns

    @property
    def frame_rate_hz(self) -> float:
        """See `OpticalSide.frame_rate_hz`."""
        return self.settings.camera.frame_rate_hz

    @property
    def exposure_s(self) -> float:
        """The exposure of a frame."""
        return self._exposure_s

    def expose_for(self, exposure_s: float) -> None:
        """Set the exposure of each further frame."""
        self._exposure_s = exposure_s

    def when_triggered(self, call: Callable[[float], None]) -> None:
        """Call this with the time of each rising edge at the camera's trigger input."""
        self._trigger_calls.append(call)

    def image(self, when: float, number: int) -> npt.NDArray[np.uint8]:
        """See `OpticalSide.image`."""
        with self._lock:
            seen_s = when - self.settings.frame_delay_s
            self._watch_supply(seen_s)
            states = self._history.exposed(seen_s, self._exposure_s)
            shapes = [shape_of(m, k) for m in states for k in range(m.times.size)]
            contact = contact_of(states[-1])
            length_m = states[-1].stage.setup.chain.sheet.free_length_m
        with self._render_lock:
            return self._renderer.render(
                shapes, contact, number, sheet_length_m=length_m, time_s=when
            )

    # --------------------------------------------------------------------------------- record

    def record_to(self, path: Path) -> None:
        """Write what really happens to a CSV file, from now on."""
        with self._lock:
            if self._record is not None:
                self._record.close()
            self._record = Record(path)
            self._write_row(self._now())

    def close(self) -> None:
        """End the record. May be called twice."""
        with self._lock:
            if self._record is not None:
                self._write_row(self._now())
                self._record.close()
                self._record = None

    # ------------------------------------------------------------------------------ internals

    def _warm_up(self) -> None:
        """Compile what a session needs: on the real clock there is no time for it later."""
        now = np.array([self._history.start_s])
        setup = MountedSheet(
            settings=self.settings,
            configuration=self.configuration,
            position_m=0.0,
            scatter=Scatter(),
        )
        self._history.warm_up(Stage(start_s=float(now[0]), setup=setup))
        for signal in _INPUTS:
            self._volts(signal, now)
        self.image(float(now[0]), 0)

    def _now(self) -> float:
        """Return the clock's time, the state advanced to it: nothing done now acts earlier."""
        now = self._clock.now()
        self._watch_supply(now)
        self._history.advance(now)
        return max(now, self._history.reached_s, self._history.stage.start_s)

    def _new_setup(self, configuration: str, position_m: float | None) -> MountedSheet:
        scatter = Scatter.draw(self.settings, self._drawn)
        self._drawn += 1
        return MountedSheet(
            settings=self.settings,
            configuration=configuration,
            position_m=position_m,
            scatter=scatter,
            turned_over=self._turned_over,
        )

    def _set_up(
        self, configuration: str, position_m: float | None, *, moved_up: bool = True
    ) -> None:
        with self._lock:
            now = self._now()
            setup = self._new_setup(configuration, position_m)
            self._history.begin(Stage(start_s=now, setup=setup, moved_up=moved_up))
            self._write_row(now)

    def _sheet_states(self, when: float) -> ObservableStates:
        return self._history.at(np.array([when]))[-1]

    def _watch(self, times: FloatArray, sheet_V: FloatArray, force_N: FloatArray) -> None:
        """Record the force while the sheet is driven; the grid was made for these times."""
        if self._record is None:
            return
        drive_V, position_m = self._amplifier.asked_V, self._history.stage.setup.position_m
        for k in np.flatnonzero(np.abs(sheet_V) > _DRIVEN_V):
            if times[k] >= self._recorded_s + 1 / _ROWS_PER_S - 1e-9:
                self._record.row(float(times[k]), drive_V, float(force_N[k]), position_m)
                self._recorded_s = float(times[k])

    def _write_row(self, when: float) -> None:
        if self._record is not None:
            force_N = float(self._sheet_states(when).true_N[0])
            self._record.row(when, self._amplifier.asked_V, force_N, self.position_m)
