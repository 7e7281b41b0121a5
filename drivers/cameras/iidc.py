"""IIDC cameras on FireWire (such as a Dragonfly Express) through libdc1394, by ctypes.

`IidcCapture` has the part of `cv2.VideoCapture`'s interface that `CaptureCamera` uses.
libdc1394 is loaded when it is used; structures and numbers are those of its version 2 headers.
"""

from __future__ import annotations

import ctypes as c
import ctypes.util
import time
from typing import Any

import numpy as np
import numpy.typing as npt

from drivers.cameras.capture import FPS, HEIGHT, POS_MSEC, READ_TIMEOUT_S, WIDTH
from drivers.cameras.capture_camera import CaptureCamera
from drivers.cameras.contract import CameraKind, CameraSettings
from drivers.interfaces import Camera, Clock, DeviceError, DeviceIdentity, DeviceNotFoundError

_SUCCESS, _ON, _OFF = 0, 1, 0
_ISO_SPEED_400, _ISO_SPEED_800 = 2, 3
_OPERATION_LEGACY, _OPERATION_1394B = 480, 481
_MODE_640x480_MONO8 = 69
_FRAMERATES = {1.875: 32, 3.75: 33, 7.5: 34, 15.0: 35, 30.0: 36, 60.0: 37, 120.0: 38, 240.0: 39}
_CAPTURE_DEFAULT = 0x4
_POLICY_POLL = 673
_DMA_BUFFERS = 8
_POLL_S = 2e-3
_LOOKS = 3  # at two clocks, of which the quickest counts: a thread may stand still between them
_SIZE = (640, 480)


class _CameraId(c.Structure):
    _fields_ = (("unit", c.c_uint16), ("guid", c.c_uint64))


class _CameraList(c.Structure):
    _fields_ = (("num", c.c_uint32), ("ids", c.POINTER(_CameraId)))


class _Camera(c.Structure):
    """dc1394camera_t, as far as it is read."""

    _fields_ = (
        ("guid", c.c_uint64),
        ("unit", c.c_int),
        ("unit_spec_id", c.c_uint32),
        ("unit_sw_version", c.c_uint32),
        ("unit_sub_sw_version", c.c_uint32),
        ("command_registers_base", c.c_uint32),
        ("unit_directory", c.c_uint32),
        ("unit_dependent_directory", c.c_uint32),
        ("advanced_features_csr", c.c_uint64),
        ("pio_control_csr", c.c_uint64),
        ("sio_control_csr", c.c_uint64),
        ("strobe_control_csr", c.c_uint64),
        ("format7_csr", c.c_uint64 * 8),
        ("iidc_version", c.c_int),
        ("vendor", c.c_char_p),
        ("model", c.c_char_p),
    )


class _VideoFrame(c.Structure):
    """dc1394video_frame_t, as far as it is read (the rest follows `frames_behind`)."""

    _fields_ = (
        ("image", c.POINTER(c.c_uint8)),
        ("size", c.c_uint32 * 2),
        ("position", c.c_uint32 * 2),
        ("color_coding", c.c_int),
        ("color_filter", c.c_int),
        ("yuv_byte_order", c.c_uint32),
        ("data_depth", c.c_uint32),
        ("stride", c.c_uint32),
        ("video_mode", c.c_int),
        ("total_bytes", c.c_uint64),
        ("image_bytes", c.c_uint32),
        ("padding_bytes", c.c_uint32),
        ("packet_size", c.c_uint32),
        ("packets_per_frame", c.c_uint32),
        ("timestamp", c.c_uint64),
        ("frames_behind", c.c_uint32),
    )


def _to_time_of_day_s() -> float:
    """Return by how much the time of day is ahead of a clock that nobody can set."""
    found: list[tuple[float, float]] = []
    for _ in range(_LOOKS):
        before_s = time.perf_counter()
        wall_s = time.time()
        after_s = time.perf_counter()
        found.append((after_s - before_s, wall_s - (before_s + after_s) / 2))
    return min(found)[1]


