"""The streams of a session's documents: their keys, and the datasets that they refer to.

Source: https://blueskyproject.io/event-model.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from labrig.config.about import About
from labrig.session.format import layout
from protocols import Channel

Document = tuple[str, dict[str, Any]]

READINGS = "readings"
_MIMETYPE = "application/x-hdf5"
_FRAME_TIMES_IN_CHUNK = 64
_OWN_KEYS = {
    "voltage_V": ("number", "V"),
    "position_m": ("number", "m"),  # null: free
    "run": ("integer", ""),
    "reading": ("integer", ""),
    "kind": ("string", ""),
    "valid": ("boolean", ""),
}
_TYPES = {"number": "<f8", "integer": "<i8", "string": "<U16", "boolean": "|b1"}


def metadata(
    about: About, *, protocol: str, versions: Mapping[str, str], simulated: bool
) -> dict[str, Any]:
    """Return what the run start says beside its identifier and time."""
    stated = {
        "title": about.title,
        "project": about.project,
        "license": about.licence,
        "operators": [person.name for person in about.people],
        "sample": about.sample.identity if about.sample is not None else "",
    }
    return {
        "plan_name": protocol,
        "scan_id": 1,
        "program": "labrig",
        "versions": {name: text for name, text in versions.items() if name.isidentifier()},
        "simulated": simulated,
    } | {key: value for key, value in stated.items() if value}


def reading_keys(channels: Sequence[Channel]) -> dict[str, Any]:
    """Return the data keys of the readings: each channel's value, and what the reading is of."""
    values = {channel.column: ("number", channel.unit) for channel in channels}
    return {
        name: _key(kind, units, f"labrig:{name}")
        for name, (kind, units) in (values | _OWN_KEYS).items()
    }


def signal_documents(
    run: Any, session: Path, *, index: int, channels: Sequence[Channel], rate_hz: float, rows: int
) -> Iterator[Document]:
    """Yield the stream of a run's raw samples, which stay in the session file."""
    paths = {channel.name: layout.signal_path(index, channel.name) for channel in channels}
    paths |= {"sample_time": layout.signal_path(index, "time")}  # "time" is the model's own
    units = {channel.name: channel.raw_unit for channel in channels}
    keys = {name: _external_key(units.get(name, "s"), path) for name, path in paths.items()}
    chunk = (layout.signal_chunk(rate_hz),)
    name = f"run_{index:03d}_signals"
    yield from _external(run, session, name, keys=keys, paths=paths, chunk=chunk, rows=rows)


def frame_documents(
    run: Any, session: Path, *, index: int, shape: tuple[int, int], dtype: str, rows: int
) -> Iterator[Document]:
    """Yield the streams of a run's images and their times, which stay in the session file."""
    images, times = layout.frame_path(index, "images"), layout.frame_path(index, "time")
    of_image = _external_key("", images) | {"dtype_numpy": dtype, "shape": [1, *shape]}
    for name, path, key, chunk in (
        ("images", images, of_image, (1, *shape)),
        ("image_time", times, _external_key("s", times), (_FRAME_TIMES_IN_CHUNK,)),
    ):
        stream = f"run_{index:03d}_{name}"
        keys, paths = {name: key}, {name: path}
        yield from _external(run, session, stream, keys=keys, paths=paths, chunk=chunk, rows=rows)


def _key(kind: str, units: str, source: str) -> dict[str, Any]:
    key = {"dtype": kind, "shape": [], "source": source, "dtype_numpy": _TYPES[kind]}
    return key | ({"units": units} if units else {})


def _external_key(units: str, path: str) -> dict[str, Any]:
    return _key("number", units, path) | {"dtype": "array", "shape": [1], "external": "STREAM:"}


def _external(
    run: Any,
    session: Path,
    name: str,
    *,
    keys: dict[str, Any],
    paths: dict[str, str],
    chunk: tuple[int, ...],
    rows: int,
) -> Iterator[Document]:
    """Yield a stream whose arrays are datasets of the session file."""
    if rows == 0:
        return
    stream = run.compose_descriptor(name=name, data_keys=keys)
    yield "descriptor", stream.descriptor_doc
    for key, path in paths.items():
        resource = run.compose_stream_resource(
            mimetype=_MIMETYPE,
            uri=session.resolve().as_uri().replace("file:///", "file://localhost/"),
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
