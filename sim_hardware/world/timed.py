"""A session without pixels and volts, but with its course in time: in a third of a second.

For questions that take hundreds of sessions and are about what happens between the readings: what
charges, relaxes, dries, creeps, rubs, sticks, drifts or is seen late. The sheet is the world's own,
driven edge by edge on its own time grid; only boards, camera and the reading of images are left
out. Errors of curves are those of `CurveErrors`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import numpy.typing as npt

from sim_hardware.world.curve_noise import CurveErrors, CurveNoise
from sim_hardware.world.history import history_of
from sim_hardware.world.mechanics import Stage
from sim_hardware.world.settings import WorldSettings
from sim_hardware.world.setup import MountedSheet, Scatter
from sim_hardware.world.signals.amplifier import SimulatedAmplifier
from sim_hardware.world.signals.load_cell import SimulatedLoadCell
from sim_hardware.world.view import seen_curve

FloatArray = npt.NDArray[np.float64]
ReadingKind = Literal["zero", "discarded", "kept", "no_contact"]

FINE_HZ = 200.0  # of the samples that readings are made of: means over five of the board's
_BOARD_HZ = 1000.0
_CURVE_STREAM, _FRAME_STREAM = 0xCE130, 0xCE131


@dataclass(frozen=True, kw_only=True)
class Train:
    """The paper's pulses, and when a run begins."""

    voltages: tuple[float, ...] = (2.0, -2.0)
    pulse_s: float = 0.6
    sample_s: float = 0.5
    half_window_s: float = 0.1
    zero_readings: int = 10
    discarded: int = 2
    kept: int = 10  # of each voltage
    wet_s: float = 8.0  # from placing and wetting to the run's beginning
    run_s: float = 60.0  # from one run to the next

    def edges(self) -> list[float]:
        """Return the voltage of each slot of `pulse_s`."""
        turns = self.discarded + self.kept * len(self.voltages)
        driven = [self.voltages[k % len(self.voltages)] for k in range(turns)]
        return [0.0] * self.zero_readings + driven

    def kinds(self) -> list[ReadingKind]:
        """Return the purpose of the reading of each slot."""
        zero: list[ReadingKind] = ["zero"] * self.zero_readings
        discarded: list[ReadingKind] = ["discarded"] * self.discarded
        kept: list[ReadingKind] = ["kept"] * (self.kept * len(self.voltages))
        return zero + discarded + kept


@dataclass(frozen=True, kw_only=True)
class Visit:
    """One run: where, and how it was set up."""

    configuration: str
    position_m: float | None  # None: the free shape
    mounting: int = 0
    approach: Literal["up", "down"] = "up"
    turn: int = 0  # counts visits with the same configuration, position and mounting
    odd: Scatter | None = None  # set-up gone wrong: instead of the scatter that is drawn
    turned_over: bool = False  # the rig
    load_cell_alone: bool = False  # its zero, the sheet lifted out: at 0 V only


@dataclass(frozen=True, kw_only=True)
class TimedReading:
    """One reading, with the points (n, 2) of its own frame."""

    index: int
    kind: ReadingKind
    voltage_V: float
    time_s: float
    force_N: float
    curve_m: FloatArray


@dataclass(frozen=True, kw_only=True)
class TimedRun:
    """All that was measured in one visit, and its true values."""

    visit: Visit
    start_s: float
    wet_s: float
    readings: tuple[TimedReading, ...]
    s_m: FloatArray  # of the curves' points
    curves_m: dict[float, FloatArray]  # of the mean image, by voltage
    reading_sigma_m: float
    curve_sigma_m: float
    time_s: FloatArray  # of the series
    drive_V: FloatArray
    force_N: FloatArray
    scatter: Scatter


def timed_session(
    settings: WorldSettings,
    visits: Sequence[Visit],
    *,
    train: Train | None = None,
    free_train: Train | None = None,
    errors: CurveErrors | None = None,
    series_hz: float = 100.0,
) -> list[TimedRun]:
    """Make the visits one after the other; one that cannot be held is left out.

    `free_train` is for the free shapes. `series_hz` divides 200. A reading's curve is rougher than
    that of the mean image, whose errors are `errors`.
    """
    return list(
        _Runner(settings, train or Train(), errors or CurveErrors(), series_hz).runs(
            visits, free_train or train or Train()
        )
    )


