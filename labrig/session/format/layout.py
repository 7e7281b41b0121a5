"""The session file's layout, version 6: every group, dataset and type has its name here.

/                       NXroot, default -> session, labrig_format
/session                NXentry, default -> data; definition NXsensor_scan
  identifier, outcome, reason, output_state, start_time, end_time
  process/              NXprocess: the program that recorded it
  data/                 NXdata: the readings of all runs in plain columns; links to the sensors
  instrument/environment/COLUMN/  NXsensor: value, one for each reading of all runs
  events              the log, a row for each event (a long text goes on in rows of kind +)
  checksums           sha256 of every other group and dataset, written at the close
  title, project, license, user_1/ (NXuser), ..., sample/ (NXsample): what about.toml states
  additional/           NXcollection: for anybody's additions, which labrig does not check
  setup/              schedule and resolved configuration (JSON), texts/NAME, versions/PACKAGE,
                      signals (name, range, quantity, unit, gain, offset of each channel), rate_hz,
                      simulated, devices (JSON: what each device says that it is), keep_all_frames,
                      extras (JSON: of runs of extras, what the schedule does not hold of them)
  run_000/            NXsubentry, default -> signals; one for each planned run, and after them
                      one to measure each measurement again, never begun where nobody wanted that
    planned           the run as planned (JSON)
    acquisition       sample clock, start, counts
    writes            each write of the voltage
    control           with a controller: each of its periods, and the voltage that it wrote
    readings          each reading, as seen while running
    marks             readings declared invalid during the session
    signals/          NXdata: raw samples in V, a dataset for each channel, and their time
    frames/           NXdata: images, time, number, device_time, sample_index, reading,
                      device_number, trigger_time
Supplements, groups that are added to a closed session; each has a checksum of its own:
  derived/            what the analysis made of it; may be dropped and made again
  notes/              the operator's notes and photographs
  marks/entries       runs and readings declared invalid after the end, or that taken back; a row
                      each, with a checksum that covers the one of the row before
A checksum covers content, type and shape of a dataset and attributes of both; that of a
supplement, its attribute `sha256`, covers everything in the group.

Before version 6 there were no device_number and trigger_time of a frame, and no counts of frames
that came incomplete or never came. Before version 5 text attributes had fixed lengths,
`acquisition` was a scalar, the default of the entry was run_000, and there were no columns of all
readings. Version 3 has no controlled runs. Version 2 has checksums of the content of datasets only
and no devices. In version 1 `signals` holds names and ranges only, and the values of a reading are
always force_N, drive_V and current_A; since version 2 they are those of the session's channels, a
column each.
Datasets have fixed-length types only and grow by appended rows; nothing in them depends on when
they were flushed. Anything else in a file is refused when it is opened. The attribute
`column_units` of a table holds the unit of each column, empty where there is none; `comment` says
from where runs and readings count.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import h5py
import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]

FORMAT: Final = 6  # that is written
READABLE: Final = (1, 2, 3, 4, 5, 6)
TRIGGERS_SINCE: Final = 6  # version in which frames have the camera's number and their trigger
NEXUS_SINCE: Final = 5  # version in which NeXus libraries find entry, sensors and data
# The oldest file format with single-writer-multiple-reader, so that any viewer since 2016 opens it.
LIBVER: Final = ("v110", "v110")
ENTRY: Final = "/session"
SETUP: Final = "/session/setup"
DERIVED: Final = "/session/derived"
NOTES: Final = "/session/notes"
MARKS: Final = "/session/marks"
SUPPLEMENTS: Final = (DERIVED, NOTES, MARKS)
ADDITIONAL: Final = "/session/additional"
DATA: Final = "/session/data"
ENVIRONMENT: Final = "/session/instrument/environment"
CHECKSUMS: Final = "/session/checksums"
EVENTS: Final = "/session/events"
MORE: Final = "+"  # kind of an event row that continues the text of the row before
# Text of an event `resumed`: the session that it continues, and its runs that were taken.
CONTINUES: Final = "continues the session {}; taken there: runs {}"
NO_RUNS: Final = "none"
NOBODY_ANSWERED: Final = "nobody answered"  # text of an event `answered`: as if "done"
MOVE_BEGAN: Final = "load cell left"  # kinds of the events of a load cell moved during a run
MOVE_ENDED: Final = "load cell arrived"  # subject: where by the stage, "9.9980 mm", if it says
NO_FRAME: Final = -1
EVENT_TEXT_BYTES: Final = 240


def text_type(size: int) -> np.dtype[Any]:
    """Return a fixed-length UTF-8 string of at most `size` bytes."""
    made: np.dtype[Any] = h5py.string_dtype("utf-8", max(size, 1))
    return made


def cut(text: str, size: int) -> bytes:
    """UTF-8 bytes of a text, cut between two characters to at most `size` bytes."""
    raw = text.encode("utf-8")
    if len(raw) <= size:
        return raw
    mark = "…".encode()
    return raw[: size - len(mark)].decode("utf-8", "ignore").encode("utf-8") + mark


def pieces(text: str, size: int) -> list[bytes]:
    """UTF-8 bytes of a text in pieces of at most `size` bytes; no character is split."""
    raw = text.encode("utf-8")
    found: list[bytes] = []
    while len(raw) > size:
        piece = raw[:size].decode("utf-8", "ignore").encode("utf-8")
        found.append(piece)
        raw = raw[len(piece) :]
    return [*found, raw]


# Scalar texts that change while a session runs: name -> bytes.
STATUS_TEXTS: Final = {
    "outcome": 16,
    "reason": 1000,
    "output_state": 16,
    "start_time": 40,
    "end_time": 40,
}

# `dataset` is the full name of a dataset or, since version 3, of a group.
CHECKSUM_ROW: Final = np.dtype([("dataset", text_type(200)), ("sha256", text_type(64))])
QUANTITY_BYTES: Final = 64
# `range_V` of a force that a meter reads is in N, as the `units` of its samples say.
_SIGNAL_1: Final = [("name", text_type(64)), ("range_V", "<f8")]
_SIGNAL_2: Final = [
    *_SIGNAL_1,
    ("quantity", text_type(QUANTITY_BYTES)),
    ("unit", text_type(24)),
    ("gain", "<f8"),  # unit per V; NaN: converted by a calibration of its own
    ("offset", "<f8"),  # in the unit, at 0 V
]
SIGNAL_ROWS: Final = {  # by version
    1: np.dtype(_SIGNAL_1),
    2: np.dtype(_SIGNAL_2),
    3: np.dtype(_SIGNAL_2),
    4: np.dtype(_SIGNAL_2),
    5: np.dtype(_SIGNAL_2),
    6: np.dtype(_SIGNAL_2),
}
EVENT_ROW: Final = np.dtype(
    [
        ("time_s", "<f8"),
        ("kind", text_type(24)),
        ("run", "<i4"),
        ("reading", "<i4"),
        ("subject", text_type(24)),
        ("text", text_type(EVENT_TEXT_BYTES)),
    ]
)
_ACQUISITION_1: Final = [
    ("started", "?"),
    ("stopped", "?"),
    ("completed", "?"),
    ("time_zero_s", "<f8"),  # clock time of the run's time 0
    ("clock_start_s", "<f8"),  # clock time of sample 0
    ("clock_start_uncertainty_s", "<f8"),
    ("rate_hz", "<f8"),
    ("stage_position_m", "<f8"),  # NaN: nothing reported it
    ("since_wetting_s", "<f8"),  # NaN: not known
    ("lost_samples", "<i8"),
    ("frames_grabbed", "<i8"),
    ("frames_dropped", "<i8"),
]
_ACQUISITION_6: Final = [
    *_ACQUISITION_1,
    ("frames_incomplete", "<i8"),
    ("frames_missed", "<i8"),
]


def acquisition_row(version: int) -> np.dtype[Any]:
    """Return the type of a run's acquisition."""
    return np.dtype(_ACQUISITION_6 if version >= TRIGGERS_SINCE else _ACQUISITION_1)


