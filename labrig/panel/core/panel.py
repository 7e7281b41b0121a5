"""One panel: everything behind its pages, put together."""

from __future__ import annotations

import secrets
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol, TypeVar, runtime_checkable

from fastapi import Request

from labrig.config import ReplayConfig, load_rig
from labrig.errors import BadInputError
from labrig.library import Library
from labrig.panel.access.settings import PanelSettings, host_name
from labrig.panel.analysis.jobs import AnalysisJobs
from labrig.panel.analysis.live_fit import LiveFit
from labrig.panel.core.actions import Actions
from labrig.panel.core.control import Control, utc_now
from labrig.panel.errors import NotNowError
from labrig.panel.job import Kind, Order
from labrig.panel.job.jobs import Jobs
from labrig.panel.job.registry import hidden_folder
from labrig.panel.live.event_stream import EventStream, Message
from labrig.panel.live.frame_pipeline import FramePipeline
from labrig.panel.live_model.live_model import LiveModel
from labrig.panel.queue.run_queue import RunQueue

State = TypeVar("State")
VERSION = 1  # of what page and server say to each other


@runtime_checkable
class Closing(Protocol):
    """What a page keeps and wants to be told of when the panel ends."""

    def close(self) -> None:
        """Let go; may be called while requests are under way, and must not block."""


class Panel:
    """Made when the server starts, closed when it ends."""

    def __init__(self, settings: PanelSettings) -> None:
        self.settings = settings
        self.simulated = _is_simulated(settings.rig)  # first: here it may fail, and has no threads
        self.stream = EventStream()
        self.actions = Actions(settings.data)
        self.control = Control(self.stream.publish_newest)
        self.frame_pipeline = FramePipeline(self.stream)
        self.live_model = LiveModel(self.stream)
        self.jobs = Jobs(
            settings.data,
            self.stream,
            self.frame_pipeline,
            settings.rig,
            on_setup=self.live_model.set_setup,
        )
        self.analysis_jobs = AnalysisJobs(
            hidden_folder(settings.data),
            self.stream.publish_newest,
            lambda: self.jobs.going,
            self.tell_left_out,
        )
        self.live_fit = LiveFit(settings.data, hidden_folder(settings.data), self.stream)
        self.library = Library(settings.data)
        self._queue = None if settings.rig is None else self._queue_of(settings.rig)
        self._left_out: set[str] = set()
        self._states: dict[type[Any], Any] = {}
        self._lock = threading.Lock()
        self.model: str | None = None
        self.model_path: Path | None = None
        if settings.model is not None:
            self.choose_model(settings.model)

    def close(self) -> None:
        """Let go of everything but the job."""
        if self._queue is not None:
            self._queue.close()
        self.analysis_jobs.close()
        self.live_fit.close()
        for state in list(self._states.values()):
            if isinstance(state, Closing):
                state.close()
        self.jobs.close()
        self.live_model.close()
        self.frame_pipeline.close()
        self.library.close()

    def state(self, kind: type[State]) -> State:
        """Return this panel's object of a class, made when a page first asks; any thread may ask.

        For what a page must keep between requests; one with `close()` is closed with the panel.
        """
        with self._lock:
            if kind not in self._states:
                self._states[kind] = kind()
            found: State = self._states[kind]
            return found

    @property
    def rig(self) -> Path:
        """rig.toml. Raises NotNowError when the panel was started without one."""
        if self.settings.rig is None:
            raise NotNowError("this panel has no rig; start it as labrig panel rig.toml.")
        return self.settings.rig

    @property
    def queue(self) -> RunQueue:
        """The sessions to come. Raises NotNowError when the panel was started without a rig."""
        if self._queue is None:
            raise NotNowError("this panel has no rig; start it as labrig panel rig.toml.")
        return self._queue

    def _queue_of(self, rig: Path) -> RunQueue:
        return RunQueue(
            data=self.settings.data,
            rig=rig,
            jobs=self.jobs,
            order=self.order,
            publish=self.stream.publish_newest,
            log=self.actions.add,
        )

    def status(self, host: str, client: str) -> Message:
        """Return the status; `host`: the name by which this page reached us."""
        settings = self.settings
        session = settings.session
        return {
            "version": VERSION,
            "mode": settings.mode,
            "rig": None if settings.rig is None else settings.rig.name,
            "session": None if session is None else session.relative_to(settings.data).as_posix(),
            "data": str(settings.data),
            "simulated": self.simulated,
            "model": self.model,
            "job": self.jobs.message(),
            "control": self.control.message_for(client),
            "stop_url": self.stop_url(host),
        }

    def stop_url(self, host: str) -> str | None:
        """Where STOP is pressed."""
        if not self.settings.stop_port:
            return None
        return self.settings.url("/stop", port=self.settings.stop_port, name=host_name(host))

    def choose_model(self, path: Path | None) -> None:
        """Whose predicted curve is drawn."""
        self.model = None if path is None else path.name
        self.model_path = path
        self.frame_pipeline.choose_model(path)
        self.live_model.choose_model(path)
        self.stream.publish_newest({"type": "model", "name": self.model})

    def acting(self, request: Request) -> str:
        """Who acts. Raises ForbiddenError when they do not hold control."""
        return self.control.require(request.headers.get("x-labrig-client", ""))

    def log(self, who: str, what: str, *, note: bool = True) -> None:
        """Somebody did something. `note`: the session does not know of it by itself."""
        self.actions.add(who, what)
        if note:
            self.jobs.note(who, what)

    def tell_left_out(self, text: str) -> None:
        """Log a part of another distribution that is left out, once, whichever process found it."""
        with self._lock:
            if text in self._left_out:
                return
            self._left_out.add(text)
        with suppress(BadInputError):  # the log cannot be written: the panel goes on
            self.actions.add("labrig", text)

    def order(self, kind: Kind, who: str, **more: Any) -> Order:
        """Return what a job is to do."""
        return Order(
            id=secrets.token_hex(8),
            kind=kind,
            by=who,
            wall=utc_now(),
            data=str(self.settings.data),
            rig=str(self.rig),
            **more,
        )


def _is_simulated(rig: Path | None) -> bool:
    if rig is None:
        return False
    config = load_rig(rig)
    if isinstance(config, ReplayConfig):
        raise BadInputError(f"{rig}: this rig is a recorded session; open {config.replay} instead.")
    return config.is_simulated
