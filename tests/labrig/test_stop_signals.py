"""Ctrl-C where a device does not answer and no guard acts: at 0 V, or before the first voltage."""

from __future__ import annotations

import pytest

from protocols.execution.stop import DEAF_S, SignalledStop, StopLevel, StopRequest


class Pressed:
    """Somebody who sends signals, and waits between them."""

    def __init__(self) -> None:
        self.stop, self.time_s, self.count = StopRequest(), 100.0, 0
        self.ask = SignalledStop(self.stop, lambda: self.time_s)

    def press(self, name: str = "SIGINT", after_s: float = 0.0) -> StopLevel:
        self.time_s += after_s
        self.count += 1
        self.ask(name, self.count)
        return self.stop.level


def test_a_program_that_does_not_obey_a_stop_at_once_is_interrupted_by_the_next_signal():
    operator = Pressed()
    assert operator.press() is StopLevel.AFTER_PULSE
    assert operator.press(after_s=10 * DEAF_S) is StopLevel.NOW  # the pulse may be a long one
    assert operator.press(after_s=0.5 * DEAF_S) is StopLevel.NOW  # it may still obey
    with pytest.raises(KeyboardInterrupt):
        operator.press(after_s=0.6 * DEAF_S)


def test_sigterm_asks_for_a_stop_at_once_and_the_second_one_interrupts():
    operator = Pressed()
    assert operator.press("SIGTERM") is StopLevel.NOW
    with pytest.raises(KeyboardInterrupt):
        operator.press("SIGTERM", after_s=DEAF_S)


def test_a_device_that_does_not_take_0_V_after_an_interrupt_is_interrupted_again():
    operator = Pressed()
    operator.press("SIGTERM")
    with pytest.raises(KeyboardInterrupt):
        operator.press("SIGTERM", after_s=DEAF_S)
    operator.press("SIGTERM", after_s=0.5 * DEAF_S)  # it may still obey
    with pytest.raises(KeyboardInterrupt):
        operator.press("SIGTERM", after_s=0.6 * DEAF_S)


def test_the_safe_shutdown_is_never_interrupted():
    operator = Pressed()
    operator.press("SIGTERM")
    operator.stop.obey()
    operator.press("SIGTERM", after_s=DEAF_S)
