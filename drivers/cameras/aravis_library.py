"""libaravis, loaded when it is used: its functions by ctypes, its errors as DeviceError.

Numbers and structures are those of the headers of Aravis 0.8.
"""

from __future__ import annotations

import ctypes as c
import ctypes.util
import sys
from collections.abc import Callable
from functools import lru_cache
from typing import Any

from drivers.interfaces import DeviceError, DeviceNotFoundError

SUCCESS = 0  # status of a whole buffer
NO_PACKET_SOCKET = 1  # stream option: packets by the socket of any program, not a raw one
_FIXED_BUFFER = 0
SOCKET_BYTES = 4 << 20
_RETENTION_US = 200_000  # how long the missing part of a frame is waited for
_G_TYPE_INT = 6 << 2
_P, _S, _I, _D = c.c_void_p, c.c_char_p, c.c_int, c.c_double


class _Error(c.Structure):
    _fields_ = (("domain", c.c_uint32), ("code", c.c_int), ("message", c.c_char_p))


class _Value(c.Structure):
    """GValue."""

    _fields_ = (("type", c.c_size_t), ("data", c.c_uint64 * 2))


_ErrorRef = c.POINTER(c.POINTER(_Error))
# name -> (result, arguments); those of _FAILING have a GError ** behind these
_FUNCTIONS: dict[str, tuple[Any, list[Any]]] = {
    "update_device_list": (None, []),
    "get_n_devices": (c.c_uint, []),
    "get_device_id": (_S, [c.c_uint]),
    "get_device_vendor": (_S, [c.c_uint]),
    "get_device_model": (_S, [c.c_uint]),
    "get_device_serial_nbr": (_S, [c.c_uint]),
    "get_device_protocol": (_S, [c.c_uint]),
    "get_device_address": (_S, [c.c_uint]),
    "get_major_version": (c.c_uint, []),
    "get_minor_version": (c.c_uint, []),
    "get_micro_version": (c.c_uint, []),
    "camera_get_device": (_P, [_P]),
    "camera_gv_set_stream_options": (None, [_P, c.c_uint]),
    "camera_is_gv_device": (_I, [_P]),
    "buffer_new_allocate": (_P, [c.c_size_t]),
    "buffer_get_status": (_I, [_P]),
    "buffer_get_data": (_P, [_P, c.POINTER(c.c_size_t)]),
    "buffer_get_frame_id": (c.c_uint64, [_P]),
    "buffer_set_frame_id": (None, [_P, c.c_uint64]),
    "buffer_get_timestamp": (c.c_uint64, [_P]),
    "buffer_get_system_timestamp": (c.c_uint64, [_P]),
    "buffer_get_image_width": (_I, [_P]),
    "buffer_get_image_height": (_I, [_P]),
    "stream_push_buffer": (None, [_P, _P]),
    "stream_timeout_pop_buffer": (_P, [_P, c.c_uint64]),
    "stream_get_info_uint64_by_name": (c.c_uint64, [_P, _S]),
    "stream_stop_thread": (c.c_uint, [_P, _I]),
}
_FAILING: dict[str, tuple[Any, list[Any]]] = {
    "camera_new": (_P, [_S]),
    "camera_get_vendor_name": (_S, [_P]),
    "camera_get_model_name": (_S, [_P]),
    "camera_get_device_serial_number": (_S, [_P]),
    "camera_get_payload": (c.c_uint, [_P]),
    "camera_create_stream": (_P, [_P, _P, _P]),
    "camera_start_acquisition": (None, [_P]),
    "camera_stop_acquisition": (None, [_P]),
    "camera_gv_auto_packet_size": (c.c_uint, [_P]),
    "device_is_feature_available": (_I, [_P, _S]),
    "device_get_integer_feature_value": (c.c_int64, [_P, _S]),
    "device_set_integer_feature_value": (None, [_P, _S, c.c_int64]),
    "device_get_integer_feature_bounds": (
        None,
        [_P, _S, c.POINTER(c.c_int64), c.POINTER(c.c_int64)],
    ),
    "device_get_float_feature_value": (_D, [_P, _S]),
    "device_set_float_feature_value": (None, [_P, _S, _D]),
    "device_get_float_feature_bounds": (None, [_P, _S, c.POINTER(_D), c.POINTER(_D)]),
    "device_get_string_feature_value": (_S, [_P, _S]),
    "device_set_string_feature_value": (None, [_P, _S, _S]),
    "device_set_boolean_feature_value": (None, [_P, _S, _I]),
    "device_dup_available_enumeration_feature_values_as_strings": (
        c.POINTER(_S),
        [_P, _S, c.POINTER(c.c_uint)],
    ),
    "device_execute_command": (None, [_P, _S]),
}


