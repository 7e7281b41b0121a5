"""A closed session as documents of the Bluesky event model; arrays stay in the session file.

One run start and stop for the session. The stream `readings` has an event for each reading of all
runs. `run_000_signals` and `run_000_images` refer to the raw samples and images in the file.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Iterator
from typing import Any

from labrig.session.bluesky.streams import (
    READINGS,
    Document,
    frame_documents,
    metadata,
    reading_keys,
    signal_documents,
)
from labrig.session.reading.run_record import RunRecord
from labrig.session.reading.session import RecordedSession
from protocols.execution.events import Outcome

EXIT_STATUS = {Outcome.COMPLETED: "success", Outcome.ABORTED: "abort"}  # else: fail


def documents(session: RecordedSession) -> Iterator[Document]:
    """Yield name and content of each document of an open session, in the order of the model.

    Raises ModuleNotFoundError where event-model is missing.
    """
    from event_model import compose_run

    # All times by the session's own clock: that of the day may have been set meanwhile.
    start_s = timestamp(session.started) - (session.started_s - session.began_s)
    stated = metadata(
        session.about,
        protocol=session.schedule.protocol,
        versions=session.versions,
        simulated=session.simulated,
    )
    run = compose_run(uid=session.identifier, time=start_s, metadata=stated)
    yield "start", run.start_doc
    runs = [record for record in session.runs if record.started]
    yield from _readings(session, runs, run, start_s)
    for record in runs:
        yield from _arrays(session, record, run)
    status = EXIT_STATUS.get(session.outcome, "fail")
    end_s = start_s + (session.duration_s or 0.0)
    yield "stop", run.compose_stop(exit_status=status, reason=session.reason, time=end_s)


def timestamp(wall: str) -> float:
    """Return seconds since 1970 of a time in ISO 8601."""
    return dt.datetime.fromisoformat(wall).timestamp()


def _readings(
    session: RecordedSession, runs: list[RunRecord], run: Any, start_s: float
) -> Iterator[Document]:
    if not runs:
        return
    channels = runs[0].signals
    stream = run.compose_descriptor(name=READINGS, data_keys=reading_keys(channels), time=start_s)
    yield "descriptor", stream.descriptor_doc
    for record in runs:
        at_s = start_s + record.time_zero_s - session.began_s
        for row in record.readings:
            data = _reading(record, row)
            time_s = at_s + float(row["time_s"])
            times = dict.fromkeys(data, time_s)
            yield "event", stream.compose_event(data=data, timestamps=times, time=time_s)


def _reading(record: RunRecord, row: Any) -> dict[str, Any]:
    return {channel.column: float(row[channel.column]) for channel in record.signals} | {
        "voltage_V": float(row["voltage_V"]),
        "position_m": record.planned.position_m,
        "run": record.planned.index,
        "reading": int(row["index"]),
        "kind": str(row["kind"]),
        "valid": bool(row["valid"]),
    }


def _arrays(session: RecordedSession, record: RunRecord, run: Any) -> Iterator[Document]:
    index = record.planned.index
    yield from signal_documents(
        run,
        session.path,
        index=index,
        channels=record.signals,
        rate_hz=record.sample_clock.rate_hz,
        rows=record.samples,
    )
    if session.frame_shape is not None and record.frame_count:
        yield from frame_documents(
            run,
            session.path,
            index=index,
            shape=session.frame_shape,
            dtype=record.image(0).dtype.str,
            rows=record.frame_count,
        )