class IidcCapture:
    """One camera in 640 x 480, 8 bit grey. Frames stay in the ring buffer until retrieved."""

    def __init__(
        self, guid: int | None, clock: Clock, rate_hz: float = 30.0, library: str | None = None
    ) -> None:
        self._clock = clock
        self._rate_hz = min(_FRAMERATES, key=lambda rate: (rate < rate_hz, rate))
        self._lib = _load(library)
        self._bus = self._lib.dc1394_new()
        self._camera: Any = None
        self._frame: Any = None
        self._stamp_s = 0.0
        self._to_time_of_day_s = _to_time_of_day_s()
        self._transmitting = False
        if not self._bus:
            raise DeviceNotFoundError(
                "libdc1394 finds no FireWire bus: check the adapter, its kernel driver and the "
                "permissions of /dev/fw*"
            )
        try:
            self._camera = self._take(guid)
            self._begin()
        except BaseException:
            self.release()
            raise

    def isOpened(self) -> bool:
        """Whether the camera is there."""
        return self._camera is not None

    def grab(self) -> bool:
        """Wait for the next frame; False when none comes for two seconds."""
        self._give_back()
        give_up_s = self._clock.now() + READ_TIMEOUT_S
        frame = c.POINTER(_VideoFrame)()
        while self._clock.now() < give_up_s:
            self._call("capture_dequeue", self._camera, _POLICY_POLL, c.byref(frame))
            if frame:
                self._frame = frame
                self._stamp_s = self._stamp(frame.contents.timestamp)
                return True
            self._clock.sleep_until(self._clock.now() + _POLL_S)
        return False

    def _stamp(self, unix_us: int) -> float:
        """Return the time stamp of a frame in s, as if the computer's clock had not been set since.

        Else the frames would seem to have come an hour apart.
        """
        return unix_us / 1e6 - (_to_time_of_day_s() - self._to_time_of_day_s)

    def retrieve(self) -> tuple[bool, npt.NDArray[np.uint8] | None]:
        """Return a copy of the frame last grabbed."""
        if self._frame is None:
            return False, None
        frame = self._frame.contents
        columns, rows = frame.size[0], frame.size[1]
        raw = np.ctypeslib.as_array(frame.image, shape=(rows, max(frame.stride, columns)))
        return True, raw[:, :columns].copy()

    def read(self) -> tuple[bool, npt.NDArray[np.uint8] | None]:
        """`grab` and `retrieve`."""
        return self.retrieve() if self.grab() else (False, None)

    def get(self, prop: int) -> float:
        """Return one of the few properties that a camera is asked for."""
        if prop == POS_MSEC and self._frame is not None:
            return 1e3 * self._stamp_s
        return {WIDTH: float(_SIZE[0]), HEIGHT: float(_SIZE[1]), FPS: self._rate_hz}.get(prop, 0.0)

    def set(self, prop: int, value: float) -> bool:
        """Nothing can be set: frames are grey and raw already."""
        del prop, value
        return False

    def identity(self) -> DeviceIdentity:
        """Return maker and model as the camera's own memory has them; its GUID is its serial."""
        known = c.cast(self._camera, c.POINTER(_Camera)).contents
        return DeviceIdentity(
            name=_name(known.guid),
            maker=_text(known.vendor),
            product=_text(known.model),
            serial=f"{known.guid:016x}",
            driver="libdc1394",
            is_simulated=False,
        )

    def release(self) -> None:
        """Stop the camera and let go of it. May be called twice."""
        if self._camera is not None:
            self._give_back()
            if self._transmitting:
                self._lib.dc1394_video_set_transmission(self._camera, _OFF)
                self._lib.dc1394_capture_stop(self._camera)
                self._transmitting = False
            self._lib.dc1394_camera_free(self._camera)
            self._camera = None
        if self._bus:
            self._lib.dc1394_free(self._bus)
            self._bus = None

    def _take(self, guid: int | None) -> Any:
        there = self._guids()
        wanted = there[0] if guid is None and there else guid
        if wanted not in there:
            found = ", ".join(f"iidc:{number:016x}" for number in there) or "none"
            raise DeviceNotFoundError(
                f"[camera] source: no IIDC camera {_name(guid)} on the FireWire bus; found: {found}"
            )
        camera = self._lib.dc1394_camera_new(self._bus, wanted)
        if not camera:
            raise DeviceNotFoundError(
                f"the IIDC camera {_name(wanted)} cannot be opened; another program uses it"
            )
        return camera

    def _guids(self) -> list[int]:
        cameras = c.POINTER(_CameraList)()
        self._call("camera_enumerate", self._bus, c.byref(cameras))
        try:
            return [int(cameras.contents.ids[i].guid) for i in range(cameras.contents.num)]
        finally:
            self._lib.dc1394_camera_free_list(cameras)

    def _begin(self) -> None:
        fast = self._lib.dc1394_video_set_operation_mode(self._camera, _OPERATION_1394B)
        if fast == _SUCCESS:
            self._call("video_set_iso_speed", self._camera, _ISO_SPEED_800)
        else:  # a camera of the first FireWire
            self._call("video_set_iso_speed", self._camera, _ISO_SPEED_400)
        self._call("video_set_mode", self._camera, _MODE_640x480_MONO8)
        self._call("video_set_framerate", self._camera, _FRAMERATES[self._rate_hz])
        self._call("capture_setup", self._camera, _DMA_BUFFERS, _CAPTURE_DEFAULT)
        self._transmitting = True
        self._call("video_set_transmission", self._camera, _ON)

    def _give_back(self) -> None:
        if self._frame is not None:
            frame, self._frame = self._frame, None
            self._lib.dc1394_capture_enqueue(self._camera, frame)

    def _call(self, function: str, *arguments: Any) -> None:
        code = getattr(self._lib, f"dc1394_{function}")(*arguments)
        if code != _SUCCESS:
            words = self._lib.dc1394_error_get_string(code) or b"unknown error"
            raise DeviceError(
                f"the IIDC camera refused {function}: {words.decode(errors='replace')} "
                f"(libdc1394 {code})"
            )


