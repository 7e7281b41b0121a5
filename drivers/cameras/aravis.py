"""GigE Vision and USB3 Vision cameras through libaravis.

`AravisCapture` has the part of `cv2.VideoCapture`'s interface that `CaptureCamera` uses, and says
what each camera of a network can lose. Each buffer that comes with a part missing is counted as
incomplete, each gap in the camera's own frame numbers as missed: a loss is none but these, and
what comes late is neither.
"""

from __future__ import annotations

import ctypes as c
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from drivers.cameras.aravis_library import (
    NO_PACKET_SOCKET,
    SOCKET_BYTES,
    SUCCESS,
    Aravis,
    load,
    text,
)
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
from drivers.cameras.socket_buffers import enlarged
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
)

_PREFIX = "aravis:"
_BUFFERS = 32
_SLICE_S = 0.1  # of waiting, so that closing does not wait longer
_FAKE = "Aravis Fake"  # what the camera that comes with Aravis calls itself


class AravisFeatures:
    """The features of a camera's device. See `genicam.Features`."""

    def __init__(self, library: Aravis, device: Any, camera: str) -> None:
        self._lib, self._device, self._camera = library, device, camera

    def has(self, name: str) -> bool:
        """See `Features.has`."""
        doing = f"asking the camera {self._camera} for {name}"
        return bool(self._lib.call(doing, "device_is_feature_available", *self._of(name)))

    def number(self, name: str) -> float:
        """See `Features.number`."""
        kind = self._kind(name)
        doing = f"reading {name} of the camera {self._camera}"
        return float(self._lib.call(doing, f"device_get_{kind}_feature_value", *self._of(name)))

    def set_number(self, name: str, value: float) -> None:
        """See `Features.set_number`."""
        kind = self._kind(name)
        number = round(value) if kind == "integer" else value
        self._set(name, f"device_set_{kind}_feature_value", number)

    def bounds(self, name: str) -> tuple[float, float]:
        """See `Features.bounds`."""
        kind = self._kind(name)
        held = c.c_int64 if kind == "integer" else c.c_double
        low, high = held(), held()
        doing = f"asking the camera {self._camera} for the bounds of {name}"
        call = f"device_get_{kind}_feature_bounds"
        self._lib.call(doing, call, *self._of(name), c.byref(low), c.byref(high))
        return float(low.value), float(high.value)

    def choice(self, name: str) -> str:
        """See `Features.choice`."""
        doing = f"reading {name} of the camera {self._camera}"
        return text(self._lib.call(doing, "device_get_string_feature_value", *self._of(name)))

    def set_choice(self, name: str, value: str) -> None:
        """See `Features.set_choice`."""
        self._set(name, "device_set_string_feature_value", value.encode())

    def choices(self, name: str) -> Sequence[str]:
        """See `Features.choices`."""
        doing = f"asking the camera {self._camera} for the values of {name}"
        call = "device_dup_available_enumeration_feature_values_as_strings"
        return self._lib.strings(doing, call, *self._of(name))

    def switch_on(self, name: str) -> None:
        """See `Features.switch_on`."""
        self._set(name, "device_set_boolean_feature_value", 1)

    def execute(self, name: str) -> None:
        """Execute a command."""
        doing = f"{name} of the camera {self._camera}"
        self._lib.call(doing, "device_execute_command", *self._of(name))

    def _kind(self, name: str) -> str:
        return "integer" if self._lib.is_whole(self._device, name.encode()) else "float"

    def _set(self, name: str, call: str, value: Any) -> None:
        doing = f"setting {name} of the camera {self._camera}"
        self._lib.call(doing, call, *self._of(name), value)

    def _of(self, name: str) -> tuple[Any, bytes]:
        return self._device, name.encode()


