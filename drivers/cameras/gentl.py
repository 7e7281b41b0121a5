"""Any vendor's camera through the vendor's GenTL producer (a .cti file), by harvesters.

harvesters and genicam are imported when they are used. They hold Python's lock while they wait for
a frame, so they are never let wait: a look every 2 ms costs the working loop nothing.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from drivers.cameras.capture import POS_MSEC, READ_TIMEOUT_S
from drivers.cameras.capture_camera import CaptureCamera
from drivers.cameras.contract import ALL_SETTINGS, CameraKind, CameraSettings
from drivers.cameras.frame_counter import FrameCounter
from drivers.cameras.genicam import (
    SIMULATED_SETTINGS,
    STARTER_SETTINGS,
    GenicamSetter,
    format_of,
    read_back,
)
from drivers.cameras.prompt_call import PromptCall
from drivers.identity import says_simulated
from drivers.interfaces import (
    FREE,
    AcquisitionSettings,
    Camera,
    Clock,
    DeviceError,
    DeviceIdentity,
    DeviceNotFoundError,
    GreyImage,
    in_words,
)

_PREFIX = "gentl:"
_PLACES = "GENICAM_GENTL64_PATH"  # where GenTL producers are installed, by the standard
_POLL_S = 2e-3
_SLICE_S = 0.1
_BUFFERS = 16
_SIMULATED = "Viky"  # model of the devices that the genicam package brings


@dataclass(frozen=True, kw_only=True)
class GentlSettings(CameraSettings):
    """A camera behind a GenTL producer."""

    producer: str = field(
        default="",
        metadata={
            "description": f"the vendor's .cti file; by default all in the folders of {_PLACES}",
            "path": True,
        },
    )


class GentlFeatures:
    """The features of a camera's node map. See `genicam.Features`."""

    def __init__(self, nodes: Any, camera: str) -> None:
        self._nodes = nodes
        self._camera = camera

    def has(self, name: str) -> bool:
        """See `Features.has`."""
        from genicam.genapi import EAccessMode

        with _told(f"asking the camera {self._camera} for {name}"):
            if not self._nodes.has_node(name):
                return False
            there = (EAccessMode.RO, EAccessMode.RW, EAccessMode.WO)
            return getattr(self._nodes, name).get_access_mode() in there

    def number(self, name: str) -> float:
        """See `Features.number`."""
        return float(self._value(name))

    def set_number(self, name: str, value: float) -> None:
        """See `Features.set_number`."""
        from genicam.genapi import IInteger

        is_whole = isinstance(getattr(self._nodes, name), IInteger)
        self._set(name, round(value) if is_whole else value)

    def bounds(self, name: str) -> tuple[float, float]:
        """See `Features.bounds`."""
        with _told(f"asking the camera {self._camera} for the bounds of {name}"):
            node = getattr(self._nodes, name)
            return float(node.min), float(node.max)

    def choice(self, name: str) -> str:
        """See `Features.choice`."""
        return str(self._value(name))

    def set_choice(self, name: str, value: str) -> None:
        """See `Features.set_choice`."""
        self._set(name, value)

    def choices(self, name: str) -> Sequence[str]:
        """See `Features.choices`."""
        with _told(f"asking the camera {self._camera} for the values of {name}"):
            return [str(value) for value in getattr(self._nodes, name).symbolics]

    def switch_on(self, name: str) -> None:
        """See `Features.switch_on`."""
        self._set(name, True)  # noqa: FBT003 - the value of a feature

    def execute(self, name: str) -> None:
        """Execute a command."""
        with _told(f"{name} of the camera {self._camera}"):
            getattr(self._nodes, name).execute()

    def _value(self, name: str) -> Any:
        with _told(f"reading {name} of the camera {self._camera}"):
            return getattr(self._nodes, name).value

    def _set(self, name: str, value: Any) -> None:
        with _told(f"setting {name} of the camera {self._camera}"):
            getattr(self._nodes, name).value = value


