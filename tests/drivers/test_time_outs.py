"""Waits that nothing else tries: each ends in its time, with a sentence."""

from __future__ import annotations

import os
import signal
import sys
import threading

import numpy as np
import pytest

from drivers import Guard, GuardSettings
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.rescue import OutputPlace
from drivers.cameras.capture_camera import CaptureCamera
from drivers.interfaces import DeviceTimeoutError, RealClock
from drivers.safe_shutdown import Safety
from sim_hardware.ni import LoopbackWires, NiDeviceServer

CLOCK = RealClock()


@pytest.fixture
def place():
    server = NiDeviceServer(LoopbackWires({"ao0": "ai2"}), CLOCK)
    yield OutputPlace(
        address=f"127.0.0.1:{server.listen(0)}",
        output_channel="PCI6703/ao0",
        drive_channel="PCI6034E/ai2",
    )
    server.stop()


@pytest.mark.slow
def test_a_guard_that_does_not_start_in_time_is_given_up_and_ended(place):
    before = CLOCK.now()
    with pytest.raises(DeviceTimeoutError, match=r"did not start in 0\.01 s"):
        Guard.start(GuardSettings(boards="ni", place=place.as_dict()), timeout_s=0.01)
    assert CLOCK.now() - before < 10.0


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_a_guard_that_hangs_when_it_is_to_act_is_not_waited_for(place, monkeypatch):
    monkeypatch.setattr("drivers.guard.parent._END_S", 0.2)
    guard = Guard.start(GuardSettings(boards="ni", place=place.as_dict()))
    os.kill(guard.pid, signal.SIGSTOP)
    before = CLOCK.now()
    report = guard.act(timeout_s=0.3)
    assert CLOCK.now() - before < 2.0
    assert report.state is Safety.UNKNOWN
    assert "gave no report" in report.text


@pytest.mark.slow
def test_a_camera_that_never_ends_its_frame_is_left_behind(monkeypatch):
    monkeypatch.setattr("drivers.cameras.capture_camera._JOIN_S", 0.1)
    never = threading.Event()

    class Stuck:
        """Delivers two frames and then sits in the next."""

        grabbed = 0

        def isOpened(self):
            return True

        def get(self, _):
            return 0.0

        def set(self, *_):
            return True

        def grab(self):
            self.grabbed += 1
            if self.grabbed > 2:
                never.wait(20.0)
            return True

        def retrieve(self):
            return True, np.zeros((4, 6), np.uint8)

        def read(self):
            return self.retrieve()

        def release(self):
            raise AssertionError("it is inside its capture")

    camera = CaptureCamera("stuck", CLOCK, lambda _: Stuck())
    camera.open()
    CLOCK.sleep_until(CLOCK.now() + 0.05)
    with pytest.raises(DeviceTimeoutError, match=r"did not end its last frame in 0\.1 s"):
        camera.close()
    never.set()


@pytest.mark.slow
def test_a_program_that_holds_the_boards_is_waited_for_in_bounded_time(place):
    from drivers.boards.ni.analog_output import NiVoltageOutput
    from drivers.boards.ni.rescue import shut_down

    holder = NiConnection(place.address)
    holder.open()
    NiVoltageOutput(holder, CLOCK, place.output_channel, 1.0, "another name").open()
    mine = NiConnection(place.address)
    mine.open()
    before = CLOCK.now()
    report = shut_down(mine, CLOCK, place, patience_s=0.3)
    assert 0.3 <= CLOCK.now() - before < 2.0
    assert report.state is Safety.UNKNOWN
    mine.close()
    holder.close()