class AravisCapture:
    """One camera that sends. Frames stay in the stream's buffers until retrieved."""

    def __init__(self, settings: CameraSettings, clock: Clock, rate_hz: float) -> None:
        self._clock = clock
        self._lib = load()
        self._name = str(settings.source).removeprefix(_PREFIX)
        self._shown = self._name or "of any name"
        self._camera: Any = None
        self._stream: Any = None
        self._buffer: Any = None  # the one last grabbed
        self._sends = False
        self._counter = FrameCounter()
        self._trigger: PromptCall | None = None
        try:
            self._take()
            self._device = self._lib.camera_get_device(self._camera)
            self._features = AravisFeatures(self._lib, self._device, self._shown)
            setter = GenicamSetter(self._features, self._shown)
            setter.apply(settings.acquisition(), rate_hz, settings.trigger_input)
            self.settings: AcquisitionSettings = read_back(self._features)
            self._format = format_of(self.settings, self._shown)
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
        return self._camera is not None

    def grab(self) -> bool:
        """Wait for the next whole frame; False when none comes for two seconds."""
        self._give_back()
        give_up_s = self._clock.now() + READ_TIMEOUT_S
        while self._clock.now() < give_up_s:
            buffer = self._lib.stream_timeout_pop_buffer(self._stream, int(_SLICE_S * 1e6))
            if not buffer:
                if self.settings.trigger != FREE:
                    return False  # nothing was triggered
                continue
            self._buffer = buffer
            whole = self._lib.buffer_get_status(buffer) == SUCCESS
            self._counter.count(self._lib.buffer_get_frame_id(buffer), whole=whole)
            if whole:
                return True
            self._give_back()
        return False

    def retrieve(self) -> tuple[bool, GreyImage | None]:
        """Return a copy of the frame last grabbed, grey."""
        if self._buffer is None:
            return False, None
        size = c.c_size_t()
        data = self._lib.buffer_get_data(self._buffer, c.byref(size))
        raw = np.ctypeslib.as_array(c.cast(data, c.POINTER(c.c_uint8)), shape=(size.value,))
        rows = self._lib.buffer_get_image_height(self._buffer)
        columns = self._lib.buffer_get_image_width(self._buffer)
        return True, self._format.grey(raw, rows, columns)

    def read(self) -> tuple[bool, GreyImage | None]:
        """`grab` and `retrieve`."""
        return self.retrieve() if self.grab() else (False, None)

    def device_number(self) -> int | None:
        """Return the camera's own number of the frame last grabbed."""
        return None if self._buffer is None else int(self._lib.buffer_get_frame_id(self._buffer))

    def age_s(self) -> float:
        """Return how long ago the frame last grabbed began to come.

        A frame waits behind one of which a part is awaited, and is not late for that.
        """
        came_ns = int(self._lib.buffer_get_system_timestamp(self._buffer))
        age_s = (time.time_ns() - came_ns) / 1e9
        return age_s if came_ns and 0 < age_s < READ_TIMEOUT_S else 0.0

    def get(self, prop: int) -> float:
        """Return the camera's own time stamp in ms; of other properties nothing is known."""
        if prop == POS_MSEC and self._buffer is not None:
            return float(self._lib.buffer_get_timestamp(self._buffer)) / 1e6
        return 0.0

    def set(self, prop: int, value: float) -> bool:
        """Nothing is set this way: see `AcquisitionSettings`."""
        del prop, value
        return False

    def fire(self) -> None:
        """Begin an exposure by a command."""
        if self._trigger is None:
            what = f"the software trigger of the camera {self._shown}"
            self._trigger = PromptCall(lambda: self._features.execute("TriggerSoftware"), what)
        self._trigger()

    def identity(self) -> DeviceIdentity:
        """Return what the camera says of itself."""
        maker, product, serial = (
            text(self._lib.call(f"asking the camera {self._shown} who it is", name, self._camera))
            for name in (
                "camera_get_vendor_name",
                "camera_get_model_name",
                "camera_get_device_serial_number",
            )
        )
        version = ".".join(
            str(getattr(self._lib, f"get_{part}_version")()) for part in ("major", "minor", "micro")
        )
        return DeviceIdentity(
            name=f"{_PREFIX}{self._name}",
            maker=maker,
            product=product,
            serial=serial,
            driver=f"Aravis {version}",
            is_simulated=_is_simulated(maker, product),
        )

    def release(self) -> None:
        """Stop the camera and let go of it. May be called twice."""
        if self._camera is None:
            return
        self._give_back()
        if self._trigger is not None:
            self._trigger.end()
        camera, self._camera = self._camera, None
        stream, self._stream = self._stream, None
        try:
            if self._sends:
                self._lib.call("stopping the camera", "camera_stop_acquisition", camera)
        except DeviceError:
            pass  # it is gone: what there was to stop has stopped
        finally:
            self._lib.release(stream)
            self._lib.release(camera)

    def _take(self) -> None:
        doing = f"[camera] source = {_PREFIX}{self._name}: opening the camera"
        try:
            self._camera = self._lib.call(doing, "camera_new", self._name.encode() or None)
        except DeviceError as fault:
            there = ", ".join(each.name for each in find()) or "none"
            raise DeviceNotFoundError(f"{fault}; found: {there}") from fault
        if not self._camera:
            raise DeviceNotFoundError(f"{doing} failed: there is no such camera")

    def _begin(self) -> None:
        lib, camera = self._lib, self._camera
        doing = f"starting the camera {self._shown}"
        is_network = bool(lib.camera_is_gv_device(camera))
        if is_network:
            lib.camera_gv_set_stream_options(camera, NO_PACKET_SOCKET)
            lib.call(doing, "camera_gv_auto_packet_size", camera)
        with enlarged(SOCKET_BYTES):
            self._stream = lib.call(doing, "camera_create_stream", camera, None, None)
        if not self._stream:
            raise DeviceError(f"{doing} failed: it gives no stream; check that nothing else has it")
        if is_network:
            lib.set_network_stream(self._stream)
        payload = lib.call(doing, "camera_get_payload", camera)
        for _ in range(_BUFFERS):
            lib.stream_push_buffer(self._stream, lib.buffer_new_allocate(payload))
        lib.call(doing, "camera_start_acquisition", camera)
        self._sends = True

    def _give_back(self) -> None:
        if self._buffer is not None:
            buffer, self._buffer = self._buffer, None
            # Where the packet is lost that has the number, a buffer keeps its last frame's.
            self._lib.buffer_set_frame_id(buffer, 0)
            self._lib.stream_push_buffer(self._stream, buffer)


