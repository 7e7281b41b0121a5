"""A camera is judged by how fast it goes, not by what a busy computer hands over at once."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from drivers.interfaces import AcquisitionSettings, CameraCounts
from labrig.experiment.preflight import camera_checks


class Bursting:
    """A camera that hands over so many frames in each second it is watched."""

    frame_shape = (480, 640)

    def __init__(self, *grabbed: int) -> None:
        self.left = list(grabbed)
        self.counts = CameraCounts(0, 0)
        self.settings = AcquisitionSettings()

    def start(self) -> None:
        self.counts = CameraCounts(self.left.pop(0), 0)

    def want(self, begin_s: float, end_s: float) -> None:
        assert end_s > begin_s

    def frames(self) -> list[SimpleNamespace]:
        return [SimpleNamespace(image=np.arange(256, dtype=np.uint8).reshape(16, 16))]

    def stop(self) -> None:
        pass


def rate(camera: Bursting) -> tuple[bool, str]:
    clock = SimpleNamespace(now=lambda: 0.0, sleep_until=lambda _time: None)
    plan = SimpleNamespace(optics=None, schedule=SimpleNamespace(frame_rate_hz=25.0))
    found = {
        c.name: c for c in camera_checks(SimpleNamespace(clock=clock, trigger=None), camera, plan)
    }
    assert found["camera sees something"].ok
    return found["camera rate"].ok, found["camera rate"].found


@pytest.mark.parametrize("first", [31, 18])
def test_frames_of_a_busy_moment_do_not_make_a_camera_too_fast_or_too_slow(first):
    assert rate(Bursting(first, 25)) == (True, "25 frames/s")


def test_a_camera_of_another_rate_is_still_refused():
    assert rate(Bursting(15, 15)) == (False, "15 frames/s")


def test_a_camera_in_time_is_watched_once():
    assert rate(Bursting(25)) == (True, "25 frames/s")
