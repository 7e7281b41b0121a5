"""Cameras behind a GenTL producer, with the simulated devices that the genicam package brings."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from drivers.cameras import CAMERAS
from drivers.cameras.conformance import camera_faults
from drivers.interfaces import Camera, DeviceError, DeviceNotFoundError, RealClock

genicam = pytest.importorskip("genicam", reason="pip install labrig[gentl]")
pytest.importorskip("harvesters.core", reason="pip install labrig[gentl]")
pytestmark = pytest.mark.slow
PRODUCER = Path(genicam.__file__).with_name("viky.cti")
SOURCE = "gentl:VikyTL_DEV_red"
CLOCK = RealClock()
KIND = CAMERAS.get("gentl")


def made(source: str = SOURCE, **settings: object) -> Camera:
    wanted = {"producer": str(PRODUCER), **settings}
    return KIND.make(KIND.settings(source=source, **wanted), CLOCK, 100.0)


@contextmanager
def opened(**settings: object) -> Iterator[Camera]:
    camera = made(**settings)
    camera.open()
    try:
        yield camera
    finally:
        camera.close()


def test_it_keeps_the_contract() -> None:
    assert camera_faults(made(region=(0, 0, 100, 100)), CLOCK, 0.15) == []


def test_settings_are_set_and_read_back_and_frames_have_the_cameras_number() -> None:
    with opened(region=(0, 0, 200, 120), frame_rate_hz=150.0) as camera:
        found = camera.settings
        assert (found.region, found.pixel_format) == ((0, 0, 200, 120), "Mono8")
        assert (found.frame_rate_hz, found.trigger) == (pytest.approx(150.0), "free")
        assert (found.exposure_s, found.gain) == (None, None)  # it has none
        (identity,) = camera.identities()
        camera.start()
        camera.want_all()
        CLOCK.sleep_until(CLOCK.now() + 0.2)
        frames = camera.frames()
        counts = camera.counts
    assert (identity.product, identity.is_simulated) == ("Viky", True)
    assert len(frames) > 3
    numbers = [frame.device_number for frame in frames]
    assert all(number is not None for number in numbers)
    between = np.diff([float(number or 0) for number in numbers])
    assert counts.missed == int(np.sum(between - 1)) or counts.missed > 0
    assert {frame.image.shape for frame in frames} == {(120, 200)}
    assert max(float(frame.image.std()) for frame in frames) > 1.0  # a ball, not a blank


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"exposure_s": 0.01}, "has no setting for [camera] exposure_s; remove the key"),
        ({"gain": 1.0}, "has no setting for [camera] gain; remove the key"),
        ({"trigger": "software"}, "has no setting for [camera] trigger; remove the key"),
        ({"pixel_format": "Mono12"}, "has no [camera] pixel_format Mono12; it has Mono8"),
        ({"region": (0, 0, 640, 4000)}, "takes [camera] region's Height from 100 to 800"),
        ({"region": (8, 0, 640, 480)}, "the nearest that it takes is [0, 0, 640, 480]"),
        ({"frame_rate_hz": 900.0}, "takes [camera] frame_rate_hz from 1 to 200, not 900"),
        ({"producer": "nowhere.cti"}, "producer = nowhere.cti: there is no such file"),
        ({"source": "gentl:nobody"}, "no such camera; found: gentl:VikyTL_DEV_red"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(settings: dict[str, object], said: str) -> None:
    with pytest.raises(DeviceError) as fault:
        made(**settings).open()
    assert said in str(fault.value)


def test_cameras_of_the_producers_that_are_installed_are_listed(monkeypatch) -> None:
    monkeypatch.setenv("GENICAM_GENTL64_PATH", str(PRODUCER.parent))
    assert KIND.find is not None
    assert SOURCE in [each.name for each in KIND.find()]
    monkeypatch.delenv("GENICAM_GENTL64_PATH")
    with pytest.raises(DeviceNotFoundError, match="no GenTL producer is installed"):
        KIND.find()
