"""The watch's side: hear one program at a time, and make the output safe when it falls silent."""

from __future__ import annotations

import json
import queue
import secrets
import socket
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from typing import Any

from drivers.boards import OutputRescue
from drivers.guard.settings import GuardSettings
from drivers.guard.watch import Ending, ParentWatchdog
from drivers.interfaces import Clock, DeviceError
from drivers.real_time import WATCH, punctual
from drivers.safe_shutdown import SafetyReport, attempt, report_of
from drivers.watch.wire import (
    ALIVE,
    REPORT,
    VERSION,
    Frames,
    is_proof,
    proof,
    read_line,
    send_line,
    session_key,
)

# Longer than the guard's limit: where both live, the guard acts first.
HEARTBEAT_LIMIT_S = 0.6
GONE_S = 0.2  # after the connection has ended, for the guard to act first
SILENT_S = 2.0  # a connection at 0 V without a word is over
_GRACE_S = 0.2  # to hear what has come while this computer stood still
_GREETING_S = 2.0  # to prove the token
_MOST_GREETINGS = 16  # connections that have proven nothing, at a time
_BETWEEN_TRIES_S = 0.2
_PATIENCE_S = 2.0


@dataclass(frozen=True)
class _Program:
    """A program that has proven the token."""

    line: socket.socket
    name: str
    heard: Frames
    said: Frames