WRITE_ROW: Final = np.dtype(
    [
        ("step", "<i4"),
        ("planned_s", "<f8"),  # since the run's time 0
        ("due_s", "<f8"),  # clock times
        ("before_s", "<f8"),
        ("after_s", "<f8"),
        ("lateness_s", "<f8"),  # middle of before and after, minus due
        ("sample_index", "<f8"),  # of that middle
        ("sheet_V", "<f8"),
        ("board_V", "<f8"),
    ]
)
CONTROL_ROW: Final = np.dtype(
    [
        ("planned_s", "<f8"),  # since the run's time 0
        ("due_s", "<f8"),  # clock times
        ("before_s", "<f8"),
        ("after_s", "<f8"),
        ("sample_index", "<f8"),  # of the newest sample that the controller knew
        ("zero_N", "<f8"),  # the force at 0 V before the run: the next two count from it
        ("reference_N", "<f8"),
        ("force_N", "<f8"),
        ("wanted_V", "<f8"),  # by the controller; sheet_V is within the limits
        ("sheet_V", "<f8"),
        ("board_V", "<f8"),
    ]
)
_READING_BEFORE: Final = [
    ("index", "<i4"),
    ("step", "<i4"),
    ("kind", text_type(16)),
    ("voltage_V", "<f8"),
    ("planned_s", "<f8"),  # since the run's time 0
    ("time_s", "<f8"),  # the same, of the sampling point as it was
    ("sample_index", "<f8"),
]
_READING_AFTER: Final = [
    ("frame", "<i4"),  # row of frames/images; -1: none
    ("frame_offset_s", "<f8"),
    ("valid", "?"),
    ("why", text_type(240)),
]
READING_COLUMNS: Final = tuple(name for name, _ in (*_READING_BEFORE, *_READING_AFTER))