class Aravis:
    """The functions of libaravis by their names without `arv_`."""

    def __init__(self, aravis: Any, gobject: Any, glib: Any) -> None:
        self._glib, self._gobject = glib, gobject
        self._calls: dict[str, Any] = {}
        for name, (result, arguments) in _FUNCTIONS.items():
            self._calls[name] = _declared(aravis, f"arv_{name}", result, arguments)
        for name, (result, arguments) in _FAILING.items():
            self._calls[name] = _declared(aravis, f"arv_{name}", result, [*arguments, _ErrorRef])
        self._unref = _declared(gobject, "g_object_unref", None, [_P])
        self._free = _declared(glib, "g_free", None, [_P])
        self._free_error = _declared(glib, "g_error_free", None, [c.POINTER(_Error)])
        self.node_type = {
            _declared(aravis, f"arv_gc_{kind}_get_type", c.c_size_t, [])(): kind
            for kind in ("integer", "float")
        }
        self._is_a = _declared(
            gobject, "g_type_check_instance_is_a", c.c_int, [c.c_void_p, c.c_size_t]
        )
        self._feature = _declared(aravis, "arv_device_get_feature", _P, [_P, _S])

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Return a function that cannot fail."""
        found: Callable[..., Any] = self._calls[name]
        return found

    def call(self, doing: str, name: str, *arguments: Any) -> Any:
        """Call a function that can fail. Raises DeviceError, which begins with `doing`."""
        error = c.POINTER(_Error)()
        result = self._calls[name](*arguments, c.byref(error))
        if error:
            words = text(error.contents.message)
            self._free_error(error)
            raise DeviceError(f"{doing} failed: {words}")
        return result

    def strings(self, doing: str, name: str, *arguments: Any) -> list[str]:
        """Return what a function lists, each text still owned by the camera's description."""
        count = c.c_uint()
        found = self.call(doing, name, *arguments, c.byref(count))
        try:
            return [text(found[k]) for k in range(count.value)] if found else []
        finally:
            if found:
                self._free(c.cast(found, _P))

    def is_whole(self, device: Any, feature: bytes) -> bool:
        """Whether a feature is an integer by its description."""
        node = self._feature(device, feature)
        kinds = {kind: number for number, kind in self.node_type.items()}
        is_float = bool(node) and bool(self._is_a(node, kinds["float"]))
        return bool(node) and not is_float and bool(self._is_a(node, kinds["integer"]))

    def release(self, thing: Any) -> None:
        """Let go of an object."""
        if thing:
            self._unref(thing)

    def set_network_stream(self, stream: Any) -> None:
        """Give a GigE stream a socket buffer of 4 MB (the system may allow less), and patience."""
        wanted = {
            "socket-buffer": _FIXED_BUFFER,
            "socket-buffer-size": SOCKET_BYTES,
            "frame-retention": _RETENTION_US,
        }
        for name, value in wanted.items():
            held = _Value()
            self._gobject.g_value_init.restype = _P
            self._gobject.g_value_init(c.byref(held), c.c_size_t(_G_TYPE_INT))
            self._gobject.g_value_set_int(c.byref(held), c.c_int(value))
            self._gobject.g_object_set_property(_P(stream), name.encode(), c.byref(held))
            self._gobject.g_value_unset(c.byref(held))


def text(raw: bytes | None) -> str:
    """Return a text of the library's in printable characters."""
    found = (raw or b"").decode("utf-8", errors="replace").strip()
    return found if found.isprintable() else repr(found)


def _declared(library: Any, name: str, result: Any, arguments: list[Any]) -> Any:
    """Pointers must be declared: ctypes would cut them to 32 bits."""
    function = getattr(library, name)
    function.restype, function.argtypes = result, arguments
    return function


@lru_cache(maxsize=1)
def load() -> Aravis:
    """Return the library, loaded once. Raises DeviceNotFoundError."""
    try:
        return Aravis(*(c.CDLL(_path(name)) for name in ("aravis-0.8", "gobject-2.0", "glib-2.0")))
    except (OSError, AttributeError) as fault:
        raise DeviceNotFoundError(
            f"libaravis 0.8 cannot be loaded ({fault}): install it (on Debian: apt install "
            "libaravis-0.8-0), or use another kind of [camera] source"
        ) from fault


def _path(name: str) -> str:
    found = ctypes.util.find_library(name)
    if found is not None:
        return found
    return f"lib{name}-0.dll" if sys.platform == "win32" else f"lib{name}.so.0"