def find() -> list[DeviceIdentity]:
    """Return the cameras that are there, with the source of each as its name."""
    lib = load()
    lib.update_device_list()
    return [_listed(lib, number) for number in range(lib.get_n_devices())]


def _listed(lib: Aravis, number: int) -> DeviceIdentity:
    maker, product = text(lib.get_device_vendor(number)), text(lib.get_device_model(number))
    return DeviceIdentity(
        name=f"{_PREFIX}{text(lib.get_device_id(number))}",
        maker=maker,
        product=product,
        serial=text(lib.get_device_serial_nbr(number)),
        driver=f"{text(lib.get_device_protocol(number))} {text(lib.get_device_address(number))}",
        is_simulated=_is_simulated(maker, product),
    )


def _is_simulated(maker: str, product: str) -> bool | None:
    return True if f"{maker} {product}" == _FAKE else says_simulated(product)


def _make(settings: CameraSettings, clock: Clock, rate_hz: float) -> Camera:
    return CaptureCamera(
        settings.source, clock, lambda _source: AravisCapture(settings, clock, rate_hz)
    )


CAMERA = CameraKind(
    kind="aravis",
    help="GigE Vision and USB3 Vision cameras on libaravis: aravis:NAME, or aravis: for the first",
    prefix=_PREFIX,
    make=_make,
    sets=ALL_SETTINGS,
    find=find,
    starter="""\
source = "aravis:"                 # the first camera, or "aravis:NAME" as `labrig devices` lists it
optics = "optics.json"
"""
    + STARTER_SETTINGS,
    simulated_starter=f'kind = "aravis"\n{SIMULATED_SETTINGS}',
)
