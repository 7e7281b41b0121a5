"""The fake GigE Vision camera of aravis-tools on the loopback, and what it says that it sent."""

from __future__ import annotations

import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.processes import ended

PROGRAM = "arv-fake-gv-camera-0.8"
SOURCE = "aravis:127.0.0.1"
PACKAGE = "aravis-tools"
_PORT_LOCK = Path("/tmp/labrig-fake-gige.lock")  # of all workers: GVCP has one port a computer
_SENT = re.compile(r"Send frame (\d+)")
_DROPPED = re.compile(r"Drop GVSP \w+ packet frame:\s*(\d+)")

needs_fake_camera = pytest.mark.skipif(
    shutil.which(PROGRAM) is None or sys.platform == "win32",
    reason=f"{PROGRAM} is not there (apt install aravis-tools)",
)


@dataclass(frozen=True)
class FakeCamera:
    """The process, by its log."""

    log: Path

    def frames(self) -> tuple[list[int], set[int]]:
        """Return the numbers that it has sent since it was last started, and those it spoilt."""
        text = self.log.read_text(errors="replace").rpartition("Start stream")[2]
        sent = [int(number) for number in _SENT.findall(text)]
        return sent, {int(number) for number in _DROPPED.findall(text)}


@dataclass(frozen=True, kw_only=True)
class Received:
    """What came of what the camera sent, up to the last frame that came whole."""

    sent: list[int]  # numbers, as the camera's own log has them
    spoilt: set[int]  # of these: it dropped a packet
    whole: list[int]  # as labrig has them
    lost: tuple[int, int]  # as labrig counts them: incomplete, missed


def received(fake: FakeCamera, seconds: float, rate_hz: float = 25.0) -> Received:
    """Take 640 x 480 frames for so long."""
    from drivers.cameras.aravis import AravisCapture
    from drivers.cameras.contract import CameraSettings
    from drivers.interfaces import RealClock

    clock = RealClock()
    settings = CameraSettings(source=SOURCE, region=(0, 0, 640, 480))
    capture = AravisCapture(settings, clock, rate_hz)
    whole: list[int] = []
    lost = (0, 0)
    until_s = clock.now() + seconds
    try:
        while clock.now() < until_s and capture.grab():
            good, image = capture.retrieve()
            assert good
            assert image is not None
            assert image.shape == (480, 640)
            whole.append(capture.device_number() or 0)
            lost = capture.losses  # of all frames before this one
    finally:
        capture.release()
    sent, spoilt = fake.frames()
    sent = sent[: sent.index(whole[-1]) + 1]
    return Received(sent=sent, spoilt=spoilt & set(sent), whole=whole, lost=lost)


@contextmanager
def fake_camera(folder: Path, lost_per_thousand: int = 0) -> Iterator[FakeCamera]:
    """Run it, one at a time on this computer."""
    import fcntl

    log = folder / f"fake-{lost_per_thousand}.log"
    with _PORT_LOCK.open("w") as lock, log.open("wb") as output:
        fcntl.flock(lock, fcntl.LOCK_EX)
        line_by_line = ["stdbuf", "-oL"] if shutil.which("stdbuf") else []
        command = [PROGRAM, "-i", "127.0.0.1", "-s", "GV01", "-r", str(lost_per_thousand)]
        process = subprocess.Popen(
            [*line_by_line, *command, "-d", "stream-thread:2"], stdout=output, stderr=output
        )
        try:
            _await(process)
            yield FakeCamera(log)
        finally:
            process.send_signal(signal.SIGTERM)
            with suppress(subprocess.TimeoutExpired):
                process.wait(5)
            process.kill()
            ended(process)


def _await(process: subprocess.Popen[bytes]) -> None:
    """Wait until it can be opened."""
    from drivers.cameras.aravis_library import load
    from drivers.interfaces import DeviceError

    until_s = time.monotonic() + 10.0
    library = load()
    while time.monotonic() < until_s:
        assert process.poll() is None, f"{PROGRAM} has ended"
        try:
            camera = library.call("opening it", "camera_new", b"127.0.0.1")
        except DeviceError:
            camera = None
        if camera:
            library.release(camera)
            return
        time.sleep(0.05)  # noqa: TID251 - it is another process
    raise AssertionError(f"{PROGRAM} does not answer")
