"""A session as documents of the Bluesky event model; arrays stay in the session file.

One run start and stop for the session. The stream `readings` has an event for each reading of all
runs. `run_000_signals` and `run_000_frames` refer to the raw samples and images in the file.
Source: https://blueskyproject.io/event-model.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Iterator
from typing import Any

from labrig.session.format import layout
from labrig.session.reading.run_record import RunRecord
from labrig.session.reading.session import RecordedSession
from protocols.execution.events import Outcome

Document = tuple[str, dict[str, Any]]

_MIMETYPE = "application/x-hdf5"
_EXIT = {Outcome.COMPLETED: "success", Outcome.ABORTED: "abort"}
_OWN_KEYS = {
    "voltage_V": ("number", "V"),
    "position_m": ("number", "m"),
    "run": ("integer", ""),
    "reading": ("integer", ""),
    "kind": ("string", ""),
    "valid": ("boolean", ""),
}
_TYPES = {"number": "<f8", "integer": "<i8", "string": "<U16", "boolean": "|b1"}


def documents(session: RecordedSession) -> Iterator[Document]:
    """Yield name and content of each document of an open session, in the order of the model.

    Raises ModuleNotFoundError where event-model is missing.
    """
    from event_model import compose_run

    start_s = _timestamp(session.started)
    run = compose_run(uid=session.identifier, time=start_s, metadata=_metadata(session))
    yield "start", run.start_doc
    yield from _readings(session, run, start_s)
    for recorded in session.runs:
        if recorded.started:
            yield from _signals(session, recorded, run, start_s)
            yield from _frames(session, recorded, run, start_s)
    status = _EXIT.get(session.outcome, "fail")
    end_s = _timestamp(session.ended) if session.ended else start_s
    yield "stop", run.compose_stop(exit_status=status, reason=session.reason, time=end_s)


def _timestamp(wall: str) -> float:
    return dt.datetime.fromisoformat(wall).timestamp()


def _metadata(session: RecordedSession) -> dict[str, Any]:
    about = session.about
    stated = {
        "title": about.title,
        "project": about.project,
        "license": about.licence,
        "operators": [person.name for person in about.people],
        "sample": about.sample.identity if about.sample is not None else "",
    }
    return {
        "plan_name": session.schedule.protocol,
        "scan_id": 1,
        "program": "labrig",
        "versions": {k: v for k, v in session.versions.items() if k.isidentifier()},
        "simulated": session.simulated,
        "streams": "readings; signals and frames of each run, in the session file",
    } | {key: value for key, value in stated.items() if value}


def _key(kind: str, units: str, source: str, **more: Any) -> dict[str, Any]:
    key = {"dtype": kind, "shape": [], "source": source, "dtype_numpy": _TYPES[kind]}
    return key | ({"units": units} if units else {}) | more


def _readings(session: RecordedSession, run: Any, start_s: float) -> Iterator[Document]:
    runs = [record for record in session.runs if record.started]
    if not runs:
        return
    channels = {channel.column: ("number", channel.unit) for channel in runs[0].signals}
    keys = {
        name: _key(kind, units, f"labrig:{name}")
        for name, (kind, units) in (channels | _OWN_KEYS).items()
    }
    stream = run.compose_descriptor(
        name="readings", data_keys=keys, time=start_s, hints={"fields": [next(iter(channels))]}
    )
    yield "descriptor", stream.descriptor_doc
    for record in runs:
        at_s = start_s + record.time_zero_s - session.began_s
        for row in record.readings:
            data = _reading(record, row, list(channels))
            time_s = at_s + float(row["time_s"])
            yield (
                "event",
                stream.compose_event(
                    data=data, timestamps=dict.fromkeys(data, time_s), time=time_s
                ),
            )


def _reading(record: RunRecord, row: Any, columns: list[str]) -> dict[str, Any]:
    position_m = record.planned.position_m
    return {column: float(row[column]) for column in columns} | {
        "voltage_V": float(row["voltage_V"]),
        "position_m": position_m,  # null: free
        "run": record.planned.index,
        "reading": int(row["index"]),
        "kind": str(row["kind"]),
        "valid": bool(row["valid"]),
    }


def _signals(
    session: RecordedSession, record: RunRecord, run: Any, start_s: float
) -> Iterator[Document]:
    index = record.planned.index
    paths = {channel.name: layout.signal_path(index, channel.name) for channel in record.signals}
    paths |= {"sample_time": layout.signal_path(index, "time")}  # "time" is the model's own
    units = {channel.name: channel.raw_unit for channel in record.signals}
    keys = {
        name: _key("number", units.get(name, "s"), path)
        | {"dtype": "array", "shape": [1], "external": "STREAM:"}
        for name, path in paths.items()
    }
    chunk = (layout.signal_chunk(record.sample_clock.rate_hz),)
    name = f"run_{index:03d}_signals"
    descriptor = {"name": name, "data_keys": keys, "time": start_s}
    yield from _external(session, run, descriptor, paths=paths, chunk=chunk, rows=record.samples)


def _frames(
    session: RecordedSession, record: RunRecord, run: Any, start_s: float
) -> Iterator[Document]:
    index = record.planned.index
    if session.frame_shape is None or not record.frame_count:
        return
    image = _key("number", "", layout.frame_path(index, "images")) | {
        "dtype": "array",
        "dtype_numpy": record.image(0).dtype.str,
        "shape": [1, *session.frame_shape],
        "external": "STREAM:",
    }
    times = _key("number", "s", layout.frame_path(index, "time")) | {
        "dtype": "array",
        "shape": [1],
        "external": "STREAM:",
    }
    for name, part, key, chunk in (
        ("images", "images", image, (1, *session.frame_shape)),
        ("image_time", "time", times, (64,)),
    ):
        paths = {name: layout.frame_path(index, part)}
        stream = f"run_{index:03d}_{name}"
        descriptor = {"name": stream, "data_keys": {name: key}, "time": start_s}
        rows = record.frame_count
        yield from _external(session, run, descriptor, paths=paths, chunk=chunk, rows=rows)


def _external(
    session: RecordedSession,
    run: Any,
    descriptor: dict[str, Any],
    *,
    paths: dict[str, str],
    chunk: tuple[int, ...],
    rows: int,
) -> Iterator[Document]:
    """Yield a stream whose arrays are datasets of the session file."""
    if rows == 0:
        return
    stream = run.compose_descriptor(**descriptor)
    yield "descriptor", stream.descriptor_doc
    for key, path in paths.items():
        resource = run.compose_stream_resource(
            mimetype=_MIMETYPE,
            uri=session.path.resolve().as_uri().replace("file:///", "file://localhost/"),
            data_key=key,
            parameters={"dataset": path, "chunk_shape": list(chunk)},
        )
        yield "stream_resource", resource.stream_resource_doc
        yield (
            "stream_datum",
            resource.compose_stream_datum(
                seq_nums={"start": 1, "stop": rows + 1},
                indices={"start": 0, "stop": rows},
                descriptor=stream.descriptor_doc,
            ),
        )
