"""The session file as a subscriber of the experiment's events."""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import h5py
import numpy as np

from drivers.interfaces import Frame, SignalBlock
from labrig.errors import BadInputError, LabrigError
from labrig.files import typed
from labrig.session.format import layout
from labrig.session.format.channels import as_recorded
from labrig.session.format.devices import RecordedDevice
from labrig.session.format.setup import SessionSetup, present_versions
from labrig.session.notes.add import add_waiting
from labrig.session.notes.waiting import holds_notes, waiting_path
from labrig.session.recording.create import create_file
from labrig.session.recording.disk import cause, note_a_failed_write, sync_file, sync_folder
from labrig.session.recording.journal import Journal, journal_path
from labrig.session.recording.locking import is_locked
from labrig.session.recording.recorder import Recorder
from labrig.session.recording.rows import Translator
from labrig.session.recording.write_queue import StalledError, WriteQueue
from protocols.execution import events as ev
from protocols.execution.channels import Channel
from protocols.execution.events import Outcome, OutputState
from protocols.planning.schedule import Schedule

FLUSH_S = 0.2  # of the file, so that a reader is never more than a quarter of a second behind
PATIENCE_S = 5.0  # with a disk that does not answer
QUEUE_BYTES = 256 << 20
CLOSE_S = 60.0  # for all that is queued to reach the disk

# After these the journal is on the disk before the next event is recorded.
_SYNCED = (
    ev.ReadingTaken,
    ev.ReadingMarked,
    ev.RunStarted,
    ev.RunStopped,
    ev.OutputChanged,
    ev.SessionStarted,
    ev.SessionStopped,
)


class WriterError(LabrigError):
    """The session cannot be recorded any further; what came before is safe."""


class SessionWriter:
    """Records a session at `path` while it runs.

    The file is there, and can be read by others, when the constructor returns; its outcome is
    `running` until `SessionStopped` came and `close` was called. `handle` only queues; a thread
    of its own packs, writes the journal, syncs it, and writes the file. When that thread fails, or
    the disk does not answer for 5 s, the next `handle` raises WriterError, and so does `close`.
    """

    def __init__(
        self,
        path: Path,
        *,
        schedule: Schedule,
        texts: Mapping[str, str],
        resolved: Mapping[str, Any],
        channels: Sequence[Channel],
        rate_hz: float,
        frame_shape: tuple[int, int] | None,
        frame_dtype: np.dtype[Any] | str = "uint8",
        keep_all_frames: bool = False,
        simulated: bool = False,
        devices: Sequence[RecordedDevice] = (),
        parts: Mapping[str, str] | None = None,
        patience_s: float = PATIENCE_S,
    ) -> None:
        """Create the file. Raises BadInputError when it exists or its folder cannot be used.

        `parts`: other distributions' parts that the rig is made of, with their versions.
        """
        self.path = Path(path)
        self._setup = SessionSetup(
            schedule=schedule,
            texts=dict(texts),
            resolved=dict(resolved),
            signals=tuple(map(as_recorded, channels)),
            rate_hz=float(rate_hz),
            frame_shape=frame_shape,
            frame_dtype=np.dtype(frame_dtype).name,
            keep_all_frames=keep_all_frames,
            simulated=simulated,
            devices=tuple(devices),
            versions=present_versions() | dict(parts or {}),
        )
        self._journal = _begin(self.path, self._setup)
        self._translator = Translator(self._setup)
        self._queue: WriteQueue[ev.Event] = WriteQueue(QUEUE_BYTES, patience_s)
        self._failure: Exception | None = None
        self._stopped = False
        self._closed = False
        self._thread = threading.Thread(target=self._work, name="session-writer", daemon=True)
        self._thread.start()

    @property
    def setup(self) -> SessionSetup:
        """What the file was made from."""
        return self._setup

    @property
    def identifier(self) -> str:
        """The session's own identifier."""
        return self._setup.identifier

    # ----------------------------------------------------------------------- the caller's thread

    def handle(self, event: ev.Event) -> None:
        """Queue an event. Raises WriterError when the session is not being recorded any more."""
        if self._failure is not None:
            raise self._sentence(self._failure) from self._failure
        if self._queue.closed:
            raise WriterError(f"{self.path} is closed; nothing more can be recorded in it.")
        if isinstance(event, ev.SessionStopped):
            self._stopped = True
        event = _kept(event)
        try:
            self._queue.put(event, _size(event))
        except StalledError as error:
            self._failure = error
            raise self._sentence(error) from error

    def close(self) -> None:
        """Write all that is queued, finish the file and remove the journal; may be called twice.

        Notes that wait beside the file are added to it.
        Raises WriterError when the session was not recorded to its end.
        """
        if self._closed:
            return
        self._closed = True
        if not self._stopped and self._failure is None:
            self.handle(_nobody_said_how())
        self._queue.close()
        self._thread.join(CLOSE_S if self._failure is None else PATIENCE_S)
        if self._thread.is_alive() and self._failure is None:
            self._failure = StalledError(f"the disk has not answered for {CLOSE_S:g} s")
        if self._failure is not None:
            raise self._sentence(self._failure) from self._failure
        # What the disk does not take now waits on beside the session, and is shown with it.
        with contextlib.suppress(LabrigError):
            add_waiting(self.path)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        self.close()

    def _sentence(self, error: Exception) -> WriterError:
        folder = self.path.parent
        if not folder.is_dir():
            return WriterError(
                f"The session can no longer be recorded: the folder {folder} was removed or "
                "renamed. Where it was renamed, run labrig recover on the session there"
            )
        return WriterError(
            f"The session can no longer be recorded in {self.path}: {cause(error)}. What came "
            f"before is in the file and its journal; run: labrig recover {typed(self.path)}"
        )

    # ----------------------------------------------------------------------- the writer's thread

    def _work(self) -> None:
        file = None
        try:
            # Unlocked: the journal's lock keeps other writers out, and a viewer that has the file
            # open at this moment must not end the recording.
            file = h5py.File(self.path, "r+", libver=layout.LIBVER, locking=False)
            file.swmr_mode = True
            self._record(file)
            file.close()
            sync_file(self.path)
            self._journal.remove()
        except Exception as error:  # noqa: BLE001 - the thread's last word; handle() raises it
            self._failure = self._failure or error
            note_a_failed_write()
            self._queue.drop()
            _close_what_will_close(file)
            self._journal.close()

    def _record(self, file: Any) -> None:
        recorder = Recorder(file)
        try:
            self._record_all(file, recorder)
            if self._failure is not None:  # events were turned away: this is not a whole session
                raise self._failure
        except Exception:
            with contextlib.suppress(Exception):  # the first failure is the one that is reported
                recorder.put()
            raise
        recorder.write_checksums()

    def _record_all(self, file: Any, recorder: Recorder) -> None:
        flushed_s = time.monotonic()
        wants_sync = dirty = False
        while not self._queue.ended:
            event = self._queue.take(FLUSH_S)
            if event is not None:
                self._write(event, recorder)
                dirty = True
                wants_sync = wants_sync or isinstance(event, _SYNCED)
            late = time.monotonic() - flushed_s >= FLUSH_S
            # One sync serves all that is queued, but none waits for longer than a flush does.
            if wants_sync and (late or self._queue.empty):
                self._journal.sync()
                wants_sync = False
            if dirty and late:
                recorder.put()
                file.flush()
                flushed_s, dirty = time.monotonic(), False

    def _write(self, event: ev.Event, recorder: Recorder) -> None:
        for rows in self._translator.rows(event):
            self._journal.append(rows)
            recorder.apply(rows)
        if isinstance(event, ev.RunStopped):
            recorder.let_go()


