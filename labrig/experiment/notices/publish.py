"""Publish a session while it runs, as documents of the Bluesky event model.

A best-effort subscriber: it can neither hold nor break a run. Its first failure is in the log.
"""

from __future__ import annotations

import datetime as dt
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from labrig.config.about import About
from labrig.config.publish import PublishConfig
from labrig.errors import BadInputError
from labrig.session.bluesky.documents import EXIT_STATUS, timestamp
from labrig.session.bluesky.streams import (
    READINGS,
    Document,
    metadata,
    reading_keys,
    signal_documents,
)
from protocols import Channel
from protocols.execution import events as ev


@dataclass(frozen=True, kw_only=True)
class PublishedSession:
    """What is known of a session before it begins."""

    identifier: str
    path: Path
    protocol: str
    about: About
    versions: dict[str, str]
    simulated: bool
    channels: Sequence[Channel]
    rate_hz: float


def check_publish(publish: PublishConfig | None) -> None:
    """Raise BadInputError where documents could not be made or not be written."""
    if publish is None:
        return
    try:
        import event_model  # noqa: F401
    except ModuleNotFoundError as error:
        raise BadInputError(
            f"rig.toml: publish.bluesky needs the package {error.name}; install it with: "
            'pip install "labrig[bluesky]".'
        ) from None
    try:
        publish.bluesky.open("a", encoding="utf-8").close()
    except OSError as error:
        raise BadInputError(
            f"rig.toml: publish.bluesky: {publish.bluesky} cannot be written ({error.strerror})."
        ) from None


def document_file(path: Path) -> Callable[[Document], None]:
    """Return what appends documents to a file."""

    def append(document: Document) -> None:
        with path.open("a", encoding="utf-8", newline="\n") as file:
            file.write(json.dumps(document) + "\n")

    return append


class BlueskyPublisher:
    """Turns a session's events into documents, and hands each on as it is made."""

    def __init__(self, session: PublishedSession, publish: Callable[[Document], None]) -> None:
        from event_model import compose_run

        self._compose_run = compose_run
        self._session = session
        self._publish = publish
        self._run: Any = None
        self._readings: Any = None
        self._to_wall_s = 0.0  # from the rig's clock to seconds since 1970
        self._positions_m: dict[int, float | None] = {}
        self._samples: dict[int, int] = {}

    def __call__(self, event: ev.Event) -> None:
        """Publish what an event has to say."""
        match event:
            case ev.SessionStarted():
                self._start(event)
            case ev.RunStarted():
                self._positions_m[event.run.index] = event.run.position_m
            case ev.SignalsArrived():
                end = event.block.first_index + event.block.volts.shape[1]
                self._samples[event.run] = end
            case ev.ReadingTaken():
                self._reading(event)
            case ev.SessionStopped():
                self._stop(event)

    def _start(self, event: ev.SessionStarted) -> None:
        session = self._session
        start_s = timestamp(event.wall) if event.wall else dt.datetime.now(dt.UTC).timestamp()
        self._to_wall_s = start_s - event.time_s
        stated = metadata(
            session.about,
            protocol=session.protocol,
            versions=session.versions,
            simulated=session.simulated,
        )
        self._run = self._compose_run(uid=session.identifier, time=start_s, metadata=stated)
        self._publish(("start", self._run.start_doc))
        keys = reading_keys(session.channels)
        self._readings = self._run.compose_descriptor(name=READINGS, data_keys=keys, time=start_s)
        self._publish(("descriptor", self._readings.descriptor_doc))

    def _reading(self, event: ev.ReadingTaken) -> None:
        values = {
            channel.column: event.values.get(channel.column, math.nan)
            for channel in self._session.channels
        }
        data = values | {
            "voltage_V": event.planned.voltage_V,
            "position_m": self._positions_m.get(event.run),
            "run": event.run,
            "reading": event.planned.index,
            "kind": event.planned.kind.value,
            "valid": event.valid,
        }
        time_s = event.sample_time_s + self._to_wall_s
        times = dict.fromkeys(data, time_s)
        made = self._readings.compose_event(data=data, timestamps=times, time=time_s)
        self._publish(("event", made))

    def _stop(self, event: ev.SessionStopped) -> None:
        """Refer to the raw samples, which are in the session file by now, and end."""
        for index, rows in self._samples.items():
            for document in signal_documents(
                self._run,
                self._session.path,
                index=index,
                channels=self._session.channels,
                rate_hz=self._session.rate_hz,
                rows=rows,
            ):
                self._publish(document)
        status = EXIT_STATUS.get(event.outcome, "fail")
        time_s = event.time_s + self._to_wall_s
        if math.isnan(time_s):
            time_s = dt.datetime.now(dt.UTC).timestamp()
        stop = self._run.compose_stop(exit_status=status, reason=event.reason, time=time_s)
        self._publish(("stop", stop))