class BoardsWatch:
    """Listens on a port and watches over one program at a time, for as long as it lives."""

    def __init__(
        self,
        settings: GuardSettings,
        rescue: OutputRescue,
        token: bytes,
        clock: Clock,
        tell: Callable[[str], None],
    ) -> None:
        self._settings = replace(settings, heartbeat_limit_s=HEARTBEAT_LIMIT_S)
        self._rescue = rescue
        self._token = token
        self._clock = clock
        self._say = tell
        self._listener: socket.socket | None = None
        self._busy = threading.Lock()  # held while a program is watched
        self._greetings = threading.Semaphore(_MOST_GREETINGS)
        self._ended = threading.Event()

    def listen(self, host: str, port: int) -> int:
        """Connect to the boards, then listen; return the port. Raises DeviceError."""
        self._rescue.open()
        try:
            self._listener = socket.create_server((host, port))
        except OSError as fault:
            raise DeviceError(f"port {port} cannot be listened on: {fault}") from fault
        threading.Thread(target=self._accept, name="watch", daemon=True).start()
        return int(self._listener.getsockname()[1])

    def stop(self) -> None:
        """Listen no more and let go of the boards. May be called twice."""
        self._ended.set()
        if self._listener is not None:
            with suppress(OSError):
                self._listener.shutdown(socket.SHUT_RDWR)
            self._listener.close()
        attempt([], self._rescue.close)

    @property
    def is_watching(self) -> bool:
        """Whether a program is connected."""
        return self._busy.locked()

    def _tell(self, text: str) -> None:
        """Say it; whoever listened may be gone, or the disk of the log full, and it watches on."""
        attempt([], lambda: self._say(text))

    def _accept(self) -> None:
        listener = self._listener
        while listener is not None and not self._ended.is_set():
            try:
                line, address = listener.accept()
            except OSError:
                return
            if not self._greetings.acquire(blocking=False):
                line.close()  # a flood keeps out who comes now, not who is watched
                continue
            threading.Thread(
                target=self._serve, args=(line, str(address[0])), name="watched", daemon=True
            ).start()

    def _serve(self, line: socket.socket, name: str) -> None:
        with line:
            program: _Program | None = None
            try:
                line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                line.settimeout(_GREETING_S)
                program = self._greeted(line, name)
            except (OSError, ValueError):
                return
            finally:
                self._greetings.release()
            if program is not None:
                try:
                    with punctual(WATCH):
                        self._watch(program)
                finally:
                    self._busy.release()

    def _greeted(self, line: socket.socket, name: str) -> _Program | None:
        """Greet; a program that is accepted holds `_busy`."""
        ours = secrets.token_hex(16)
        send_line(line, {"labrig_watch": VERSION, "nonce": ours})
        said = read_line(line, _GREETING_S)
        theirs, place = str(said.get("nonce", "")), said.get("place")
        text = json.dumps(place, sort_keys=True)
        if not is_proof(said.get("proof"), proof(self._token, "program", ours, theirs, text)):
            send_line(line, {"ok": False, "why": "the token is another one"})
            self._tell(f"{name} was refused: it does not have the token.")
            return None
        why = self._why_not(place)
        mine = proof(self._token, "watch", theirs, ours)
        if not why and not self._busy.acquire(blocking=False):
            why = "it watches over another program"
        if why:
            send_line(line, {"ok": False, "why": why, "proof": mine})
            self._tell(f"{name} was refused: {why}.")
            return None
        try:
            send_line(line, {"ok": True, "proof": mine})
        except OSError:
            self._busy.release()
            raise
        key = session_key(self._token, ours, theirs)
        heard, answers = Frames(line, key, "to watch"), Frames(line, key, "to program")
        return _Program(line, name, heard, answers)

    def _why_not(self, place: object) -> str:
        """Return why it cannot watch over an output; its boards have another address here."""
        if not isinstance(place, Mapping):
            return "it did not say which output it drives"
        ours, theirs = _without_address(self._settings.place), _without_address(place)
        differing = sorted(k for k in {*ours, *theirs} if ours.get(k) != theirs.get(k))
        if not differing:
            return ""
        first = differing[0]
        return (
            f"its rig.toml has {first} = {theirs.get(first)!r}, the watch's has {ours.get(first)!r}"
        )

    def _watch(self, program: _Program) -> None:
        """Follow one program until it has finished, or until the output is safe without it."""
        self._tell(f"watching over the program at {program.name}.")
        program.line.settimeout(SILENT_S)
        messages: queue.Queue[bytes] = queue.Queue()
        threading.Thread(
            target=_hear, args=(program, messages), name="watch heard", daemon=True
        ).start()

        def confirm() -> None:
            with suppress(OSError):
                program.said.send(ALIVE)

        watchdog = ParentWatchdog(
            self._settings, self._clock, messages, confirm, lambda: True, grace_s=_GRACE_S
        )
        ending = watchdog.until_end()
        if ending is Ending.DISARMED:
            self._tell(f"the program at {program.name} has finished.")
            return
        if ending is Ending.GONE:
            self._clock.sleep_until(self._clock.now() + GONE_S)
        why = _WHY.get(ending, ending.value)
        report = self._until_safe(why)
        with suppress(OSError):
            facts = json.dumps({"why": why, **asdict(report)}, default=float)
            program.said.send(REPORT, facts)

    def _until_safe(self, why: str) -> SafetyReport:
        """Make the output safe; nobody else may be left who could, so do not give up."""
        report = self._once()
        self._tell(f"{why}; {report.text}.")
        while not report.is_safe and not self._ended.is_set():
            attempt([], self._rescue.close)
            self._ended.wait(_BETWEEN_TRIES_S)
            attempt([], self._rescue.open)
            report = self._once()
            if report.is_safe:
                self._tell(f"{report.text}.")
        return report

    def _once(self) -> SafetyReport:
        return report_of(lambda: self._rescue.make_safe(_PATIENCE_S, _nothing))


_WHY = {
    Ending.GONE: "the connection to the program has ended",
    Ending.HUNG: "the program is silent: it hangs, its computer is down, or the network is cut",
}


def _nothing() -> None:
    """Nobody at this computer can be ended: the program runs at another one."""


def _without_address(place: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in place.items() if key != "address"}


def _hear(program: _Program, messages: queue.Queue[bytes]) -> None:
    """Put what comes into the queue; an empty message is the end."""
    read: Callable[[], tuple[bytes, str] | None] = program.heard.read
    with punctual(WATCH):
        while True:
            try:
                frame = read()
            except OSError:  # silent for too long, too
                frame = None
            messages.put(b"" if frame is None else frame[0])
            if frame is None:
                return