class GentlCapture:
    """One camera that sends, with the part of `cv2.VideoCapture` that `CaptureCamera` uses."""

    def __init__(self, settings: GentlSettings, clock: Clock, rate_hz: float) -> None:
        self._clock = clock
        self._name = str(settings.source).removeprefix(_PREFIX)
        self._harvester = _harvester(settings.producer)
        self._acquirer: Any = None
        self._buffer: Any = None  # the one last grabbed
        self._counter = FrameCounter()
        self._trigger: PromptCall | None = None
        try:
            self._identity, self._acquirer = self._take()
            shown = self._identity.name
            features = GentlFeatures(self._acquirer.remote_device.node_map, shown)
            setter = GenicamSetter(features, shown)
            setter.apply(settings.acquisition(), rate_hz, settings.trigger_input)
            self.settings: AcquisitionSettings = read_back(features)
            self._format = format_of(self.settings, shown)
            self._features = features
            self._begin()
        except BaseException:
            self.release()
            raise

    @property
    def layout(self) -> tuple[int, int, np.dtype[Any]]:
        """Rows, columns and type of a frame."""
        _, _, columns, rows = self.settings.region or (0, 0, 0, 0)
        return rows, columns, self._format.dtype

    @property
    def losses(self) -> tuple[int, int]:
        """Frames since it was opened that came incomplete, and that never came."""
        return self._counter.incomplete, self._counter.missed

    def isOpened(self) -> bool:
        """Whether the camera is there."""
        return self._acquirer is not None

    def grab(self) -> bool:
        """Wait for the next whole frame; False when none comes for two seconds."""
        self._give_back()
        began_s = self._clock.now()
        is_free = self.settings.trigger == FREE
        give_up_s = began_s + (READ_TIMEOUT_S if is_free else _SLICE_S)
        while self._clock.now() < give_up_s:
            with _told(f"fetching a frame of the camera {self._identity.name}"):
                buffer = self._acquirer.try_fetch(timeout=1e-5, is_raw=True)
            if buffer is not None:
                self._buffer = buffer
                self._counter.count(int(buffer.frame_id), whole=True)
                return True
            self._clock.sleep_until(self._clock.now() + _POLL_S)
        return False

    def retrieve(self) -> tuple[bool, GreyImage | None]:
        """Return a copy of the frame last grabbed, grey."""
        if self._buffer is None:
            return False, None
        with _told(f"reading a frame of the camera {self._identity.name}"):
            rows, columns = int(self._buffer.height), int(self._buffer.width)
            raw = np.frombuffer(self._buffer.raw_buffer, dtype=np.uint8)
            raw = raw[int(self._asked("image_offset") or 0) :]
        return True, self._format.grey(raw, rows, columns)

    def read(self) -> tuple[bool, GreyImage | None]:
        """`grab` and `retrieve`."""
        return self.retrieve() if self.grab() else (False, None)

    def device_number(self) -> int | None:
        """Return the camera's own number of the frame last grabbed."""
        return None if self._buffer is None else int(self._buffer.frame_id)

    def get(self, prop: int) -> float:
        """Return the camera's own time stamp in ms, where it gives one."""
        if prop == POS_MSEC and self._buffer is not None:
            return float(self._asked("timestamp_ns") or 0.0) / 1e6
        return 0.0

    def set(self, prop: int, value: float) -> bool:
        """Nothing is set this way: see `AcquisitionSettings`."""
        del prop, value
        return False

    def fire(self) -> None:
        """Begin an exposure by a command."""
        if self._trigger is None:
            what = f"the software trigger of the camera {self._identity.name}"
            self._trigger = PromptCall(lambda: self._features.execute("TriggerSoftware"), what)
        self._trigger()

    def identity(self) -> DeviceIdentity:
        """Return what the producer says of the camera."""
        return self._identity

    def release(self) -> None:
        """Stop the camera and let go of it. May be called twice."""
        self._give_back()
        if self._trigger is not None:
            self._trigger.end()
        acquirer, self._acquirer = self._acquirer, None
        with suppress(Exception):  # a producer of another maker: whatever it raises, it is over
            if acquirer is not None:
                acquirer.destroy()
        with suppress(Exception):
            self._harvester.reset()

    def _take(self) -> tuple[DeviceIdentity, Any]:
        there = [_listed(info) for info in self._harvester.device_info_list]
        keys = [(each.name, f"{_PREFIX}{each.serial}") for each in there]
        wanted = f"{_PREFIX}{self._name}"
        chosen = [k for k, names in enumerate(keys) if wanted in names or not self._name]
        if not chosen:
            found = ", ".join(each.name for each in there) or "none"
            raise DeviceNotFoundError(f"[camera] source = {wanted}: no such camera; found: {found}")
        with _told(f"opening the camera {there[chosen[0]].name}"):
            return there[chosen[0]], self._harvester.create(chosen[0])

    def _begin(self) -> None:
        from harvesters.core import Callback

        counter = self._counter

        class Incomplete(Callback):  # type: ignore[misc, unused-ignore]
            def emit(self, context: object = None) -> None:
                """Count it: harvesters hands over whole frames only."""
                del context
                counter.count_incomplete()

        acquirer = self._acquirer
        with _told(f"starting the camera {self._identity.name}"):
            acquirer.add_callback(acquirer.Events.INCOMPLETE_BUFFER, Incomplete())
            acquirer.num_buffers = max(_BUFFERS, acquirer.min_num_buffers)
            acquirer.timeout_period_on_update_event_data_call = 0
            acquirer.start()

    def _give_back(self) -> None:
        if self._buffer is not None:
            buffer, self._buffer = self._buffer, None
            with suppress(Exception):  # a camera that is gone takes none back
                buffer.parent.queue_buffer(buffer)

    def _asked(self, name: str) -> Any:
        """Return what a producer may not know of a buffer; None then."""
        try:
            return getattr(self._buffer, name)
        except Exception:  # noqa: BLE001 - each producer has errors of its own
            return None


