"""When what is measured: the runs of a session, their set-ups, and every sample's circumstances.

A generator may lay its sessions out in this way, with times, scatter and streams of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.contract import Design

Array = npt.NDArray[np.float64]
READING, FRAME, SERIES = 0, 1, 2


@dataclass(frozen=True, kw_only=True)
class Layout:
    """Times, scatter from one set-up to the next, and streams of random numbers."""

    rise_s: float  # time constant of the voltage across the sheet
    series_s: float  # from one sample of a series to the next
    run_s: float  # from one run to the next
    wet_s: float  # from wetting to the beginning of a run
    registration_m: float
    order_key: int
    setup_key: int
    # numbers of unit variance, of which set-ups are drawn
    drawn: Callable[[np.random.Generator, int], Array]
    position_m: float = 0.05e-3
    eibm: float = 0.01  # relative
    stiffness: float = 0.01


@dataclass(frozen=True)
class Run:
    """One set-up, and what is measured with it."""

    number: int
    configuration: str
    position_m: float | None  # None: free
    mounting: int
    start_s: float
    wet_s: float
    tau: tuple[float, float]  # of the session, 0 to 1, at its beginning and end
    eibm: float = 1.0
    stiffness: float = 1.0
    moved_m: float = 0.0
    registration_m: tuple[float, float] = (0.0, 0.0)


def runs_of(layout: Layout, design: Design, seed: int, exact: bool) -> list[Run]:
    """Return the runs in their order."""
    places: list[tuple[str, float | None, int]] = []
    random = np.random.default_rng((seed, layout.order_key))
    for name, positions in design.positions_m.items():
        places += [(name, None, 0)] * design.free_shapes
        order = random.permutation(len(positions)) if design.random_order else range(len(positions))
        places += [(name, positions[k], 0) for k in order]
        again = np.linspace(0, len(positions) - 1, design.remounts).round().astype(int)
        for turn, k in enumerate(again):
            places.append((name, positions[k], 1 + turn // len(positions)))
    length = slots_of(design).size * design.pulse_s
    whole = (len(places) - 1) * layout.run_s + length
    result = []
    for number, (name, position, mounting) in enumerate(places):
        of_setup = np.random.default_rng((seed, layout.setup_key, number))
        z = layout.drawn(of_setup, 6) * (not exact)
        aside = layout.registration_m
        start = layout.run_s * number
        tau = (0.5, 0.5) if exact else (start / whole, (start + length) / whole)
        result.append(
            Run(
                number, name, position, mounting,
                0.5 * whole if exact else start, layout.wet_s + 2.0 * float(np.tanh(z[5])), tau,
                eibm=1.0 + layout.eibm * float(z[0]),
                stiffness=1.0 + layout.stiffness * float(z[1]),
                moved_m=layout.position_m * float(z[2]),
                registration_m=(aside * float(z[3]), aside * float(z[4])),
            )
        )  # fmt: skip
    return result


def slots_of(design: Design) -> Array:
    """Return the driving voltage of each slot of `pulse_s`."""
    pulses = design.discarded + 2 * design.readings
    turns = np.resize(np.array(design.voltages_V, dtype=float), pulses)
    return np.concatenate([np.zeros(design.readings), turns])


@dataclass
class Samples:
    """Samples of runs in order; each of shape (n,)."""

    run: npt.NDArray[np.intp]
    role: npt.NDArray[np.intp]
    slot: npt.NDArray[np.intp]
    time_s: Array  # since the run began
    drive_V: Array
    before_V: Array  # drive of the slot before
    sheet_V: Array  # across the sheet, behind the drive
    phase_s: Array  # since the last edge
    pulse: Array  # counts the pulses; -1 before the first
    session_s: Array
    wetted_s: Array
    tau: Array  # of the session, 0 to 1

    def take(self, rows: npt.NDArray[np.intp] | npt.NDArray[np.bool_]) -> Samples:
        """Return some of them."""
        return Samples(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})

    @staticmethod
    def joined(parts: list[Samples]) -> Samples:
        """Return one after the other."""
        return Samples(
            **{f.name: np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Samples)}
        )

    def each_run(self) -> Iterator[npt.NDArray[np.intp]]:
        """Return the rows of each run, in the order of time, frames left out."""
        for number in np.unique(self.run):
            rows = np.flatnonzero((self.run == number) & (self.role != FRAME))
            yield rows[np.argsort(self.time_s[rows], kind="stable")]


def samples_of(layout: Layout, run: Run, design: Design, delay_s: float) -> Samples:
    """Return a run's readings, the frames that belong to them, and its series."""
    drive = slots_of(design)
    reading = np.arange(len(drive)) * design.pulse_s + design.sample_s
    series = np.zeros(0)
    if design.series:
        whole = len(drive) * design.pulse_s
        series = layout.series_s * np.arange(1, 1 + int(whole / layout.series_s + 1e-6))
    time = np.concatenate([reading, np.maximum(reading - delay_s, 0.0), series])
    role = np.repeat([READING, FRAME, SERIES], [len(reading), len(reading), len(series)])
    slot = np.clip(np.ceil(time / design.pulse_s - 1e-9).astype(int) - 1, 0, len(drive) - 1)
    before = np.concatenate([[0.0], drive[:-1]])
    phase = time - slot * design.pulse_s
    decay = np.exp(-np.maximum(phase, 0.0) / layout.rise_s)
    share = time / (len(drive) * design.pulse_s)
    return Samples(
        run=np.full(len(time), run.number),
        role=role,
        slot=slot,
        time_s=time,
        drive_V=drive[slot],
        before_V=before[slot],
        sheet_V=np.round(drive[slot] + (before[slot] - drive[slot]) * decay, 7),
        phase_s=phase,
        pulse=np.maximum(slot - design.readings, -1).astype(float),
        session_s=run.start_s + time,
        wetted_s=run.wet_s + time,
        tau=run.tau[0] + (run.tau[1] - run.tau[0]) * share,
    )
