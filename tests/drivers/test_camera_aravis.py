"""The binding of libaravis against the fake camera that comes with it, over real packets."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

from drivers.cameras import CAMERAS
from drivers.cameras.conformance import camera_faults
from drivers.cameras.contract import CameraSettings
from drivers.interfaces import Camera, DeviceError, DeviceNotFoundError, RealClock
from tests.drivers.fake_gige import (
    PACKAGE,
    SOURCE,
    FakeCamera,
    fake_camera,
    needs_fake_camera,
    received,
)

pytestmark = [needs_fake_camera, pytest.mark.system_package(PACKAGE), pytest.mark.slow]
CLOCK = RealClock()
RATE_HZ = 25.0


@pytest.fixture(scope="module")
def fake(
    tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest
) -> Iterator[FakeCamera]:
    """The fake camera; a parameter is how many packets of a thousand it drops."""
    lost_per_thousand = getattr(request, "param", 0)
    with fake_camera(tmp_path_factory.mktemp("fake"), lost_per_thousand) as camera:
        yield camera


def made(rate_hz: float = RATE_HZ, **settings: object) -> Camera:
    return CAMERAS.get("aravis").make(CameraSettings(source=SOURCE, **settings), CLOCK, rate_hz)


@contextmanager
def opened(rate_hz: float = RATE_HZ, **settings: object) -> Iterator[Camera]:
    camera = made(rate_hz, **settings)
    camera.open()
    try:
        yield camera
    finally:
        camera.close()  # or the next test cannot have it


def wait(seconds: float) -> None:
    CLOCK.sleep_until(CLOCK.now() + seconds)


def test_it_keeps_the_contract(fake: FakeCamera) -> None:
    assert camera_faults(made(rate_hz=100.0, region=(0, 0, 64, 48)), CLOCK, 0.3) == []


def test_settings_are_set_and_read_back(fake: FakeCamera) -> None:
    wanted = {"exposure_s": 0.004, "gain": 3.0, "pixel_format": "Mono16", "frame_rate_hz": 50.0}
    with opened(region=(16, 8, 320, 200), **wanted) as camera:
        found = camera.settings
        assert found.exposure_s == pytest.approx(0.004, rel=1e-3)
        assert (found.gain, found.pixel_format) == (3.0, "Mono16")
        assert (found.region, found.trigger) == ((16, 8, 320, 200), "free")
        assert found.frame_rate_hz == pytest.approx(50.0, rel=1e-3)
        assert (camera.frame_shape, camera.dtype) == ((200, 320), np.dtype(np.uint16))
        (identity,) = camera.identities()
    assert (identity.maker, identity.product, identity.serial) == ("Aravis", "Fake", "GV01")
    assert identity.is_simulated


def test_where_no_frame_rate_is_set_it_is_that_of_the_protocol(fake: FakeCamera) -> None:
    with opened(rate_hz=40.0, region=(0, 0, 64, 48)) as camera:
        assert camera.settings.frame_rate_hz == pytest.approx(40.0, rel=1e-3)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"pixel_format": "Mono12p"}, "has no [camera] pixel_format Mono12p; it has BayerBG8, "),
        ({"gain": 99.0}, "takes [camera] gain from 0 to 10, not 99"),
        ({"exposure_s": 1e-6}, "takes [camera] exposure_s from 1e-05 to 10, not 1e-06"),
        ({"region": (0, 0, 9999, 480)}, "takes [camera] region's Width from 1 to 2048, not 9999"),
        (
            {"trigger": "hardware", "trigger_input": "Line7"},
            "has no trigger source Line7 ([camera] trigger_input); it has Line0, Software",
        ),
    ],
)
def test_what_it_cannot_be_set_to_is_refused_in_a_sentence(
    fake: FakeCamera, settings: dict[str, object], said: str
) -> None:
    with pytest.raises(DeviceError) as fault:
        made(**settings).open()
    assert said in str(fault.value)


def test_a_camera_that_is_not_there_is_told_with_those_that_are(fake: FakeCamera) -> None:
    camera = CAMERAS.get("aravis").make(CameraSettings(source="aravis:nobody"), CLOCK, RATE_HZ)
    with pytest.raises(DeviceNotFoundError, match=r"aravis:nobody.*found: aravis:Aravis-Fake-GV01"):
        camera.open()


@pytest.mark.alone
def test_each_software_trigger_brings_its_frame(fake: FakeCamera) -> None:
    pulses = []
    with opened(trigger="software", region=(0, 0, 64, 48)) as camera:
        camera.start()
        camera.want_all()
        for _ in range(4):
            pulses.append(camera.fire())
            wait(0.15)
        frames = camera.frames()
    assert len(frames) == 4
    for pulse, frame in zip(pulses, frames, strict=True):
        assert pulse.before_s <= frame.time_s < pulse.after_s + 0.15
        assert frame.device_time_s is not None
    first = frames[0].device_number
    assert first is not None
    assert [frame.device_number for frame in frames] == list(range(first, first + 4))


def test_a_free_camera_takes_no_software_trigger(fake: FakeCamera) -> None:
    refused = pytest.raises(DeviceError, match="takes no software trigger")
    with opened(region=(0, 0, 64, 48)) as camera, refused:
        camera.fire()


@pytest.mark.alone
def test_two_seconds_lose_nothing(fake: FakeCamera) -> None:
    found = received(fake, 2.0)
    assert len(found.whole) > 20  # a busy computer's fake camera sends fewer than 50
    assert found.lost == (0, 0)
    assert found.whole == found.sent


@pytest.mark.parametrize("fake", [10], indirect=True)
def test_each_frame_that_did_not_come_whole_is_counted(fake: FakeCamera) -> None:
    found = received(fake, 2.0)
    assert len(found.spoilt) > 5  # of each frame one packet in a hundred is dropped
    assert not found.spoilt & set(found.whole)
    assert len(found.whole) + sum(found.lost) == len(found.sent)
