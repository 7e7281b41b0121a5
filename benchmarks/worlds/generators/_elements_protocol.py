"""When what is measured: the runs of a session, their set-ups, and every sample's circumstances."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.contract import Design

Array = npt.NDArray[np.float64]
RISE_S = 0.035  # time constant of the voltage across the sheet
SERIES_S = 0.04
RUN_S = 70.0  # from one run to the next
WET_S = 12.0  # from wetting to the beginning of a run
READING, FRAME, SERIES = 0, 1, 2
DEGREES = 6.0  # of Student's t, of which set-ups are drawn
EIBM_SCATTER, STIFFNESS_SCATTER = 0.01, 0.01
POSITION_SCATTER_M, REGISTRATION_M = 0.05e-3, 0.015e-3


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


def runs_of(design: Design, seed: int, exact: bool) -> list[Run]:
    """Return the runs in their order."""
    places: list[tuple[str, float | None, int]] = []
    random = np.random.default_rng((seed, 310))
    for name, positions in design.positions_m.items():
        places += [(name, None, 0)] * design.free_shapes
        order = random.permutation(len(positions)) if design.random_order else range(len(positions))
        places += [(name, positions[k], 0) for k in order]
        again = np.linspace(0, len(positions) - 1, design.remounts).round().astype(int)
        for turn, k in enumerate(again):
            places.append((name, positions[k], 1 + turn // len(positions)))
    length = slots_of(design).size * design.pulse_s
    whole = (len(places) - 1) * RUN_S + length
    result = []
    for number, (name, position, mounting) in enumerate(places):
        z = np.random.default_rng((seed, 311, number)).standard_t(DEGREES, 6) * (not exact)
        z = z * np.sqrt((DEGREES - 2.0) / DEGREES)
        start = RUN_S * number
        tau = (0.5, 0.5) if exact else (start / whole, (start + length) / whole)
        result.append(
            Run(
                number, name, position, mounting,
                0.5 * whole if exact else start, WET_S + 2.0 * float(np.tanh(z[5])), tau,
                eibm=1.0 + EIBM_SCATTER * float(z[0]),
                stiffness=1.0 + STIFFNESS_SCATTER * float(z[1]),
                moved_m=POSITION_SCATTER_M * float(z[2]),
                registration_m=(REGISTRATION_M * float(z[3]), REGISTRATION_M * float(z[4])),
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


def samples_of(run: Run, design: Design, delay_s: float) -> Samples:
    """Return a run's readings, the frames that belong to them, and its series."""
    drive = slots_of(design)
    reading = np.arange(len(drive)) * design.pulse_s + design.sample_s
    series = np.zeros(0)
    if design.series:
        whole = len(drive) * design.pulse_s
        series = SERIES_S * np.arange(1, 1 + int(whole / SERIES_S + 1e-6))
    time = np.concatenate([reading, np.maximum(reading - delay_s, 0.0), series])
    role = np.repeat([READING, FRAME, SERIES], [len(reading), len(reading), len(series)])
    slot = np.clip(np.ceil(time / design.pulse_s - 1e-9).astype(int) - 1, 0, len(drive) - 1)
    before = np.concatenate([[0.0], drive[:-1]])
    phase = time - slot * design.pulse_s
    decay = np.exp(-np.maximum(phase, 0.0) / RISE_S)
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
