"""Call a program or web address when a session waits, has stopped, or is done.

A hook runs in a thread of its own, beside the session: it can delay nothing and break nothing.
"""

from __future__ import annotations

import datetime as dt
import json
import os
import re
import subprocess
import threading
import urllib.request
from collections.abc import Callable
from enum import StrEnum

from drivers.interfaces import Operator, Prompt
from labrig.config.hooks import HooksConfig

Log = Callable[[str], None]
_END_S = 2.0  # to end a command whose time is over: else it would outlive the program


class Notice(StrEnum):
    """What a hook is told."""

    WAITING = "waiting"  # for the operator
    STOPPED = "stopped"  # anything but completed
    DONE = "done"  # completed


class Hooks:
    """The hooks of one session. Nothing in here raises; failures go to `log`, from any thread."""

    def __init__(self, config: HooksConfig | None, session: str, log: Log) -> None:
        self._config = config
        self._session = session
        self._log = log
        self._threads: list[threading.Thread] = []
        self._timer: threading.Timer | None = None
        self._ended = False

    def waiting(self, text: str) -> None:
        """Note that the operator is asked; they are told when the question stands for long."""
        if self._config is not None:
            after_s = self._config.waiting_after_s
            self._timer = threading.Timer(after_s, self.tell, (Notice.WAITING, text))
            self._timer.daemon = True
            self._timer.start()

    def answered(self) -> None:
        """Note that the operator has answered."""
        if self._timer is not None:
            self._timer.cancel()

    def ended(self, *, completed: bool, text: str) -> None:
        """Tell how the session ended, the first time that this is called."""
        if not self._ended:
            self._ended = True
            self.tell(Notice.DONE if completed else Notice.STOPPED, text)

    def tell(self, notice: Notice, text: str) -> None:
        """Run the hooks; returns at once."""
        config = self._config
        if config is None:
            return
        message = {
            "event": notice.value,
            "session": self._session,
            "text": text,
            "wall": dt.datetime.now(dt.UTC).isoformat(timespec="seconds"),
        }
        if config.command:
            self._start("command", lambda: _run(config, message))
        if config.webhook is not None:
            self._start("webhook", lambda: _post(config, message))

    def close(self) -> None:
        """Wait until the hooks are over, at most their time."""
        self.answered()
        for thread in self._threads:
            thread.join(0.0 if self._config is None else self._config.timeout_s + _END_S)

    def _start(self, name: str, work: Callable[[], None]) -> None:
        def guarded() -> None:
            try:
                work()
            except Exception as error:  # noqa: BLE001 - whatever it is, the session goes on
                self._log(f"[hooks] {name} failed: {_why(error)}")

        thread = threading.Thread(target=guarded, name=f"hook-{name}", daemon=True)
        self._threads.append(thread)
        thread.start()


def _run(config: HooksConfig, message: dict[str, str]) -> None:
    named = {f"LABRIG_{key.upper()}": value for key, value in message.items()}
    done = subprocess.run(
        [_filled(part, message) for part in config.command],
        input=json.dumps(message).encode(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, **named},
        timeout=config.timeout_s,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"{config.command[0]} ended with code {done.returncode}")


def _filled(part: str, message: dict[str, str]) -> str:
    """Fill in {event}, {session}, {text}, {wall}."""
    return re.sub(r"\{(\w+)\}", lambda found: message.get(found[1], found[0]), part)


def _post(config: HooksConfig, message: dict[str, str]) -> None:
    if config.address is None:
        raise RuntimeError(f"the variable of {config.webhook} is not set")
    request = urllib.request.Request(  # noqa: S310 - the configuration allows http and https only
        config.address,
        data=json.dumps(message).encode(),
        headers={"Content-Type": "application/json"},
        method="POST",
    )
    with urllib.request.urlopen(request, timeout=config.timeout_s):  # noqa: S310 - as above
        pass


def _why(error: Exception) -> str:
    if isinstance(error, subprocess.TimeoutExpired):
        return f"{error.cmd[0]} was ended after {error.timeout:.3g} s"
    return f"{error}" if isinstance(error, RuntimeError) else f"{type(error).__name__}: {error}"


class NotifyingOperator:
    """An operator who is told of questions that stand for long."""

    def __init__(self, operator: Operator, hooks: Hooks) -> None:
        self._operator = operator
        self._hooks = hooks

    @property
    def expired(self) -> bool:
        """Whether nobody has answered the last question in its time."""
        return getattr(self._operator, "expired", False)

    def ask(self, prompt: Prompt) -> bool:
        """See `drivers.interfaces.Operator`."""
        self._hooks.waiting(prompt.text)
        try:
            return self._operator.ask(prompt)
        finally:
            self._hooks.answered()