def find() -> list[DeviceIdentity]:
    """Return the cameras of all producers that are installed."""
    harvester = _harvester("")
    try:
        return [_listed(info) for info in harvester.device_info_list]
    finally:
        harvester.reset()


def producers(producer: str) -> list[Path]:
    """Return the .cti file that is named, or all that are installed."""
    if producer:
        return [Path(producer)]
    folders = [Path(each) for each in os.environ.get(_PLACES, "").split(os.pathsep) if each]
    return sorted(path for folder in folders for path in folder.glob("*.cti"))


def _harvester(producer: str) -> Any:
    """Return harvesters with the producers loaded. Raises DeviceNotFoundError."""
    try:
        from harvesters.core import Harvester
    except ImportError as fault:
        raise DeviceNotFoundError(
            f"harvesters cannot be imported ({fault}): pip install labrig[gentl], or use another "
            "kind of [camera] source"
        ) from fault
    found = producers(producer)
    if not found:
        raise DeviceNotFoundError(
            f"no GenTL producer is installed ({_PLACES} names no folder with a .cti file): install "
            "the camera vendor's software, or name its .cti file in [camera] producer"
        )
    harvester = Harvester()
    for path in found:
        if not path.is_file():
            raise DeviceNotFoundError(f"[camera] producer = {path}: there is no such file")
        with _told(f"loading the GenTL producer {path}"):
            harvester.add_file(str(path), check_existence=True, check_validity=True)
    with _told("looking for cameras"):
        harvester.update()
    return harvester


def _listed(info: Any) -> DeviceIdentity:
    def told(name: str) -> str:
        try:
            text = str(getattr(info, name) or "")
        except Exception:  # noqa: BLE001 - each producer has errors of its own
            return ""
        return text if text.isprintable() else repr(text)

    product = told("model")
    return DeviceIdentity(
        name=f"{_PREFIX}{told('id_')}",
        maker=told("vendor"),
        product=product,
        serial=told("serial_number"),
        driver=f"GenTL {told('tl_type')}",
        is_simulated=True if product == _SIMULATED else says_simulated(product),
    )


@contextmanager
def _told(doing: str) -> Iterator[None]:
    """Make DeviceErrors of whatever a producer raises."""
    try:
        yield
    except DeviceError:
        raise
    except Exception as fault:
        raise DeviceError(f"{doing} failed: {in_words(fault)}") from fault


def _make(settings: GentlSettings, clock: Clock, rate_hz: float) -> Camera:
    return CaptureCamera(
        settings.source, clock, lambda _source: GentlCapture(settings, clock, rate_hz)
    )


CAMERA = CameraKind(
    kind="gentl",
    help="any camera with a GenTL producer of its vendor: gentl:NAME, or gentl: for the first",
    settings=GentlSettings,
    prefix=_PREFIX,
    make=_make,
    sets=ALL_SETTINGS,
    find=find,
    starter="""\
source = "gentl:"                  # the first camera, or "gentl:NAME" as `labrig devices` lists it
# producer = "/opt/vendor/x.cti"   # by default all in the folders of GENICAM_GENTL64_PATH
optics = "optics.json"
"""
    + STARTER_SETTINGS,
    simulated_starter=f'kind = "gentl"\n{SIMULATED_SETTINGS}',
)