def each_after(
    settings: WorldSettings,
    before: Sequence[Visit],
    wanted: Sequence[tuple[Visit, Train]],
    *,
    train: Train | None = None,
    free_train: Train | None = None,
    errors: CurveErrors | None = None,
) -> list[TimedRun | None]:
    """Make each of the wanted visits as if it came next after the others; None: it cannot be held.

    What a prediction of one condition amid a session is compared with.
    """
    from sim_hardware.world import state_kernels

    runner = _Runner(settings, train or Train(), errors or CurveErrors(), FINE_HZ)
    past = list(runner.runs(before, free_train or train or Train()))
    start_s = past[-1].start_s - past[-1].wet_s + runner.train.run_s if past else 0.0
    shared = {id(one): one for one in (settings, state_kernels)}
    return [deepcopy(runner, dict(shared)).next_run(len(before), *one, start_s) for one in wanted]


class _Runner:
    def __init__(
        self, settings: WorldSettings, train: Train, errors: CurveErrors, series_hz: float
    ) -> None:
        self._settings, self.train, self._errors = settings, train, errors
        self._block = round(FINE_HZ / series_hz)
        if self._block < 1 or abs(self._block * series_hz - FINE_HZ) > 1e-6:
            raise ValueError(f"series_hz = {series_hz:g} must divide {FINE_HZ:g}")
        self._amplifier = SimulatedAmplifier(settings.amplifier, 0.0)
        self._cell = SimulatedLoadCell(settings.load_cell, settings.seed)
        nowhere = MountedSheet(
            settings=settings,
            configuration=next(iter(settings.configurations)),
            position_m=None,
            scatter=Scatter(),
        )
        self._history = history_of(
            settings,
            self._amplifier,
            self._cell,
            Stage(start_s=0.0, setup=nowhere),
            lambda *_: None,
        )

    def runs(self, visits: Sequence[Visit], free_train: Train) -> Iterator[TimedRun]:
        start_s = 0.0
        for number, visit in enumerate(visits):
            train = free_train if visit.position_m is None else self.train
            if visit.load_cell_alone:
                train = replace(self.train, discarded=0, kept=0)
            found = self.next_run(number, visit, train, start_s)
            if found is not None:
                yield found
            start_s += train.run_s

    def next_run(self, number: int, visit: Visit, train: Train, start_s: float) -> TimedRun | None:
        """Make a visit; None: the sheet cannot be held there."""
        setup = MountedSheet(
            settings=self._settings,
            configuration=visit.configuration,
            position_m=visit.position_m,
            scatter=visit.odd or Scatter.draw(self._settings, number),
            turned_over=visit.turned_over,
        )
        if not setup.uncrept.reachable:
            return None
        return self._run(number, visit, train, setup, start_s)

    def _run(
        self, number: int, visit: Visit, train: Train, setup: MountedSheet, placed_s: float
    ) -> TimedRun:
        start_s, voltages = placed_s + train.wet_s, train.edges()
        self._place(setup, placed_s, moved_up=visit.approach == "up")
        self._drive(voltages, start_s, train.pulse_s)
        time_s, drive_V, force_N = self._signals(start_s, len(voltages) * train.pulse_s)
        sampled_s = np.asarray(np.arange(len(voltages)) * train.pulse_s + train.sample_s)
        readings_N = _filtered(force_N, sampled_s, train.half_window_s)
        noise = CurveNoise(self._errors, (self._settings.seed, _CURVE_STREAM, number))
        s_m = noise.places(setup.chain.sheet.visible_m)
        seen = self._frames(number, start_s + sampled_s, s_m)
        of_kind, readings, curves = train.kinds(), [], {}
        if visit.position_m is None:
            of_kind = ["no_contact"] * len(of_kind)
        for voltage in dict.fromkeys(voltages):
            rows = [k for k, v in enumerate(voltages) if v == voltage]
            noisy = noise.added([seen[k] for k in rows], s_m)
            used = [n for k, n in zip(rows, noisy, strict=True) if train.kinds()[k] != "discarded"]
            curves[voltage] = np.mean(used, axis=0)
            readings += [
                TimedReading(
                    index=k,
                    kind=of_kind[k],
                    voltage_V=voltage,
                    time_s=float(sampled_s[k]),
                    force_N=float(readings_N[k]),
                    curve_m=n,
                )
                for k, n in zip(rows, noisy, strict=True)
            ]
        return TimedRun(
            visit=visit,
            start_s=start_s,
            wet_s=train.wet_s,
            readings=tuple(sorted(readings, key=lambda r: r.index)),
            s_m=s_m,
            curves_m=curves,
            reading_sigma_m=noise.reading_sigma_m,
            curve_sigma_m=self._errors.sigma_m,
            time_s=_blocks(time_s, self._block),
            drive_V=_blocks(drive_V, self._block),
            force_N=_blocks(force_N, self._block),
            scatter=setup.scatter,
        )

    def _place(self, setup: MountedSheet, placed_s: float, *, moved_up: bool) -> None:
        """Put the load cell to the moistened sheet of a set-up."""
        self._history.advance(placed_s)
        self._history.begin(Stage(start_s=self._history.reached_s, setup=setup, moved_up=moved_up))
        self._history.moisten()

    def _drive(self, voltages: Sequence[float], start_s: float, pulse_s: float) -> None:
        """Write each voltage for the time of a pulse, then 0 V."""
        for k, voltage in enumerate([*voltages, 0.0]):
            when = start_s + k * pulse_s
            self._history.advance(when)
            if k == 0 or voltage != voltages[k - 1]:
                self._amplifier.write(voltage / self._settings.amplifier.gain, when)

    def _signals(
        self, start_s: float, length_s: float
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Time since the start, drive and force, as means over five samples of the board."""
        time_s = np.asarray((np.arange(round(length_s * FINE_HZ)) + 0.5) / FINE_HZ)
        felt_N = np.concatenate([m.felt_N for m in self._history.at(start_s + time_s)])
        per_block = round(_BOARD_HZ / FINE_HZ)
        samples_s = np.asarray(start_s + np.arange(time_s.size * per_block) / _BOARD_HZ)
        noise_N = self._cell.noise_N(samples_s)
        force_N = felt_N + self._cell.zero_N(start_s + time_s) + _blocks(noise_N, per_block)
        return time_s, self._amplifier.output_V(start_s + time_s), np.asarray(force_N)

    def _frames(self, number: int, sampled_s: FloatArray, s_m: FloatArray) -> list[FloatArray]:
        """Return the curve in the frame nearest to each sampling point, without error."""
        camera = self._settings.camera
        random = np.random.default_rng((self._settings.seed, _FRAME_STREAM, number))
        phase = random.uniform(0.0, 1.0)
        frames = np.rint(sampled_s * camera.frame_rate_hz - phase) + phase
        shown_s = np.asarray(frames / camera.frame_rate_hz - self._settings.frame_delay_s)
        moments = self._history.at(shown_s - camera.exposure_s / 2)
        return [seen_curve(m, k, s_m) for m in moments for k in range(m.times.size)]


def _filtered(force_N: FloatArray, sampled_s: FloatArray, half_s: float) -> FloatArray:
    """Means about each sampling point with weights that fall to nothing half a window away."""
    reach = round(half_s * FINE_HZ)
    first = np.rint(sampled_s * FINE_HZ).astype(int) - reach
    offset = (np.arange(2 * reach) + 0.5 - reach) / reach
    weights = 1 + np.cos(math.pi * offset)
    windows = force_N[first[:, None] + np.arange(2 * reach)]
    return np.asarray(windows @ (weights / weights.sum()))


def _blocks(values: FloatArray, block: int) -> FloatArray:
    """Means of so many neighbours."""
    whole = values.size // block * block
    return np.asarray(values[:whole].reshape(-1, block).mean(axis=1))