def iidc_guid(source: str) -> int | None:
    """Return the number in `iidc:GUID` (16 hexadecimal digits); None for `iidc:`, the first."""
    digits = source.removeprefix("iidc:").removeprefix("0x")
    if not digits:
        return None
    try:
        return int(digits, 16)
    except ValueError:
        raise DeviceNotFoundError(
            f"[camera] source = {source}: after iidc: belongs the camera's GUID, 16 hexadecimal "
            "digits"
        ) from None


def _text(raw: bytes | None) -> str:
    """Return a text from the camera's memory in printable characters."""
    text = (raw or b"").decode("ascii", errors="replace").strip()
    return text if text.isprintable() else repr(text)


def _name(guid: int | None) -> str:
    return "of any number" if guid is None else f"{guid:016x}"


def _load(library: str | None) -> Any:
    path = library or ctypes.util.find_library("dc1394")
    try:
        if path is None:
            raise OSError("not found")
        lib = c.CDLL(path)
        return _declare(lib)
    except (OSError, AttributeError) as fault:
        raise DeviceNotFoundError(
            f"libdc1394 (version 2) cannot be loaded ({fault}): install it (on Debian: "
            "apt install libdc1394-25), or use another kind of [camera] source"
        ) from fault


def _declare(lib: Any) -> Any:
    """Pointers must be declared: ctypes would cut them to 32 bits."""
    pointer, frame = c.c_void_p, c.POINTER(_VideoFrame)
    signatures: dict[str, tuple[Any, list[Any]]] = {
        "new": (pointer, []),
        "free": (None, [pointer]),
        "camera_enumerate": (c.c_int, [pointer, c.POINTER(c.POINTER(_CameraList))]),
        "camera_free_list": (None, [c.POINTER(_CameraList)]),
        "camera_new": (pointer, [pointer, c.c_uint64]),
        "camera_free": (None, [pointer]),
        "video_set_operation_mode": (c.c_int, [pointer, c.c_int]),
        "video_set_iso_speed": (c.c_int, [pointer, c.c_int]),
        "video_set_mode": (c.c_int, [pointer, c.c_int]),
        "video_set_framerate": (c.c_int, [pointer, c.c_int]),
        "video_set_transmission": (c.c_int, [pointer, c.c_int]),
        "capture_setup": (c.c_int, [pointer, c.c_uint32, c.c_uint32]),
        "capture_stop": (c.c_int, [pointer]),
        "capture_dequeue": (c.c_int, [pointer, c.c_int, c.POINTER(frame)]),
        "capture_enqueue": (c.c_int, [pointer, frame]),
        "error_get_string": (c.c_char_p, [c.c_int]),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(lib, f"dc1394_{name}")
        function.restype, function.argtypes = result, arguments
    return lib


def _make(settings: CameraSettings, clock: Clock, rate_hz: float) -> Camera:
    def capture(source: str) -> IidcCapture:
        return IidcCapture(iidc_guid(source), clock, rate_hz)

    return CaptureCamera(settings.source, clock, capture)


CAMERA = CameraKind(
    kind="iidc",
    help="FireWire cameras on libdc1394: iidc:GUID, or iidc: for the first one",
    prefix="iidc:",
    make=_make,
)