def reading_row(values: Sequence[str]) -> np.dtype[Any]:
    """Return the type of a reading with these columns for the values of its channels."""
    return np.dtype([*_READING_BEFORE, *((name, "<f8") for name in values), *_READING_AFTER])


MARK_ROW: Final = np.dtype(
    [
        ("time_s", "<f8"),
        ("reading", "<i4"),  # -1: the whole run
        ("why", text_type(240)),
        ("who", text_type(64)),
    ]
)
MARK_WHY_BYTES: Final = 240
MARK_WHO_BYTES: Final = 64
END_MARK_ROW: Final = np.dtype(  # of a mark after the end
    [
        ("when", text_type(40)),  # ISO 8601, UTC
        ("run", "<i4"),
        ("reading", "<i4"),  # -1: the whole run
        ("invalid", "?"),  # False: a mark is taken back
        ("why", text_type(MARK_WHY_BYTES)),
        ("who", text_type(MARK_WHO_BYTES)),
        ("sha256", text_type(64)),  # of this row and that of the row before
    ]
)
# One value a frame, beside the image itself: name -> (type, unit).
_FRAME_COLUMNS_1: Final = {
    "time": ("<f8", "s"),  # since the run's time 0
    "number": ("<i8", ""),
    "device_time": ("<f8", "s"),  # NaN: the camera gives none
    "sample_index": ("<f8", ""),
    "reading": ("<i4", ""),  # -1: no reading's frame
}
_FRAME_COLUMNS_6: Final = {
    "device_number": ("<i8", ""),  # the camera's own; -1: it gives none
    "trigger_time": ("<f8", "s"),  # since the run's time 0; NaN: nothing triggered it
}


def frame_columns(version: int) -> dict[str, tuple[str, str]]:
    """Return the columns of frames: name -> (type, unit)."""
    return _FRAME_COLUMNS_1 | (_FRAME_COLUMNS_6 if version >= TRIGGERS_SINCE else {})


# One value a reading in `data`, beside the sensors' values: name -> (type, unit).
SCAN_COLUMNS: Final = {
    "time_s": ("<f8", "s"),  # of the sampling point, since the first event
    "voltage_V": ("<f8", "V"),
    "position_m": ("<f8", "m"),  # NaN: free
    "run": ("<i4", ""),
    "reading": ("<i4", ""),  # number within the run
    "valid": ("<u1", ""),
}

# The attribute `comment` of columns and tables that can be misread.
FROM_0: Final = "counted from 0; labrig show and labrig mark count from 1"
AS_RECORDED: Final = "as recorded; later marks are in /session/marks"
SCAN_COMMENTS: Final = {"run": FROM_0, "reading": FROM_0, "valid": AS_RECORDED}
FRAME_COMMENTS: Final = {"reading": f"{FROM_0}; -1: a frame of no reading"}
READINGS_COMMENT: Final = f"index is {FROM_0}; valid is {AS_RECORDED}"
MARKS_COMMENT: Final = f"reading is {FROM_0}; -1: the whole run"
END_MARKS_COMMENT: Final = f"run and reading are {FROM_0}; reading -1: the whole run"
EVENTS_COMMENT: Final = f"run and reading are {FROM_0}; -1: none"


def in_additional(name: str) -> bool:
    """Whether a full name is that of the group in which anybody may add anything, or inside it."""
    return name == ADDITIONAL or name.startswith(f"{ADDITIONAL}/")


def in_supplement(name: str) -> bool:
    """Whether a full name is that of a supplement, or of something in one."""
    return any(name == group or name.startswith(f"{group}/") for group in SUPPLEMENTS)


def run_path(run: int) -> str:
    """Path of a run's group."""
    return f"{ENTRY}/run_{run:03d}"


def signal_path(run: int, channel: str) -> str:
    """Path of a channel's raw samples; `time` is their time."""
    return f"{run_path(run)}/signals/{channel}"


def frame_path(run: int, column: str) -> str:
    """Path of a run's images, or of one of `FRAME_COLUMNS`."""
    return f"{run_path(run)}/frames/{column}"


def scan_path(column: str) -> str:
    """Path of a column of the readings of all runs."""
    return f"{DATA}/{column}" if column in SCAN_COLUMNS else sensor_path(column)


def sensor_path(column: str) -> str:
    """Path of a sensor's values, one for each reading of all runs."""
    return f"{ENVIRONMENT}/{column}/value"


def link_target(name: str) -> str:
    """Where the link of this full name leads; empty where a session has no link."""
    group, _, column = name.rpartition("/")
    return sensor_path(column) if group == DATA and column not in SCAN_COLUMNS else ""


def signal_chunk(rate_hz: float) -> int:
    """Return the samples in a chunk: about a quarter of a second, a power of two."""
    return int(min(65536, max(256, 2 ** round(np.log2(max(rate_hz, 1.0) / 4)))))
