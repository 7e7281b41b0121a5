"""`motion_record`: what a session recorded of one sheet in time, as `model.dynamics` takes it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from drivers.interfaces import FloatArray
from labrig.analysis.analyze import AnalysisInputs, inputs_of, shunt_ohm
from labrig.analysis.motion.frames import FrameCurves, frame_curves
from labrig.analysis.motion.signals import MotionSignals, is_whole, motion_signals
from labrig.analysis.motion.silent_current import follows_the_voltage
from labrig.analysis.motion.way import LoadCellWay
from labrig.errors import BadInputError
from labrig.extractors.choice import BUILT_IN
from labrig.progress import Progress
from labrig.session import RecordedSession, RunRecord
from model.dynamics import ContactSetup
from model.dynamics.identification import RecordedRun, RunPlan
from model.measurements import SheetGeometry
from protocols.planning.schedule import Purpose

Samples = npt.NDArray[np.bool_]  # which of them
BEFORE_S = 0.5  # of each run count before its first voltage, or before the load cell moves
LEAST_FRAME_RATE_HZ = 20.0  # a free sheet swings at 3 to 7 Hz


@dataclass(frozen=True, kw_only=True)
class MotionRecord:
    """One configuration's runs of a session, each with what was measured in it."""

    source: str  # name of the file
    sheet: SheetGeometry
    runs: tuple[RecordedRun, ...]
    missing: tuple[str, ...]  # what was not recorded and what to do: a sentence each
    notes: tuple[str, ...] = ()  # frames without a curve


def recorded_runs(
    session: RecordedSession, configuration: str | None = None, *, progress: Progress | None = None
) -> list[RecordedRun]:
    """Return the runs of `motion_record`."""
    return list(motion_record(session, configuration, progress=progress).runs)


def motion_record(
    session: RecordedSession,
    configuration: str | None = None,
    *,
    positions_m: Sequence[float] | None = None,
    frames: bool = True,
    progress: Progress | None = None,
    extractor: str = BUILT_IN,
) -> MotionRecord:
    """Read the runs of one configuration in which a voltage was applied or the load cell moved.

    Each begins half a second before that. `positions_m`: only these of the measurements in contact;
    without `frames` the images are left alone. Raises BadInputError, one sentence, where there is
    no such run.
    """
    given = inputs_of(session)
    name = _configuration(session, configuration)
    chosen = [
        run for run in session.runs
        if run.planned.configuration == name and _moves(run) and _is_wanted(run, positions_m)
    ]  # fmt: skip
    if not chosen:
        raise BadInputError(
            f"{session.path}: no whole run of '{name}' was driven or had its load cell moved;"
            " record one with labrig run, best with [extras] release = true."
        )
    reader = _RunReader(session, given, given.sheets[name], extractor, frames=frames)
    runs: list[RecordedRun] = []
    for done, run in enumerate(chosen):

        def advance(share: float, done: int = done, run: RunRecord = run) -> None:
            if progress is not None:
                progress((done + share) / len(chosen), f"{name}, {run.planned.in_words}")

        runs += reader.read(run, advance)
    return MotionRecord(
        source=session.path.name, sheet=given.sheets[name], runs=tuple(runs),
        missing=tuple(reader.missing(runs)), notes=tuple(reader.notes),
    )  # fmt: skip


def moving_configurations(session: RecordedSession) -> list[str]:
    """Return the configurations with a run in which the sheet moved."""
    return list(dict.fromkeys(r.planned.configuration for r in session.runs if _moves(r)))


def _configuration(session: RecordedSession, wanted: str | None) -> str:
    if not any(run.started for run in session.runs):
        raise BadInputError(
            f"{session.path}: it holds no signals over time, only tables; the sheet in time is"
            " identified from a session that labrig run has recorded."
        )
    known = moving_configurations(session)
    if wanted is None and len(known) > 1:
        raise BadInputError(
            f"{session.path}: it has several configurations in time; name one of them:"
            f" {', '.join(known)}."
        )
    return wanted or (known[0] if known else session.runs[0].planned.configuration)


def _moves(run: RunRecord) -> bool:
    """Whether a whole run has something to tell of the sheet in time."""
    planned = run.planned
    driven = any(step.voltage_V for step in planned.steps)
    kinds = (Purpose.MEASUREMENT, Purpose.FREE_SHAPE)
    return planned.purpose in kinds and (driven or planned.move is not None) and is_whole(run)


def _is_wanted(run: RunRecord, positions_m: Sequence[float] | None) -> bool:
    if positions_m is None or not run.planned.measures or run.planned.position_m is None:
        return True
    return any(abs(run.planned.position_m - at_m) < 1e-6 for at_m in positions_m)


