"""Replay a recorded session: its samples and frames through the drivers, in place of the rig.

Boards and camera are simulated; they measure what was recorded. The director is notified of each
run as it begins. It then answers every request for a sample with the one of the same index, and
gives every frame at its recorded time after the run's first sample. Of a session that was not
completed only what was recorded is played: the director stops where the recording ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from drivers.boards import DEFAULT, BoardInput
from drivers.cameras.capture_camera import CaptureCamera
from drivers.interfaces import Clock, Prompt
from labrig.config import RigConfig, parse_rig
from labrig.config.derived import SIMULATED
from labrig.config.load_cell import FORCE_UNIT
from labrig.control.reference import CONTROLLER
from labrig.errors import BadInputError
from labrig.experiment.plan import Plan
from labrig.experiment.recorded_plan import plan_of_session
from labrig.experiment.rig.channels import inputs_of
from labrig.experiment.rig.rig import FORCE, Rig
from labrig.experiment.rig.wiring import sheet_drive
from labrig.session import RecordedSession, RunRecord
from labrig.session.reading.moves import moves_of
from protocols.execution.events import Event, Outcome, ReadingTaken, RunStarted, RunStopped
from protocols.execution.operator import REPEAT
from protocols.execution.states import FinishReason
from protocols.execution.stop import StopLevel, StopRequest

FloatArray = npt.NDArray[np.float64]
_BETWEEN_S = 0.3  # the camera gives a blank frame when no recorded frame is near
_LOOK_S = 0.01  # so often it looks whether a run has begun meanwhile
_NEAR_S = 0.4
_FURTHER = 3  # the first input of the default family's board that is not one of its own three
_NEEDED = ("rig.toml", "protocol.toml", "sheet.toml", "load_cell.toml")
_ENDED = {
    Outcome.ABORTED: "was aborted",
    Outcome.FAILED: "failed",
    Outcome.CRASHED: "crashed",
}


def replay_plan(session: RecordedSession) -> Plan:
    """Return the plan of what was done, from the configuration that the session holds."""
    for name in _NEEDED:
        if name not in session.texts:
            raise BadInputError(
                f"{session.path}: holds no {name}; only a session that labrig has recorded can be "
                "replayed."
            )
    rig = parse_rig(session.texts["rig.toml"], f"{session.path}: rig.toml")
    if not isinstance(rig, RigConfig):
        raise BadInputError(f"{session.path}: was itself recorded from a replay.")
    if not any(run.started for run in session.runs):
        raise BadInputError(
            f"{session.path}: no run of it was ever begun; nothing can be replayed."
        )
    if CONTROLLER in session.texts:
        raise BadInputError(
            f"{session.path}: a controller has set its voltage, which nobody can do again with "
            "recorded forces; it is shown and exported, but not replayed."
        )
    plan = plan_of_session(session, on_simulated_boards(rig))
    return replace(plan, schedule=session.schedule)  # another labrig may have made it otherwise


def on_simulated_boards(rig: RigConfig) -> RigConfig:
    """Replace the boards by the default family, through which recordings are played."""
    tables: dict[str, Any] = {DEFAULT: {"address": SIMULATED}}
    if rig.boards_kind != DEFAULT:
        tables[DEFAULT]["sample_rate_hz"] = rig.boards.sample_rate_hz
        tables[rig.boards_kind] = None
        tables["channels"] = {
            name: {**each.model_dump(), "input": f"PCI6034E/ai{number}"}
            for number, (name, each) in enumerate(rig.channels.items(), start=_FURTHER)
        }
    return rig.changed(**tables)


def replay_rig(session: RecordedSession, plan: Plan, stop: StopRequest) -> tuple[Rig, Director]:
    """Return the rig that plays `session`, and its director, which must get every event first.

    `stop` is requested where the recording of a session ends that was not completed.
    """
    from sim_hardware.clock import VirtualClock
    from sim_hardware.ni import NiDeviceServer

    clock = VirtualClock()
    inputs = _inputs(session, plan.rig)
    director = Director(session, inputs, stop)
    settings = plan.rig.boards.settings()
    server = NiDeviceServer(director, clock, devices=_models(session, settings, inputs), seed=None)
    boards = plan.rig.family.connect(settings, clock, server.in_process_channel())
    camera = None
    if session.frame_shape is not None:
        camera = CaptureCamera(
            "replay", clock, capture_factory=lambda _source: RecordedCapture(director, clock)
        )
    rig = Rig(
        config=plan.rig,
        clock=clock,
        boards=boards,
        output=sheet_drive(plan.rig, boards),
        signals=boards.signal_input(inputs),
        camera=camera,
        stage=_RecordedStage(director, clock),
        operator=_Done(session),
        calibration=plan.calibration,
        interlock=None,
        threaded=False,
        replayed=session,
    )
    return rig, director


def _inputs(session: RecordedSession, rig: RigConfig) -> list[BoardInput]:
    """Return the channels as wired; a force that a meter has read gets a range for it."""
    wired = inputs_of(rig)
    if session.resolved.get(FORCE_UNIT) != "N":
        return list(wired)
    forces = [run.signal_V(FORCE) for run in session.runs if run.started]
    most = max((float(np.nanmax(np.abs(each), initial=0.0)) for each in forces), default=0.0)
    return [
        each._replace(range_V=min(1.01 * most + 1e-3, 10.0)) if each.name == FORCE else each
        for each in wired
    ]


def _models(session: RecordedSession, settings: Any, inputs: list[BoardInput]) -> dict[str, str]:
    """Return boards that stand in: a session names its devices and ranges, but not their models."""
    from sim_hardware.ni.boards import input_board, output_board

    drive, force = (channel.split("/")[0] for channel in (settings.drive, settings.force))
    recorded = dict(zip(session.channels, session.ranges_V, strict=False))
    ranges = [(each.range_V, recorded.get(each.name, each.range_V)) for each in inputs]
    if drive == force:
        return {drive: input_board(ranges, outputs=True)}
    return {drive: output_board(), force: input_board(ranges, outputs=False)}


class Director:
    """Knows which recorded run is on, and since when; a `Bench` of recorded samples."""

    def __init__(
        self, session: RecordedSession, inputs: Sequence[BoardInput], stop: StopRequest
    ) -> None:
        self.session = session
        self._stop = stop
        self._last_reading = -1  # index of the last one that was recorded of the run that is on
        self._left = {run.planned.index for run in session.runs if run.started}  # to be played
        self.run: RunRecord | None = None
        self.start_s = 0.0  # clock time of the run's first sample
        self._rate_hz = 1.0
        self._names = {each.terminal.split("/")[1]: each.name for each in inputs}
        self._samples: dict[str, FloatArray] = {}
        self.frame_due_s = np.empty(0)  # clock times of the recorded frames, rising

    def follow(self, event: Event) -> None:
        """Told of each event before the first sample after it is read."""
        if isinstance(event, RunStarted):
            self.run = self.session.run(event.run.index)
            self.start_s = event.sample_clock.start_s
            self._rate_hz = event.sample_clock.rate_hz
            self._samples = {name: self.run.signal_V(name) for name in self._names.values()}
            recorded_at = self.run.frame_column("sample_index") / self._rate_hz
            self.frame_due_s = self.start_s + recorded_at
            self._last_reading = int(self.run.readings_as_taken["index"].max(initial=-1))
            if event.run.readings and self._last_reading < 0:
                self._end_of(self.run)
        elif isinstance(event, ReadingTaken) and self.run is not None:
            if event.planned.index >= self._last_reading:
                self._end_of(self.run)
        elif isinstance(event, RunStopped):
            self.run, self._samples, self.frame_due_s = None, {}, np.empty(0)
            self._left.discard(event.run)
            if not self._left and self.session.outcome is not Outcome.COMPLETED:
                self._end()

    def _end_with_samples(self, times: FloatArray) -> None:
        """Stop where the samples end of a run without readings, which could say where it ends."""
        run = self.run
        if run is None or run.planned.readings or not len(times):
            return
        if (times[-1] - self.start_s) * self._rate_hz > run.samples:
            self._end_of(run)

    def _end_of(self, run: RunRecord) -> None:
        """Stop at the end of what was recorded of a run, unless all of it was."""
        if not run.completed:
            self._end()

    def _end(self) -> None:
        """End as the session did: the same outcome, so that the exit code is the same, too."""
        session = self.session
        ended = _ENDED.get(session.outcome, "did not end")
        why = f": {reason}" if (reason := session.reason) else ""
        self._stop.request(
            StopLevel.NOW,
            f"the recording of {session.path.name} ends here; that session {ended}{why}",
            FinishReason.STOP_REQUESTED
            if session.outcome is Outcome.ABORTED
            else FinishReason.RECORDING_ENDED,
        )

    def move_s(self) -> float:
        """Return how long the load cell was moved during the run that is on, s; 0: not known."""
        if self.run is None:
            return 0.0
        at_s = [event.time_s for event in moves_of(self.session, self.run)]
        return at_s[1] - at_s[0] if len(at_s) == 2 else 0.0

    def write(self, device: str, channel: str, volts: float, when: float) -> None:
        """Ignore the write: a recording stays as it is (see `sim_hardware.simulated_rig.Bench`)."""

    def read(self, device: str, channel: str, times: FloatArray) -> FloatArray:  # noqa: ARG002
        """See `sim_hardware.simulated_rig.Bench`. Between runs every input is at 0 V."""
        samples = self._samples.get(self._names.get(channel, ""))
        self._end_with_samples(times)
        if samples is None or samples.size == 0:
            return np.zeros(len(times))
        index = np.rint((times - self.start_s) * self._rate_hz).astype(np.int64)
        return samples[np.clip(index, 0, samples.size - 1)]


class RecordedCapture:
    """The part of `cv2.VideoCapture`'s interface that the driver uses, showing recorded frames.

    Frames that were not recorded do not come; when none is near, a black one shows that the camera
    is alive.
    """

    def __init__(self, director: Director, clock: Clock) -> None:
        self._director = director
        self._clock = clock
        self._row: int | None = None  # of the run's recorded frames, the one taken last
        self._last_s = -np.inf

    def isOpened(self) -> bool:
        """Return True: the recording is there."""
        return True

    def get(self, _property: int) -> float:
        """Nothing is known of the camera that took them."""
        return 0.0

    def set(self, _property: int, _value: float) -> bool:
        """Nothing can be changed."""
        return False

    def release(self) -> None:
        """Nothing is held."""

    def grab(self) -> bool:
        """Wait for the next recorded frame."""
        until_s = self._clock.now() + _BETWEEN_S
        self._row = self._next_row()
        while self._row is None and self._clock.now() < until_s:
            self._clock.sleep_until(min(self._clock.now() + _LOOK_S, until_s))
            self._row = self._next_row()
        if self._row is not None:
            self._last_s = float(self._director.frame_due_s[self._row])
            self._clock.sleep_until(self._last_s)
        return True

    def _next_row(self) -> int | None:
        """Return the row of the next frame; None when none is near."""
        now_s, due_s = self._clock.now(), self._director.frame_due_s
        row = int(np.searchsorted(due_s, max(now_s, self._last_s), side="right"))
        return None if row == len(due_s) or due_s[row] > now_s + _NEAR_S else row

    def retrieve(self) -> tuple[bool, npt.NDArray[Any]]:
        """Return the frame that `grab` waited for."""
        run = self._director.run
        if self._row is not None and run is not None:
            return True, run.image(self._row)
        session = self._director.session
        return True, np.zeros(session.frame_shape or (1, 1), dtype=session.frame_dtype)

    def read(self) -> tuple[bool, npt.NDArray[Any]]:
        """`grab` and `retrieve`."""
        self.grab()
        return self.retrieve()


class _RecordedStage:
    """Where the load cell was is in the recording; a move during a run takes as long as then."""

    def __init__(self, director: Director, clock: Clock) -> None:
        self._director = director
        self._clock = clock

    def open(self) -> None:
        """Nothing is to be taken."""

    def move_to(self, position_m: float) -> bool:  # noqa: ARG002
        """Return True: it was there."""
        if self._director.run is not None:
            self._clock.sleep_until(self._clock.now() + self._director.move_s())
        return True

    def position(self) -> float | None:
        """Not asked again."""
        return None

    def close(self) -> None:
        """Nothing is to be let go of."""


class _Done:
    """Whatever is asked was done when the session was recorded, or nobody was asked then either.

    Runs are measured again as they were.
    """

    def __init__(self, session: RecordedSession) -> None:
        self.is_present = all(event.kind != "not asked" for event in session.events)
        runs = [run.planned for run in session.runs if run.planned.repeats is not None]
        self._repeated = [(run.configuration, run.position_m) for run in runs]

    def ask(self, prompt: Prompt) -> bool:
        """See `drivers.interfaces.Operator`."""
        place = (prompt.configuration, prompt.position_m)
        if prompt.kind != REPEAT or place not in self._repeated:
            return True
        self._repeated.remove(place)
        return False
