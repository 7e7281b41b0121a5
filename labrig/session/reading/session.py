"""A recorded session, opened for reading."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, Self

from labrig.config.about import About, recorded_about
from labrig.config.derived import SIMULATED
from labrig.errors import BadInputError, type_in_words
from labrig.files import AnyPath, path_of
from labrig.session.format import layout
from labrig.session.format.checksums import SUPPLEMENT_SUM
from labrig.session.format.devices import REPLAY_OF, boards_in_words
from labrig.session.marks.mark import Mark, states_of
from labrig.session.marks.stored import read_marks
from labrig.session.notes.note import Note
from labrig.session.notes.stored import read_photograph, read_stored
from labrig.session.notes.waiting import read_waiting
from labrig.session.reading.columns import (
    RUN_TABLE,
    reading_columns,
    run_cells,
    run_columns,
    run_numbers,
)
from labrig.session.reading.labelled_arrays import labelled_session
from labrig.session.reading.opening import cut_short, open_file
from labrig.session.reading.run_record import RunRecord
from labrig.session.reading.values import (
    damage_told,
    read_setup,
    read_table,
    read_text,
    text_attribute,
)
from labrig.session.supplements.store import is_sealed
from model.measurements import Displayed, Measurements, Summary, dataframe, is_number
from model.measurements.known_arguments import known_arguments
from protocols.execution.events import Outcome, OutputState
from protocols.planning.schedule import Schedule

if TYPE_CHECKING:
    import pandas as pd

# Differ from one recording of the same virtual run to the next.
VOLATILE = frozenset(
    {f"{layout.ENTRY}/{name}" for name in ("identifier", "start_time", "end_time", "checksums")}
)
OUTDATED = (
    "The analysis is out of date: runs or readings were marked since it was made; run labrig "
    "analyze again."
)
VOLATILE_UNDER = f"{layout.SETUP}/versions/"
_CONTINUES = re.compile(layout.CONTINUES.format(r"(\S+)", r"(\d+(?:, \d+)*)"))


@dataclass(frozen=True, kw_only=True)
class LoggedEvent:
    """A line of the session's log. `run` and `reading` are -1 where it concerns none."""

    time_s: float
    kind: str
    run: int
    reading: int
    subject: str
    text: str


