"""Runs the queue: begins the next session when the one before is completed, and never otherwise."""

from __future__ import annotations

import datetime as dt
import secrets
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, Protocol

from labrig.errors import BadInputError, ExitCode, LabrigError
from labrig.experiment.queue import QueuedRun, faults_of
from labrig.panel.errors import MissingError, NotNowError
from labrig.panel.job import Order
from labrig.panel.job.jobs import Jobs
from labrig.panel.job.registry import GOING, JobAddress, read_address
from labrig.panel.live.event_stream import Message
from labrig.panel.queue.entries import Entry, Queue, State, read_queue, write_queue
from protocols.planning.description import describe

POLL_S = 0.5
MOST_ENTRIES = 100
_RESTARTED = "The panel was started again meanwhile; start the queue to continue it."


class Orders(Protocol):
    """Makes the order of a run, as `Panel.order` does."""

    def __call__(self, kind: Literal["run"], who: str, **more: Any) -> Order:
        """Return the order."""


class RunQueue:
    """The queue of a panel. Its methods may be called from any thread; `close` at the end."""

    def __init__(
        self,
        *,
        data: Path,
        rig: Path,
        jobs: Jobs,
        order: Orders,
        publish: Callable[[Message], None],
        log: Callable[[str, str], None],
    ) -> None:
        self._data, self._rig, self._jobs = data, rig, jobs
        self._order, self._publish, self._log = order, publish, log
        self._lock = threading.RLock()
        self._wake = threading.Event()
        self._closed = False
        self._queue = self._found_again(read_queue(data))
        publish(self._queue.message())
        self._thread = threading.Thread(target=self._work, name="panel-queue", daemon=True)
        self._thread.start()

    @property
    def queue(self) -> Queue:
        """The queue as it is now."""
        return self._queue

    def close(self) -> None:
        """Begin nothing more; what runs goes on."""
        self._closed = True
        self._wake.set()
        self._thread.join(2.0)

    # ------------------------------------------------------------------------- what pages ask for

    def add(self, entry: Entry) -> Entry:
        """Add a session at the end. Raises BadInputError for whatever keeps it from beginning."""
        with self._changing() as queue:
            if len(queue.entries) >= MOST_ENTRIES:
                raise BadInputError(f"the queue holds {MOST_ENTRIES} sessions; remove some.")
            taken = {one.session for one in queue.entries if one.state is State.WAITING}
            entry = entry if entry.session else replace(entry, session=self._name(entry, taken))
            if entry.session in taken:
                raise BadInputError(f"{entry.session}: is in the queue already.")
            _refuse(faults_of([self._run_of(entry)]))
            estimate_s = describe(self._run_of(entry).plan().schedule).estimate_s
            entry = replace(entry, id=secrets.token_hex(6), estimate_s=estimate_s)
            self._queue = replace(queue, entries=(*queue.entries, entry))
        return entry

    def remove(self, entry_id: str) -> None:
        """Remove an entry that does not run."""
        with self._changing() as queue:
            if self._entry(entry_id).state is State.RUNNING:
                raise NotNowError("this session is running; stop it first.")
            rest = tuple(one for one in queue.entries if one.id != entry_id)
            self._queue = replace(queue, entries=rest)

    def move(self, entry_id: str, by: int) -> None:
        """Move a waiting entry up (negative) or down among those that wait."""
        with self._changing() as queue:
            entry = self._entry(entry_id)
            if entry.state is not State.WAITING:
                raise NotNowError("only a session that waits can be moved.")
            waiting = [one for one in queue.entries if one.state is State.WAITING]
            place = waiting.index(entry)
            waiting.insert(max(0, min(place + by, len(waiting) - 1)), waiting.pop(place))
            others = tuple(one for one in queue.entries if one.state is not State.WAITING)
            self._queue = replace(queue, entries=(*others, *waiting))

    def start(self, who: str) -> None:
        """Begin with the first that waits, after all that wait were checked."""
        with self._changing() as queue:
            if queue.going:
                raise NotNowError("the queue goes on already.")
            waiting = [one for one in queue.entries if one.state is State.WAITING]
            if not waiting:
                raise BadInputError("no session waits in the queue; add one.")
            if self._jobs.going:
                raise NotNowError("a job is going on; start the queue when it is over.")
            _refuse(faults_of([self._run_of(entry) for entry in waiting]))
            self._queue = replace(queue, going=True, by=who, text="")
        self._wake.set()

    def hold(self, why: str) -> None:
        """Begin no further session; the one that runs is not touched."""
        with self._changing() as queue:
            self._queue = replace(queue, going=False, text=why)

    # ----------------------------------------------------------------------------- in our thread

    def _work(self) -> None:
        while not self._closed:
            with suppress(LabrigError):  # of the file of the queue: tried again
                self._step()
            self._wake.wait(POLL_S)
            self._wake.clear()

    def _step(self) -> None:
        """Settle the session that runs, then begin the next one."""
        running = self._queue.first(State.RUNNING)
        if running is not None:
            self._settle(running)
        elif self._queue.going and not self._jobs.going and not self._closed:
            self._begin_next()

    def _settle(self, entry: Entry) -> None:
        address = self._jobs.address
        if address is None:
            return  # a panel that was started again has not found the job yet
        if address.id != entry.job:
            self._stop_at(entry, "its end was not seen: another job was begun")
        elif address.state != GOING:
            with self._changing():
                self._end(entry, address)

    def _begin_next(self) -> None:
        with self._lock:
            entry, who = self._queue.first(State.WAITING), self._queue.by
            if entry is None:
                self.hold("All sessions of the queue are completed.")
                return
        run = self._run_of(entry)
        try:
            _refuse(faults_of([run]))  # the files may have changed since the queue was started
            order = self._order(
                "run",
                who,
                session=str(run.session),
                protocol=str(run.protocol),
                sheet=str(run.sheet),
                clock=entry.clock,
                about=entry.about,
            )
            with self._changing():  # first: a job that cannot be found again begins nothing more
                self._change(replace(entry, state=State.RUNNING, job=order.id))
            run.session.parent.mkdir(parents=True, exist_ok=True)
            self._jobs.start(order)
            self._log(who, f"the queue started the run {entry.session}")
        except (LabrigError, OSError) as error:
            self._stop_at(entry, str(error))

    def _end(self, entry: Entry, address: JobAddress) -> None:
        """Note how a session's job has ended; go on only when it is completed."""
        if address.code == ExitCode.DONE:
            self._change(replace(entry, state=State.COMPLETED, text=address.text))
            return
        self._stop_at(entry, address.text)

    def _stop_at(self, entry: Entry, why: str) -> None:
        with self._changing():
            self._change(replace(self._entry(entry.id), state=State.STOPPED, text=why))
            text = f"{entry.session} was not completed, so nothing more was begun."
            self._queue = replace(self._queue, going=False, text=text)

    # ---------------------------------------------------------------------------------- our parts

    @contextmanager
    def _changing(self) -> Iterator[Queue]:
        """Change the queue; it is kept, published, and as before when that fails."""
        with self._lock:
            before = self._queue
            try:
                yield before
                if self._queue != before:
                    write_queue(self._data, self._queue)
            except BaseException:
                self._queue = before
                raise
            if self._queue != before:
                self._publish(self._queue.message())

    def _change(self, entry: Entry) -> None:
        entries = tuple(entry if one.id == entry.id else one for one in self._queue.entries)
        self._queue = replace(self._queue, entries=entries)

    def _entry(self, entry_id: str) -> Entry:
        for entry in self._queue.entries:
            if entry.id == entry_id:
                return entry
        raise MissingError("there is no such session in the queue.")

    def _run_of(self, entry: Entry) -> QueuedRun:
        folder = self._rig.parent
        return QueuedRun(
            rig=self._rig,
            protocol=folder / entry.protocol,
            sheet=folder / entry.sheet,
            session=self._data / entry.session,
            about=entry.about,
        )

    def _name(self, entry: Entry, taken: set[str]) -> str:
        """Return a name that no session has: PROTOCOL-DAY-N.h5."""
        day = dt.date.today()  # noqa: DTZ011 - the day at the rig
        stem = f"{Path(entry.protocol).stem}-{day}"
        names = (f"{stem}-{number}.h5" for number in range(1, 10_000))
        return next(
            name for name in names if name not in taken and not (self._data / name).exists()
        )

    def _found_again(self, queue: Queue) -> Queue:
        """Return the queue of a panel that was started again: it goes on with a run that lives."""
        running, address = queue.first(State.RUNNING), read_address(self._data)
        if running is None:
            return replace(queue, going=False, text=_RESTARTED) if queue.going else queue
        if address is not None and address.id == running.job and address.state == GOING:
            return queue
        self._queue = replace(queue, going=False, text=_RESTARTED)
        if address is not None and address.id == running.job and address.code == ExitCode.DONE:
            self._change(replace(running, state=State.COMPLETED, text=address.text))
        else:
            why = address.text if address and address.id == running.job else "its end is not known"
            self._change(replace(running, state=State.STOPPED, text=why))
        return self._queue


def _refuse(faults: list[str]) -> None:
    if faults:
        raise BadInputError(" ".join(faults))