def _begin(path: Path, setup: SessionSetup) -> Journal:
    """Make journal and file; the file appears at its path whole, or not at all."""
    if path.exists():
        raise BadInputError(f"{path} exists already; choose another name.")
    if holds_notes(path):
        raise BadInputError(
            f"{waiting_path(path)} holds notes of an earlier session; move it away, or choose "
            "another name."
        )
    beside = path.with_name(f"{path.name}.{os.getpid()}.new")
    try:
        journal = Journal(journal_path(path), setup)
    except FileExistsError:
        if is_locked(journal_path(path)):
            raise BadInputError(
                f"another labrig is making a session at {path}; choose another name."
            ) from None
        raise BadInputError(
            f"{journal_path(path)} is left from an earlier session; run labrig recover "
            f"{typed(path)}, or choose another name."
        ) from None
    except OSError as error:
        raise BadInputError(f"{path} cannot be written: {cause(error)}.") from None
    try:
        create_file(beside, setup)
        beside.rename(path)
        sync_folder(path.parent)
    except BaseException as error:
        journal.remove()
        beside.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise BadInputError(f"{path} cannot be written: {cause(error)}.") from None
        raise
    return journal


def _kept(event: ev.Event) -> ev.Event:
    """Return the event with arrays of its own: a driver may use its buffers again."""
    match event:
        case ev.SignalsArrived(block=block) if block.volts.base is not None:
            own = SignalBlock(block.first_index, block.volts.copy(), block.read_s)
            return ev.SignalsArrived(event.time_s, event.run, own)
        case _:
            return event


def _size(event: ev.Event) -> int:
    def of(frame: Frame | None) -> int:
        return 0 if frame is None else frame.image.nbytes

    match event:
        case ev.SignalsArrived():
            return 200 + event.block.volts.nbytes
        case ev.ReadingTaken():
            return 500 + of(event.frame)
        case ev.FramesArrived():
            return 200 + sum(of(frame) for frame in event.frames)
        case _:
            return 500


def _nobody_said_how() -> ev.SessionStopped:
    return ev.SessionStopped(
        time_s=float("nan"),
        outcome=Outcome.FAILED,
        reason="The program ended the recording without saying how the session went.",
        output=OutputState.UNKNOWN,
        wall="",
    )


def _close_what_will_close(file: Any) -> None:
    if file is None:
        return
    with contextlib.suppress(Exception):  # the first failure is the one that is reported
        file.close()