class RecordedSession(Displayed):
    """An open session file. Close it, or use it in a `with` statement.

    What was recorded is in `runs` (each with `readings`, `time_s`, `signal_V(channel)` and
    `image(row)`), `events` and `notes`. `to_dataframe()` has the readings of all runs,
    `to_xarray()` all of it. Forces and curves of an analysed session are those of
    `labrig.load_measurements(session)`. Wherever labrig takes a session's file, it takes an open
    session, too.
    """

    def __init__(self, file: Any, path: Path) -> None:
        self.path = path
        self._file = file
        self._setup = read_setup(file, path)
        self.identifier: str = self._setup.identifier
        self.schedule: Schedule = self._setup.schedule
        self.texts: Mapping[str, str] = self._setup.texts
        self.resolved: Mapping[str, Any] = self._setup.resolved
        self.versions: Mapping[str, str] = self._setup.versions
        self.channels = self._setup.channels
        self.signals = self._setup.signals  # the channels, described
        self.ranges_V = tuple(channel.range_V for channel in self.signals)
        self.version = self._setup.version  # of the file's layout
        self.rate_hz = self._setup.rate_hz
        self.frame_shape = self._setup.frame_shape
        self.frame_dtype = self._setup.frame_dtype
        self.keep_all_frames = self._setup.keep_all_frames
        self.simulated = self._setup.simulated
        self.devices = self._setup.devices  # none in sessions before version 3
        # Planned ones, begun or not, and those that were measured again; `run` finds one by index.
        self.runs: tuple[RunRecord, ...] = tuple(self._records())

    def __fspath__(self) -> str:
        """Return the file's path: an open session stands for its file."""
        return str(self.path)

    def summary(self) -> Summary:
        """Return the outcome and a row for each run."""
        if not self._file:
            return Summary(f"RecordedSession {self.path}: closed")
        began = f", {self.started}" if self.started else ""
        output = "imported tables" if self.imported else f"output {self.output_state.value}"
        return Summary(
            f"RecordedSession {self.path}: {self.outcome.value}{began}, {output}",
            RUN_TABLE,
            [run_cells(run) for run in self.runs],
            (self.reason,) if self.reason else (),
        )

    def to_dataframe(self, part: Literal["readings", "runs"] = "readings") -> pd.DataFrame:
        """Return a part of the session as a pandas data frame.

        part: `readings` (a row for each, with the values of its channels in SI units, marks
        included) or `runs` (a row for each). The samples of a run are those of
        `session.run(index).to_dataframe()`. `run` and `reading` count from 0, as `index` does;
        labrig show and labrig mark count from 1.

        Raises BadInputError for another part, MissingPandasError where pandas is not installed.
        """
        if part == "readings":
            return dataframe(reading_columns(self.runs))
        if part == "runs":
            return dataframe(run_columns(self.runs))
        raise BadInputError(f"a session has no part '{part}', but readings, runs.")

    def run(self, index: int) -> RunRecord:
        """Return the run of an index, which counts from 0: `run(0)` is run 1 in words.

        Raises BadInputError.
        """
        for run in self.runs:
            if run.planned.index == index:
                return run
        if not is_number(index):
            raise BadInputError(f"{self.path}: run {index!r}: an index is needed, from 0.")
        numbers = run_numbers(self.runs)
        has = f"its runs are {numbers}" if numbers else "it has none"
        raise BadInputError(f"{self.path}: there is no run {index + 1}; {has}.")

    def _records(self) -> Iterator[RunRecord]:
        for run in self.schedule.all_runs:
            record = RunRecord(
                self._file, self.path, run, self._setup, lambda: self.marks_after_end
            )
            if run.repeats is None or record.started:
                yield record

    @property
    def boards(self) -> str:
        """Whether its boards were simulated, in words; "none" of a session without runs."""
        if not self.runs:
            return "none"
        return boards_in_words(self.devices, simulated=self.simulated)

    @property
    def replay_of(self) -> str:
        """Identifier of the session that was played in the rig's place; empty of an original."""
        return self.versions.get(REPLAY_OF, "")

    @property
    def continues(self) -> Mapping[str, tuple[int, ...]]:
        """The sessions whose complete runs were copied into it, by identifier, and which runs."""
        told = (_CONTINUES.match(e.text) for e in self.events if e.kind == "resumed")
        return {
            match[1]: tuple(int(run) - 1 for run in match[2].split(", ")) for match in told if match
        }

    @property
    def outcome(self) -> Outcome:
        """How the session ended; `running` only in a session opened live."""
        try:
            return Outcome(self._status("outcome"))
        except ValueError:
            raise BadInputError(f"{self.path}: its outcome is damaged.") from None

    @property
    def was_closed(self) -> bool:
        """Whether the recording was ended properly: the checksums are the last thing written."""
        sums = read_table(self._file, layout.CHECKSUMS, layout.CHECKSUM_ROW, self.path)["sha256"]
        return self.outcome is not Outcome.RUNNING and bool((sums != "").all())

    @property
    def output_state(self) -> OutputState:
        """The last known state of the output."""
        try:
            return OutputState(self._status("output_state"))
        except ValueError:
            return OutputState.UNKNOWN

    @property
    def reason(self) -> str:
        """Why the session ended as it did."""
        return self._status("reason")

    @property
    def started(self) -> str:
        """Time of day at which the session began, ISO 8601, UTC."""
        return self._status("start_time")

    @property
    def ended(self) -> str:
        """Time of day at which it ended; empty when it crashed."""
        return self._status("end_time")

    @cached_property
    def events(self) -> list[LoggedEvent]:
        """The log, in order."""
        found: list[LoggedEvent] = []
        for row in read_table(self._file, layout.EVENTS, layout.EVENT_ROW, self.path):
            values = dict(zip(row.dtype.names, row.tolist(), strict=True))
            if values["kind"] == layout.MORE and found:
                first = found.pop()
                found.append(replace(first, text=first.text + values["text"]))
            else:
                found.append(LoggedEvent(**values))
        return found

    @cached_property
    def marks_after_end(self) -> tuple[Mark, ...]:
        """What was marked since the session was closed, and taken back, oldest first."""
        return read_marks(self._file, self.path)

    @property
    def data_checksum(self) -> str:
        """A sha256 (hex) of the recording with its marks: another one is other data to analyse."""
        return self.data_checksums[-1]

    @cached_property
    def data_checksums(self) -> tuple[str, ...]:
        """The same as it was before the first mark after the end, and after each of them."""
        if not self.marks_after_end:
            return (self.checksum,)
        during = (mark for run in self.runs for mark in run.marks_during)
        return states_of(self.checksum, during, self.marks_after_end)

    @property
    def outdated(self) -> str:
        """Why the measurements kept in the session are out of date, a sentence; else empty."""
        if not (self.has_measurements and self.marks_after_end):
            return ""
        made_of = read_text(self._file, f"{layout.DERIVED}/checksum", self.path)
        return "" if made_of == self.data_checksum else OUTDATED

    @property
    def state_checksum(self) -> str:
        """A sha256 (hex) of all that the file holds now: recording, analysis, notes and marks."""
        groups = [self._file.get(name) for name in layout.SUPPLEMENTS]
        sums = ["" if one is None else text_attribute(one, SUPPLEMENT_SUM) for one in groups]
        return hashlib.sha256(" ".join([self.checksum, *sums]).encode()).hexdigest()

    @property
    def clock(self) -> str:
        """`virtual` where no real time passed: boards simulated in the program; else `real`."""
        tables = self.resolved.get("rig", {})
        virtual = any(
            isinstance(table, dict) and table.get("address") == SIMULATED
            for table in (tables.values() if isinstance(tables, dict) else ())
        )
        return "virtual" if virtual else "real"

    @property
    def began_s(self) -> float:
        """Clock time of its first event: times since the start count from here."""
        return self.events[0].time_s if self.events else 0.0

    @property
    def started_s(self) -> float:
        """Clock time of the moment that `started` states: later than `began_s` where resumed."""
        return next((each.time_s for each in self.events if each.kind == "started"), self.began_s)

    @property
    def duration_s(self) -> float | None:
        """From its first event to its last, by its own clock; None: nothing was recorded."""
        times_s = [event.time_s for event in self.events if math.isfinite(event.time_s)]
        return times_s[-1] - times_s[0] if times_s else None

    @property
    def has_measurements(self) -> bool:
        """Whether the session holds what an analysis, or an import, made."""
        return layout.DERIVED in self._file

    @property
    def imported(self) -> bool:
        """Whether it holds imported tables: it has no runs then, and no output was driven."""
        return self.has_measurements and not self.runs

    @cached_property
    def about(self) -> About:
        """Title, people and sample as its about.toml stated them; empty where none did."""
        return recorded_about(self.texts)

    @property
    def notes(self) -> list[Note]:
        """What was added to the session, without photographs; also what still waits beside it."""
        found = read_stored(self._file, self.path)
        known = {note.identifier for note in found}
        waiting = read_waiting(self.path, self.identifier)
        rest = [replace(note, photograph=b"") for note in waiting if note.identifier not in known]
        return [*found, *rest]

    @property
    def notes_were_changed(self) -> bool:
        """Whether the notes in the file are not as they were added."""
        with damage_told(self.path, layout.NOTES):
            return layout.NOTES in self._file and not is_sealed(self._file[layout.NOTES])

    def photograph(self, identifier: str) -> bytes:
        """Return the photograph of a note. Raises BadInputError when there is none."""
        found = read_photograph(self._file, self.path, identifier)
        for note in () if found else read_waiting(self.path, self.identifier):
            if note.identifier == identifier:
                found = note.photograph
        if not found:
            raise BadInputError(f"{self.path}: there is no such photograph.")
        return found

    @cached_property
    def checksum(self) -> str:
        """A sha256 (hex) of all that was recorded; the same for two equal virtual sessions.

        It is made from the checksums written at the close, so it stays when a session is copied,
        analysed, or analysed again.
        """
        total = hashlib.sha256()
        for row in read_table(self._file, layout.CHECKSUMS, layout.CHECKSUM_ROW, self.path):
            name = str(row["dataset"])
            if name not in VOLATILE and not name.startswith(VOLATILE_UNDER):
                total.update(f"{name} {row['sha256']}\n".encode())
        return total.hexdigest()

    def to_xarray(self, measurements: Measurements | None = None) -> Any:
        """Return the session as an `xarray.DataTree` with named dimensions, coordinates and units.

        `/readings` has the value of each channel at each reading (dimension `reading`), `/signals`
        the raw samples of all runs (dimension `sample`). With `measurements`, as
        `labrig.load_measurements` returns them, `/curves` has the neutral curves (dimensions
        `curve` and `point`, padded with NaN). SI units, in the attribute `units`.

        Raises BadInputError where xarray is not installed, or content is damaged.
        """
        if measurements is not None and not isinstance(measurements, Measurements):
            raise BadInputError(
                "measurements: what labrig.load_measurements returns is needed, not "
                f"{type_in_words(measurements)}."
            )
        try:
            attributes = {"identifier": self.identifier, "start_time": self.started}
            attributes |= {"title": self.about.title} if self.about.title else {}
            began_s = self.events[0].time_s if self.events else 0.0
            return labelled_session(self.runs, attributes, measurements, began_s)
        except ModuleNotFoundError as error:
            raise BadInputError(
                f"to_xarray() needs the package {error.name}; install it with: "
                'pip install "labrig[xarray]".'
            ) from None

    def close(self) -> None:
        """Let go of the file; may be called twice."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        self.close()

    def _status(self, name: str) -> str:
        return read_text(self._file, f"{layout.ENTRY}/{name}", self.path)


@known_arguments
def open_session(path: AnyPath, *, live: bool = False) -> RecordedSession:
    """Open a session for reading.

    Raises BadInputError, in a sentence, for whatever is no whole session of this format. A session
    that is still being written opens with `live=True`, showing what was flushed by now.
    """
    path = path_of(path)
    file = open_file(path, live=live)
    try:
        session = RecordedSession(file, path)
        if not (live or session.was_closed):
            raise BadInputError(cut_short(path))
        return session
    except BaseException:
        file.close()
        raise
