"""Which further run would determine what of the sheet in time, before any time is spent on it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from labrig.analysis.motion.beginning import COARSE
from labrig.analysis.motion.frames import CURVE_POINTS, REACH
from labrig.analysis.motion.way import Way
from model.dynamics import ContactSetup, DynamicBeam, HeldVoltage
from model.dynamics.identification import (
    DynamicParameter,
    RecordedRun,
    RecordingNoise,
    RunPlan,
    expected,
    information_matrix,
)
from model.measurements import FloatArray, ModelError, SheetGeometry
from protocols.extras.chirp import Chirp
from protocols.extras.contract import Extra, ExtraRun
from protocols.extras.load_cell_step import LoadCellStep
from protocols.extras.release import Release
from protocols.kinds.pulse_train import PulseTrain

EVERY_S = 4e-3  # samples that stand for all
BEFORE_S = 0.5
TRAVEL_S = 0.3  # of a load cell step
APART_M = 0.01  # another position


@dataclass(frozen=True, kw_only=True)
class Proposal:
    """A run, and what would be known with it; `name` is empty for what is known now."""

    name: str
    key: str  # what to write into protocol.toml
    seconds: float
    parameters: tuple[DynamicParameter, ...]


def proposals(
    sheet: SheetGeometry,
    beam: DynamicBeam,
    runs: Sequence[RecordedRun],
    noise: RecordingNoise,
    frame_rate_hz: float,
) -> list[Proposal]:
    """Return what is known now, and with each further run. Raises ModelError."""
    plans = [_sparse(run.plan) for run in runs]
    fewer = _sparse_noise(noise, runs)
    now = information_matrix(beam, plans, fewer, COARSE)
    found = [Proposal(name="", key="", seconds=0.0, parameters=expected(beam, now))]
    for name, key, plan in _candidates(sheet, runs, frame_rate_hz):
        try:
            more = information_matrix(beam, [plan], fewer, COARSE)
        except ModelError:  # out of the rolls' reach
            continue
        seconds = max(float(plan.time_s[-1]), 0.0)
        found.append(
            Proposal(name=name, key=key, seconds=seconds, parameters=expected(beam, now + more))
        )
    return found


def _candidates(
    sheet: SheetGeometry, runs: Sequence[RecordedRun], frame_rate_hz: float
) -> Iterator[tuple[str, str, RunPlan]]:
    """Yield name, key of protocol.toml, and run."""
    volts = max((abs(v) for run in runs for v in run.plan.drive.voltage_V.tolist()), default=2.0)
    held = [run.plan for run in runs if run.plan.setup is not None]
    places = [
        float(plan.setup.position_m)
        for plan in held
        if plan.setup is not None and not callable(plan.setup.position_m)
    ]
    at_m = places[len(places) // 2] if places else 0.005
    rolls = ContactSetup(
        radius_m=sheet.arc_radius_m, origin_rad=sheet.arc_origin_rad, position_m=at_m
    )
    planner = _Planner(sheet, rolls, frame_rate_hz)
    volts = round(volts, 2)
    for name, key, extra in (
        ("release", "[extras] release = true", Release(voltages_V=(volts,))),
        ("chirp", "[extras] chirp = true", Chirp(amplitude_V=volts)),
        ("load-cell step", "[extras] load_cell_step = true",
         LoadCellStep(from_mm=1e3 * at_m, to_mm=1e3 * at_m + 5.0)),
    ):  # fmt: skip
        yield name, key, planner.of(name, extra, (at_m,))
    measured = [plan for plan in held if len(plan.time_s) and plan.drive.voltage_V.any()]
    if measured:
        other_m = max(places, default=at_m) + APART_M
        if other_m > 0.025 and min(places, default=0.0) >= APART_M:
            other_m = min(places) - APART_M
        key = f"[[places]] positions_mm = [{1e3 * other_m:g}]"
        plan = replace(_sparse(measured[0]), setup=replace(rolls, position_m=other_m))
        plan = replace(plan, frame_s=np.zeros(0), points_m=np.zeros(0))
        yield f"position {1e3 * other_m:g} mm", key, plan


@dataclass(frozen=True)
class _Planner:
    """Makes runs of extras."""

    sheet: SheetGeometry
    rolls: ContactSetup
    frame_rate_hz: float

    def of(self, name: str, extra: Extra, positions_m: tuple[float, ...]) -> RunPlan:
        """Return the first run that an extra adds."""
        run = next(iter(extra.runs(PulseTrain(), positions_m)))
        steps, _, duration_s = run.parts
        first = [step.time_s for step in steps if step.voltage_V]
        first += [run.move.time_s] if run.move else []
        begin_s = max(0.0, min(first, default=0.0) - BEFORE_S)
        end_s = duration_s - begin_s + (TRAVEL_S if run.move else 0.0)
        frames = np.zeros(0)
        if run.position_m is None:
            frames = np.arange(0.0, end_s, 1.0 / self.frame_rate_hz)
        points = REACH * (self.sheet.free_length_m + self.sheet.elongation_m)
        return RunPlan(
            drive=HeldVoltage(
                np.array([step.time_s - begin_s for step in steps]),
                np.array([step.voltage_V for step in steps]),
            ),
            time_s=np.arange(0.0, end_s, EVERY_S), setup=self._setup(run, begin_s),
            force=run.position_m is not None, frame_s=frames,
            points_m=points * np.arange(1, CURVE_POINTS + 1) / CURVE_POINTS if len(frames)
            else np.zeros(0),
            configuration=self.sheet.configuration, name=name,
        )  # fmt: skip

    def _setup(self, run: ExtraRun, begin_s: float) -> ContactSetup | None:
        if run.position_m is None:
            return None
        if run.move is None:
            return replace(self.rolls, position_m=run.position_m)
        left_s = run.move.time_s - begin_s
        way = Way(
            from_m=run.position_m, to_m=run.move.position_m, left_s=left_s,
            arrived_s=left_s + TRAVEL_S,
        )  # fmt: skip
        return replace(self.rolls, position_m=way.at)


def _sparse(plan: RunPlan) -> RunPlan:
    """Return the run with samples `EVERY_S` apart."""
    if len(plan.time_s) < 2:
        return plan
    every = max(1, round(EVERY_S / float(np.median(np.diff(plan.time_s)))))
    return replace(plan, time_s=plan.time_s[::every])


def _sparse_noise(noise: RecordingNoise, runs: Sequence[RecordedRun]) -> RecordingNoise:
    """Return the noise of a sample that stands for several."""
    rates: list[FloatArray] = [np.diff(run.plan.time_s) for run in runs if len(run.plan.time_s)]
    step_s = float(np.median(np.concatenate(rates))) if rates else 1e-3
    factor = min(1.0, (step_s / EVERY_S) ** 0.5)
    return replace(
        noise,
        force=replace(noise.force, white=factor * noise.force.white),
        current=replace(noise.current, white=factor * noise.current.white),
    )
