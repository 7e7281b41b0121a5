"""Images from a job to the pages: as JPEGs at once, their curves as they come.

Each step has one slot for the newest image: a slow step skips images and holds nothing up.
"""

from __future__ import annotations

import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Generic, TypeVar

from drivers.interfaces import GreyImage
from labrig.panel.live.event_stream import EventStream, Message, Picture
from labrig.panel.live.frames import image_of, jpeg_picture
from labrig.panel.live.packing import BrokenConnectionError, pack, read, write
from labrig.panel.processes import in_background, lower_priority, module_environment

_RESTARTS = 3  # of a curve process that dies; then there are no curves any more
Item = TypeVar("Item")


class FrameSlot(Generic[Item]):
    """One slot: `put` never waits, `take` returns the newest."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._item: Item | None = None
        self._closed = False

    def put(self, item: Item) -> None:
        """In the place of what was there."""
        with self._changed:
            self._item = item
            self._changed.notify()

    def take(self) -> Item | None:
        """Wait for something; None once it is closed."""
        with self._changed:
            while self._item is None and not self._closed:
                self._changed.wait()
            item, self._item = self._item, None
            return None if self._closed else item

    def close(self) -> None:
        """Nobody will take any more."""
        with self._changed:
            self._closed = True
            self._changed.notify()


class FramePipeline:
    """Take raw images, publish JPEGs and curves. Its threads end with `close`."""

    def __init__(self, stream: EventStream) -> None:
        self._stream = stream
        self._raw: FrameSlot[Picture] = FrameSlot()
        self._to_search: FrameSlot[Picture] = FrameSlot()
        self._setup: Message | None = None
        self._model: str | None = None
        self._setup_version = 0  # counts changes of setup and model
        self._newest: tuple[Message, GreyImage] | None = None
        self._process: subprocess.Popen[bytes] | None = None
        for work, name in ((self._develop, "pictures"), (self._search, "curves")):
            threading.Thread(target=work, name=f"panel-{name}", daemon=True).start()

    def put(self, picture: Picture) -> None:
        """Hand over a raw image. Never waits."""
        self._raw.put(picture)

    def set_setup(self, setup: Message | None) -> None:
        """Set what the next images show; None: nothing is known, no curves."""
        self._setup = setup
        self._setup_version += 1

    def choose_model(self, path: Path | None) -> None:
        """Whose predicted curve is drawn."""
        self._model = None if path is None else str(path)
        self._setup_version += 1

    def newest(self) -> tuple[Message, GreyImage] | None:
        """Return the newest picture, for a calibration."""
        return self._newest

    def close(self) -> None:
        """End threads and process."""
        self._raw.close()
        self._to_search.close()
        process = self._process
        if process is not None:
            process.kill()
            process.wait()

    def _develop(self) -> None:
        while (picture := self._raw.take()) is not None:
            header, raw = picture
            with suppress(ValueError, KeyError):  # a picture that says it is larger than it is
                image = image_of(header, raw)
                self._newest = (header, image)
                self._stream.publish_picture(jpeg_picture(header, image))
                if self._setup is not None and header.get("run") is not None:
                    self._to_search.put(picture)

    def _search(self) -> None:
        version, starts = -1, 0
        while (picture := self._to_search.take()) is not None:
            try:
                if self._process is None or self._process.poll() is not None:
                    if starts > _RESTARTS:
                        continue
                    self._process, version, starts = _spawn(), -1, starts + 1
                if version != self._setup_version:
                    version = self._setup_version
                    self._send_setup(self._process)
                curve = _asked(self._process, picture)
            except (OSError, BrokenConnectionError):
                continue
            self._stream.publish_newest(curve)

    def _send_setup(self, process: subprocess.Popen[bytes]) -> None:
        assert process.stdin is not None  # noqa: S101 - for the type checker
        if self._setup is not None:
            write(process.stdin, pack(self._setup))
        write(process.stdin, pack({"type": "model", "path": self._model}))


def _asked(process: subprocess.Popen[bytes], picture: Picture) -> Message:
    assert process.stdin is not None  # noqa: S101 - for the type checker
    assert process.stdout is not None  # noqa: S101
    write(process.stdin, pack(*picture))
    return read(process.stdout)[0]


def _spawn() -> subprocess.Popen[bytes]:
    process = subprocess.Popen(
        [sys.executable, "-m", "labrig.panel.live.curve_start"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=module_environment(),
        **in_background(),
    )
    lower_priority(process.pid)
    return process