class _RunReader:
    """Reads one run after the other, and remembers what was missing in them."""

    def __init__(
        self, session: RecordedSession, given: AnalysisInputs, sheet: SheetGeometry,
        extractor: str, *, frames: bool,
    ) -> None:  # fmt: skip
        self._session, self._given, self._sheet = session, given, sheet
        self._extractor, self._frames = extractor, frames
        self._shunt_ohm = shunt_ohm(session)
        camera = session.resolved.get("rig", {}).get("camera") or {}
        self._exposure_s = float(camera.get("exposure_s") or 0.0)
        self._silent = False  # a current that does not follow the voltage
        self.notes: list[str] = []  # frames without a curve

    def read(self, run: RunRecord, advance: Callable[[float], None]) -> Iterator[RecordedRun]:
        """Yield the run, where it holds anything that can be compared with the model."""
        planned = run.planned
        begin_s = self._begin_s(run)
        signals = motion_signals(
            self._session, run, self._given.calibration, self._shunt_ohm, begin_s=begin_s
        )
        signals = self._with_current(signals)
        setup, still = self._contact(run, begin_s, signals.time_s)
        curves = None
        if self._frames and self._given.optics is not None and run.frame_count:
            curves = frame_curves(
                run, self._sheet, self._given.optics, self._extractor, begin_s=begin_s,
                exposure_s=self._exposure_s, advance=advance,
            )  # fmt: skip
        where = "free" if setup is None else f"{1e3 * (planned.position_m or 0.0):g} mm"
        name = f"{planned.configuration}, {where}, {planned.in_words}"
        if curves is not None and curves.failed:
            self.notes.append(
                f"{name}: {curves.failed} of {len(curves.frame_s)} frames show no curve"
                f" (the first: {curves.why.rstrip('.')})."
            )
        if setup is not None or signals.current_A is not None or curves is not None:
            yield _recorded(name, planned.configuration, signals, setup, still, curves)

    def _with_current(self, signals: MotionSignals) -> MotionSignals:
        """Return the signals, without a current that an open input shows."""
        shown = signals.current_A
        if shown is None or follows_the_voltage(signals.drive, signals.time_s, shown):
            return signals
        self._silent = True
        return replace(signals, current_A=None)

    def _begin_s(self, run: RunRecord) -> float:
        """Return when the run is taken to begin, s since its time 0."""
        steps = [step.time_s for step in run.planned.steps if step.voltage_V]
        if run.planned.move is not None:
            steps.append(run.planned.move.time_s)
        return max(float(run.time_s[0]), min(steps) - BEFORE_S)

    def _contact(
        self, run: RunRecord, begin_s: float, time_s: FloatArray
    ) -> tuple[ContactSetup | None, Samples]:
        """Return where the rolls are, and at which samples they rest, (n,)."""
        planned, sheet = run.planned, self._sheet
        if planned.purpose is not Purpose.MEASUREMENT or planned.position_m is None:
            return None, np.ones(len(time_s), dtype=bool)
        way = LoadCellWay.of(self._session, run, begin_s)
        setup = ContactSetup(
            radius_m=sheet.arc_radius_m, origin_rad=sheet.arc_origin_rad,
            position_m=planned.position_m if way is None else way.at,
        )  # fmt: skip
        if way is None:
            return setup, np.ones(len(time_s), dtype=bool)
        return setup, (time_s < way.left_s) | (time_s > way.arrived_s)

    def missing(self, runs: Sequence[RecordedRun]) -> Iterator[str]:
        """Yield what a fit would want, a sentence each."""
        if self._silent:
            yield (
                "The current does not follow the voltage, so it is not used: check the wires of the"
                " shunt and [ni] current in rig.toml."
            )
        elif not any(run.plan.current for run in runs):
            yield (
                "No current was recorded, so the electrodes are not determined: wire the current"
                " channel and state [current_sense] shunt_ohm in rig.toml."
            )
        if not any(run.plan.force for run in runs):
            yield (
                "No force was recorded, so stiffness, mass and moment per volt are determined as"
                " ratios only: add a measurement at a position."
            )
        free = [run.plan for run in runs if run.plan.setup is None and len(run.plan.frame_s) > 2]
        if not free:
            yield (
                "No moving free sheet was filmed, so mass and loss are not determined: add"
                " [extras] release = true."
            )
        rates = [1.0 / float(np.median(np.diff(plan.frame_s))) for plan in free]
        if rates and max(rates) < LEAST_FRAME_RATE_HZ:
            yield (
                f"{max(rates):.3g} frames/s are slow for a free sheet, which swings at 3 to 7 Hz:"
                f" set the camera and protocol.toml's"
                f" [camera] frame_rate_hz to {LEAST_FRAME_RATE_HZ:g} or more."
            )
        if free and not self._exposure_s:
            yield (
                "How long a frame was exposed is not stated, so its time is taken as that of its"
                " arrival: state [camera] exposure_s in rig.toml."
            )


def _recorded(
    name: str,
    configuration: str,
    signals: MotionSignals,
    setup: ContactSetup | None,
    still: Samples,
    curves: FrameCurves | None,
) -> RecordedRun:
    none = np.zeros(0)
    force, current = setup is not None, signals.current_A is not None
    some = force or current
    return RecordedRun(
        plan=RunPlan(
            drive=signals.drive, time_s=signals.time_s[still] if some else none, setup=setup,
            force=force, current=current,
            frame_s=none if curves is None else curves.frame_s,
            points_m=none if curves is None else curves.points_m,
            configuration=configuration, name=name,
        ),
        force_N=signals.force_N[still] if force else None,
        current_A=None if signals.current_A is None else signals.current_A[still],
        x_m=None if curves is None else curves.x_m,
        y_m=None if curves is None else curves.y_m,
    )  # fmt: skip
