"""From a run's raw samples to its force readings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from drivers.interfaces import FloatArray
from drivers.load_cell import LoadCellCalibration
from labrig.analysis.edges import VoltageEdge, find_edges
from labrig.session import RunRecord
from protocols.execution.channels import CURRENT, DRIVE, FORCE
from protocols.execution.filters import symmetric_mean, window
from protocols.execution.rules import Rules, bad_samples, wrong_drive
from protocols.planning.schedule import PlannedReading, ReadingKind


@dataclass(frozen=True, kw_only=True)
class ForceReading:
    """One reading, measured anew."""

    index: int  # in time order over the run
    kind: ReadingKind
    voltage_V: float  # as planned
    force_N: float
    noise_N: float  # standard deviation expected of the filter's value, from its own window
    drive_V: float  # as read back
    time_s: float  # of the sampling point, since the run began
    sample_index: float
    valid: bool
    why: str
    other_values: dict[str, float]  # of further channels, by column


def measure_forces(
    run: RunRecord, calibration: LoadCellCalibration, *, rules: Rules | None = None
) -> tuple[ForceReading, ...]:
    """Return every reading that the run came to, from its raw samples.

    The sampling point is the planned delay after the edge, as found in the drive's read-back; the
    value there comes from the symmetric filter. A reading that is not valid carries all reasons:
    those noted while running (or by a person), and those found here.
    """
    if not run.started:
        return ()
    channels = {name: run.signal_V(name) for name in run.channels}
    edges = find_edges(run, channels[DRIVE])
    maker = _ReadingMaker(run, calibration, channels, edges, rules or Rules())
    return tuple(maker.reading(row) for row in run.readings)


class _ReadingMaker:
    def __init__(
        self,
        run: RunRecord,
        calibration: LoadCellCalibration,
        channels: dict[str, FloatArray],
        edges: dict[int, VoltageEdge],
        rules: Rules,
    ) -> None:
        self._run = run
        self._calibration = calibration
        self._volts = np.stack([channels[name] for name in run.channels])
        self._force = run.channels.index(FORCE)
        self._drive = run.channels.index(DRIVE)
        self._edges = edges
        self._rules = rules
        self._written_V = {int(row["step"]): float(row["sheet_V"]) for row in run.writes}

    def reading(self, row: np.void) -> ForceReading:
        """Return the reading that a row of the recorded table stands for."""
        clock, zero_s = self._run.sample_clock, self._run.time_zero_s
        planned = self._run.planned.readings[int(row["index"])]
        edge = self._edges.get(planned.step)
        centre = self._centre(planned, edge, float(row["sample_index"]))
        half = planned.half_window_s * clock.rate_hz
        force_N, noise_N = float(row["force_N"]), float("nan")
        drive_V = float(row["drive_V"])
        reasons = [str(row["why"])] if not row["valid"] else []
        first, last = window(centre, half)
        filtered_V = None
        if first < 0 or last >= self._volts.shape[1]:
            reasons.append("the samples of its window were not recorded")
        else:
            volts, noise_factor = self._filtered(centre, half)
            reasons += self._faults(first, last, float(volts[self._drive]), planned, edge)
            if np.isfinite(volts).all():  # else some were lost, and the value of then stands
                force_N = float(self._calibration.newtons(volts[self._force]))
                drive_V = float(volts[self._drive])
                noise_N = noise_factor * self._scatter_N(first, last)
                filtered_V = volts
        return ForceReading(
            index=planned.index,
            kind=planned.kind,
            voltage_V=planned.voltage_V,
            force_N=force_N,
            noise_N=noise_N,
            drive_V=drive_V,
            time_s=clock.time_of(centre) - zero_s,
            sample_index=centre,
            valid=not reasons,
            why="; ".join(_once(reasons)),
            other_values=self._other_values(row, filtered_V),
        )

    def _other_values(self, row: np.void, volts: FloatArray | None) -> dict[str, float]:
        """Return the values from the filtered volts; as recorded where these are not to be had."""
        found = self._run.values(row)
        for at, channel in enumerate(self._run.signals):
            if channel.name in (FORCE, DRIVE, CURRENT):
                del found[channel.column]
            elif volts is not None and np.isfinite(volts[at]) and channel.gain is not None:
                found[channel.column] = float(channel.convert(volts[at]))
        return {name: value for name, value in found.items() if np.isfinite(value)}

    def _centre(self, planned: PlannedReading, edge: VoltageEdge | None, recorded: float) -> float:
        if edge is None:
            return recorded
        return edge.index + planned.delay_s * self._run.sample_clock.rate_hz

    def _filtered(self, centre: float, half: float) -> tuple[FloatArray, float]:
        found = symmetric_mean(self._volts, centre, half)
        return found.value, found.noise_factor

    def _scatter_N(self, first: int, last: int) -> float:
        """Return the noise of one sample, from differences of neighbours.

        Blind to the signal's own course.
        """
        force = self._volts[self._force, first : last + 1]
        sigma_V = float(np.std(np.diff(force))) / np.sqrt(2) if force.size > 2 else float("nan")
        return sigma_V / abs(self._calibration.sensitivity_V_per_N)

    def _faults(
        self,
        first: int,
        last: int,
        drive_V: float,
        planned: PlannedReading,
        edge: VoltageEdge | None,
    ) -> Iterator[str]:
        if edge is not None and edge.why:
            yield edge.why
        yield from bad_samples(self._volts[:, first : last + 1], self._run.signals)
        yield from wrong_drive(drive_V, self._written_V.get(planned.step, 0.0), self._rules)


def _once(reasons: list[str]) -> list[str]:
    """Return each reason once: what was noted while running is mostly found again."""
    named = {part for reason in reasons[:1] for part in reason.split("; ")}
    return reasons[:1] + [reason for reason in dict.fromkeys(reasons[1:]) if reason not in named]
