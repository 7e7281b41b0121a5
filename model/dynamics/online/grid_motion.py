"""A motion that follows a run: on a grid of times, as far as the run has come."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from model.dynamics.beam import ContactSetup, DynamicBeam, HeldVoltage
from model.dynamics.motion import Simulation
from model.measurements import FloatArray

GRID_S = 0.005
POINTS = 21  # of a shape, evenly along sheet and elongation
SHAPES_KEPT = 1000  # grid times: 5 s


class Drive:
    """The writes of a run so far."""

    def __init__(self) -> None:
        self._times_s: list[float] = []
        self._volts: list[float] = []

    def add(self, time_s: float, voltage_V: float) -> None:
        """Add a write; one that is no later than the last replaces it."""
        if self._times_s and time_s <= self._times_s[-1]:
            self._volts[-1] = voltage_V
            return
        self._times_s.append(time_s)
        self._volts.append(voltage_V)

    def until(self, time_s: float) -> HeldVoltage:
        """Return what was written up to a time, at least 0 V."""
        count = int(np.searchsorted(self._times_s, time_s, side="right"))
        if not count:
            return HeldVoltage(np.zeros(1), np.zeros(1))
        return HeldVoltage(np.array(self._times_s[:count]), np.array(self._volts[:count]))


class GridMotion:
    """Force and current at all grid times so far, shapes at the last ones."""

    def __init__(self, beam: DynamicBeam, rolls: ContactSetup | None) -> None:
        """Begin in equilibrium at 0 V. Raises ModelError where there is none."""
        self._simulation = Simulation(beam, rolls, HeldVoltage(np.zeros(1), np.zeros(1)))
        self._force: list[FloatArray] = []
        self._current: list[FloatArray] = []
        self._x: list[FloatArray] = []
        self._y: list[FloatArray] = []
        self.count = 0  # grid times so far

    @property
    def time_s(self) -> float:
        """The last grid time; before the first -GRID_S."""
        return GRID_S * (self.count - 1)

    @property
    def slipped_s(self) -> float | None:
        """When the sheet left the rolls."""
        return self._simulation.slipped_s

    def advance(self, drive: Drive, time_s: float) -> None:
        """Go on to the last grid time that is not after this one. Raises ModelError."""
        count = int(time_s / GRID_S + 1e-6) + 1
        if count <= self.count:
            return
        times = np.asarray(GRID_S * np.arange(self.count, count), dtype=float)
        made = self._simulation.advance(drive.until(times[-1]), times)
        self._force.append(made.reading_N)
        self._current.append(made.current_A)
        self._x = _last([*self._x, made.x_m])
        self._y = _last([*self._y, made.y_m])
        self.count = count

    def force_N(self, first: int = 0) -> FloatArray:
        """Return the force at grid times `first` and later, as the load cell reads it."""
        return self._since(self._force, first)

    def current_A(self, first: int = 0) -> FloatArray:
        """Return the current at the same times."""
        return self._since(self._current, first)

    def shape_at(self, time_s: float) -> FloatArray | None:
        """Return the shape (POINTS, 2) at a time, in m; None where it is no longer, or not yet."""
        x = np.concatenate(self._x or [np.empty((0, POINTS))])
        y = np.concatenate(self._y or [np.empty((0, POINTS))])
        place = time_s / GRID_S - (self.count - len(x))
        if not 0.0 <= place <= len(x) - 1:
            return None
        low = min(int(place), len(x) - 2) if len(x) > 1 else 0
        share = place - low
        both = np.stack([x, y], axis=2)
        if not share:
            return np.asarray(both[low])
        return np.asarray((1.0 - share) * both[low] + share * both[low + 1])

    def _since(self, pieces: Sequence[FloatArray], first: int) -> FloatArray:
        found: list[FloatArray] = []
        begin = self.count
        for piece in reversed(pieces):
            begin -= len(piece)
            found.append(piece[max(0, first - begin) :])
            if begin <= first:
                break
        return np.concatenate(found[::-1]) if found else np.empty(0)


def _last(pieces: list[FloatArray]) -> list[FloatArray]:
    """Return the pieces without those that nobody asks for any more."""
    kept = sum(len(piece) for piece in pieces)
    while len(pieces) > 1 and kept - len(pieces[0]) >= SHAPES_KEPT:
        kept -= len(pieces.pop(0))
    return pieces


def scaled(beam: DynamicBeam, stiffness: float, moment: float) -> DynamicBeam:
    """Return the sheet with its stiffness and its moment per volt times these factors."""
    up, down = beam.moment_per_volt_Nm
    return replace(
        beam,
        material=replace(beam.material, B_Nm2=stiffness * beam.material.B_Nm2),
        moment_per_volt_Nm=(moment * up, moment * down),
    )
