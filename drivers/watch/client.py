"""The program's side of the watch: a heartbeat over the network, and the answers to it."""

from __future__ import annotations

import json
import secrets
import socket
import threading
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from drivers.guard.settings import AT_ZERO, BEAT, DISARM, ENERGISED, HEARTBEAT_S, NEW_RUN
from drivers.guard.suspect import IN_THE_PROGRAM
from drivers.interfaces import DeviceError, DeviceNotFoundError, RealClock
from drivers.watch.wire import (
    REPORT,
    VERSION,
    Frames,
    NotProvenError,
    is_proof,
    proof,
    read_line,
    send_line,
    session_key,
)

CONNECT_S = 3.0
_SEND_S = 0.2  # a send that blocks for so long has nobody at the other end
_UNHEARD_S = 1.0  # a watch that has not confirmed for so long does not watch
_SIGN_EVERY_S = 0.3  # that the connection is there, while the loop need not beat
_BEAT_EVERY_S = HEARTBEAT_S
_END_S = 2.0


class WatchLink:
    """A connection to the watch at the boards. Made before the first voltage."""

    def __init__(self, host: str, port: int, token: bytes, place: Mapping[str, Any]) -> None:
        """Connect, prove the token, and say which output is driven. Raises DeviceError."""
        self._where = f"the watch at {host}:{port}"
        self._clock = RealClock()
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self._energised = False
        self._lost = ""  # why it does not watch any more
        self._last_beat_s = self._confirmed_s = self._clock.now()
        try:
            self._line = socket.create_connection((host, port), CONNECT_S)
        except OSError as fault:
            raise DeviceNotFoundError(
                f"no connection to {self._where} ({fault}); start `labrig watch` at the boards, "
                "and check [watch] address and the firewall"
            ) from fault
        try:
            self._greet(token, place)
        except (OSError, ValueError) as fault:
            self._line.close()
            raise NotProvenError(
                f"{self._where} does not answer as a watch does ({fault}); check [watch] address"
            ) from fault
        except BaseException:
            self._line.close()
            raise
        for target, name in ((self._listen, "watch"), (self._give_signs, "watch signs")):
            threading.Thread(target=target, name=name, daemon=True).start()

    def new_run(self) -> None:
        """Begin a run, at 0 V: its time under voltage is counted from 0."""
        self._check()
        self._send(NEW_RUN)

    def beat(self) -> None:
        """Report that the working loop runs; called at least every 50 ms while energised."""
        now_s = self._clock.now()
        if not self._energised or now_s - self._last_beat_s < _BEAT_EVERY_S:
            return
        self._check()
        self._last_beat_s = now_s
        self._send(BEAT)

    def energised(self, on: bool) -> None:
        """Before the first voltage (True), and after 0 V was written (False).

        Raises DeviceError when nobody watches and `on`: then nothing may be energised.
        """
        if on:
            self._check()
            self._last_beat_s = self._clock.now()
        self._energised = on
        try:
            self._send(ENERGISED if on else AT_ZERO)
        except DeviceError:
            if on:
                raise

    def close(self) -> None:
        """Let the watch go; while 0 V is not confirmed, it is left to act. May be called twice."""
        if not self._energised and not self._lost:
            with suppress(DeviceError):
                self._send(DISARM)
        self._ended.set()
        with suppress(OSError):
            self._line.shutdown(socket.SHUT_RDWR)
        self._line.close()

    def _greet(self, token: bytes, place: Mapping[str, Any]) -> None:
        self._line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        hello = read_line(self._line)
        if hello.get("labrig_watch") != VERSION:
            raise ValueError("another program listens there, or another version")
        theirs, ours = str(hello.get("nonce", "")), secrets.token_hex(16)
        text = json.dumps(dict(place), sort_keys=True)
        ticket = proof(token, "program", theirs, ours, text)
        send_line(self._line, {"nonce": ours, "place": dict(place), "proof": ticket})
        answer = read_line(self._line)
        if not answer.get("ok"):
            raise NotProvenError(
                f"{self._where} refuses this run: {answer.get('why', 'no reason')}"
            )
        if not is_proof(answer.get("proof"), proof(token, "watch", ours, theirs)):
            raise NotProvenError(f"{self._where} does not have the token; check [watch] token")
        key = session_key(token, theirs, ours)
        self._said = Frames(self._line, key, "to watch")
        self._heard = Frames(self._line, key, "to program")

    def _check(self) -> None:
        unheard_s = self._clock.now() - self._confirmed_s
        if not self._lost and unheard_s < _UNHEARD_S:
            return
        why = self._lost or f"has not answered for {unheard_s:.1f} s"
        raise DeviceError(
            f"{self._where} {why}: the run must stop, since nobody at the boards would write 0 V "
            "if this computer failed; check the network and `labrig watch`"
        )

    def _send(self, kind: bytes) -> None:
        try:
            with self._lock:
                self._line.settimeout(_SEND_S)
                self._said.send(kind)
        except OSError as fault:
            self._lost = self._lost or f"is gone ({fault})"
            raise DeviceError(f"{self._where} is gone ({fault}); the run must stop") from fault

    def _give_signs(self) -> None:
        """Its thread: that the connection is there. It is no heartbeat of the working loop."""
        while not self._ended.wait(_SIGN_EVERY_S):
            with suppress(DeviceError):
                self._send(IN_THE_PROGRAM)

    def _listen(self) -> None:
        """Its thread: what the watch says."""
        while not self._ended.is_set():
            try:
                frame = self._heard.read()
            except TimeoutError:
                continue
            except OSError:
                frame = None
            if frame is None:
                self._lost = self._lost or "has ended the connection"
                return
            self._confirmed_s = self._clock.now()
            if frame[0] == REPORT:
                self._lost = f"has ended this run ({json.loads(frame[1])['why']})"
