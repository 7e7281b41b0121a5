"""What the conformance functions of all kinds of device share.

A conformance function puts a device through its contract (see `drivers.interfaces`) and returns
what it found wrong, a sentence each; none for a good one. It never raises. Real, simulated and fake
devices pass the same functions: `camera_faults`, `positioner_faults`, `force_sensor_faults`,
`output_faults`, `timed_output_faults`, `signal_faults`, `interlock_faults` and `rescue_faults`,
each in its folder.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import TypeVar

from drivers.interfaces import (
    Clock,
    DeviceError,
    DeviceIdentity,
    DeviceTimeoutError,
    Identified,
)

T = TypeVar("T")
IDENTITY_S = 1.0
PROMPT_S = 0.3  # a call that must not wait may take so long: the computer is busy at times
CALLING = "a call that is tried out"  # the name of its thread
BLOCKED_S = 5.0  # a call that takes so much longer than it may is not waited for any more


class _BlockedError(Exception):
    """A call has not returned; the text says which."""


class Checks:
    """Calls a device's methods and collects what is wrong."""

    def __init__(self, clock: Clock) -> None:
        self.clock = clock
        self._found: list[str] = []
        self.answered = True  # whether the last call returned; of one that raised nothing is judged
        self._silent = False

    @property
    def faults(self) -> list[str]:
        """What is wrong, each sentence once, with how often it was found."""
        return [
            f"{sentence} ({times} times)" if times > 1 else sentence
            for sentence, times in Counter(self._found).items()
        ]

    def is_silent(self) -> bool:
        """Whether a call hung or ended with a time-out: each further one would wait as long."""
        return self._silent

    def note(self, sentence: str) -> None:
        """Note what is wrong."""
        self._found.append(sentence)

    def require(self, good: object, sentence: str) -> bool:
        """Note the sentence unless `good`; return whether it is."""
        if not good:
            self.note(sentence)
        return bool(good)

    def has(self, device: object, names: Sequence[str]) -> bool:
        """Require that a device has these methods; return whether it has."""
        missing = [name for name in names if not callable(getattr(device, name, None))]
        return self.require(not missing, f"it has no method {', '.join(missing)}")

    def call(self, name: str, act: Callable[[], T], within_s: float = PROMPT_S) -> T | None:
        """Return what the call returns; None after a fault: it raised, or took too long."""
        began_s = self.clock.now()
        self.answered = False
        try:
            result = self._returned(name, act, within_s)
        except _BlockedError as error:
            self._block(error)
            return None
        except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever it raises is the finding
            self._raised(f"{name} raised {_described(error)}", error)
            return None
        self.answered = True
        self._in_time(name, began_s, within_s)
        return result

    def refuse(
        self,
        name: str,
        act: Callable[[], object],
        wanted: type[DeviceError] = DeviceError,
        within_s: float = PROMPT_S,
    ) -> bool:
        """Require that the call raises this error, or one derived from it; False: it did not."""
        began_s, refused = self.clock.now(), False
        try:
            self._returned(name, act, within_s)
        except _BlockedError as error:
            self._block(error)
            return False
        except wanted as error:
            refused = True
            self.require(str(error), f"{name} raised {type(error).__name__} without a sentence")
        except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever it raises is the finding
            self._raised(f"{name} raised {_described(error)}, not {wanted.__name__}", error)
        else:
            self.note(f"{name} was not refused with {wanted.__name__}")
        self._in_time(name, began_s, within_s)
        return refused

    def identify(self, device: object) -> None:
        """Require that what an open device reports of itself, if it does, is as it must be."""
        if not isinstance(device, Identified):
            return
        found = self.call("identities", device.identities, IDENTITY_S)
        if found is None:
            return
        for each in found:
            if not self.require(
                isinstance(each, DeviceIdentity), f"identities returned {each!r}, no DeviceIdentity"
            ):
                continue
            texts = (each.name, each.maker, each.product, each.serial, each.driver)
            good = all(isinstance(text, str) and text.isprintable() for text in texts)
            self.require(good, f"an identity is not in lines of text: {texts}")

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        self.clock.sleep_until(self.clock.now() + seconds)

    def _returned(self, name: str, act: Callable[[], T], within_s: float) -> T:
        """Return what the call returns, from a thread that is left behind when it hangs."""
        results: list[T] = []
        raised: list[BaseException] = []

        def work() -> None:
            try:
                results.append(act())
            except BaseException as error:  # noqa: BLE001 - raised again, where it is waited for
                raised.append(error)

        limit_s = within_s + BLOCKED_S
        if not self.clock.start_thread(work, CALLING).join(limit_s):
            raise _BlockedError(f"{name} has not returned in {limit_s:g} s: it blocks")
        if raised:
            raise raised[0]
        return results[0]

    def _block(self, error: _BlockedError) -> None:
        self.note(str(error))
        self._silent = True

    def _raised(self, sentence: str, error: BaseException) -> None:
        self.note(sentence)
        self._silent = self._silent or isinstance(error, DeviceTimeoutError)

    def _in_time(self, name: str, began_s: float, within_s: float) -> None:
        took_s = self.clock.now() - began_s
        if took_s > within_s:
            self.note(f"{name} took {took_s:.2f} s; at most {within_s:g} s are allowed")


def _described(error: BaseException) -> str:
    kind = type(error).__name__
    if isinstance(error, DeviceError):
        return f"{kind}: {error}"
    return f"{kind} ({error}), which is no DeviceError"
