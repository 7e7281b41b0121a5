"""The features that GenICam cameras have in common: set from rig.toml, and read back.

Aravis and GenTL reach the same features by the same names (SFNC). A camera that lacks one, or
cannot take the value, is told in one sentence; nothing is silently left as it was.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from drivers.cameras.pixel_formats import PixelFormat, pixel_format
from drivers.interfaces import FREE, HARDWARE, SOFTWARE, AcquisitionSettings, DeviceError

# of each setting the names that cameras give it, the standard one first
_EXPOSURE = ("ExposureTime", "ExposureTimeAbs")
_GAIN = ("Gain", "GainAbs", "GainRaw")
_FRAME_RATE = ("AcquisitionFrameRate", "AcquisitionFrameRateAbs")
_PIXEL_FORMAT = "PixelFormat"
_US_PER_S = 1e6
_RATE_SWITCH = "AcquisitionFrameRateEnable"

# What `labrig init --camera` writes into rig.toml for each kind of them.
STARTER_SETTINGS = """\
exposure_s = 0.005
# gain = 6.0                       # in the camera's unit, dB on most
# pixel_format = "Mono8"           # Mono8 to Mono16, plain or packed, or BayerRG8 and its like
region = [0, 0, 640, 480]          # left, top, width, height in pixels
# trigger = "hardware"             # the boards begin each exposure, by a wire from ...
# trigger_line = "LINE"            # ... this line of the boards ...
# trigger_input = "Line0"          # ... to this input of the camera
"""
SIMULATED_SETTINGS = """\
source = "simulated"
optics = "optics.json"
exposure_s = 0.005                 # of a frame
# trigger = "hardware"             # the boards begin each exposure, by a wire from ...
# trigger_line = "LINE"            # ... this line of the boards
"""


class Features(Protocol):
    """A camera's features by name. Everything raises DeviceError and nothing else."""

    def has(self, name: str) -> bool:
        """Whether there is such a feature now."""

    def number(self, name: str) -> float:
        """Return the value of a number."""

    def set_number(self, name: str, value: float) -> None:
        """Set a number."""

    def bounds(self, name: str) -> tuple[float, float]:
        """Return the smallest and largest value that it takes now."""

    def choice(self, name: str) -> str:
        """Return the value of an enumeration."""

    def set_choice(self, name: str, value: str) -> None:
        """Set an enumeration."""

    def choices(self, name: str) -> Sequence[str]:
        """Return the values that it takes now."""

    def switch_on(self, name: str) -> None:
        """Switch a feature on."""


class GenicamSetter:
    """Sets the features of one camera. `camera`: its name in the sentences."""

    def __init__(self, features: Features, camera: str) -> None:
        self._features = features
        self._camera = camera

    def apply(self, wanted: AcquisitionSettings, rate_hz: float, line: str) -> None:
        """Set what is wanted, and what must not be left to chance. Raises DeviceError.

        `rate_hz`: the rate of a free camera where none is wanted. `line`: the camera's input for a
        hardware trigger.
        """
        self._choose_if_there("AcquisitionMode", "Continuous")
        if wanted.region is not None:
            self._set_region(wanted.region)
        self._set_pixel_format(wanted.pixel_format)
        if wanted.exposure_s is not None:
            self._choose_if_there("ExposureAuto", "Off")
            self._choose_if_there("ExposureMode", "Timed")
            self._set("exposure_s", _EXPOSURE, wanted.exposure_s, _US_PER_S)
        if wanted.gain is not None:
            self._choose_if_there("GainAuto", "Off")
            self._set("gain", _GAIN, wanted.gain)
        trigger = wanted.trigger or FREE
        self._set_trigger(trigger, line)
        if trigger == FREE:
            self._set_rate(wanted.frame_rate_hz, rate_hz)

    def _name_of(self, names: Sequence[str]) -> str | None:
        return next((name for name in names if self._features.has(name)), None)

    def _choose_if_there(self, name: str, value: str) -> None:
        features = self._features
        if features.has(name) and value in features.choices(name):
            self._choose(name, value)

    def _choose(self, name: str, value: str) -> None:
        """Set an enumeration, unless it is so already: some cannot be written at all."""
        if self._features.choice(name) != value:
            self._features.set_choice(name, value)

    def _lacks(self, key: str) -> DeviceError:
        return DeviceError(
            f"the camera {self._camera} has no setting for [camera] {key}; remove the key from "
            "rig.toml"
        )

    def _set(self, key: str, names: Sequence[str], value: float, scale: float = 1.0) -> None:
        """Set a number that rig.toml has in another unit, `scale` of the camera's to one of it."""
        name = self._name_of(names)
        if name is None:
            raise self._lacks(key)
        low, high = self._features.bounds(name)
        if not low <= value * scale <= high:
            raise DeviceError(
                f"the camera {self._camera} takes [camera] {key} from {low / scale:g} to "
                f"{high / scale:g}, not {value:g}"
            )
        self._features.set_number(name, value * scale)

    def _set_region(self, region: tuple[int, int, int, int]) -> None:
        features = self._features
        left, top, width, height = region
        corner = [name for name in ("OffsetX", "OffsetY") if features.has(name)]
        for name in corner:  # an old corner would limit the size
            features.set_number(name, 0)
        wanted = {"Width": width, "Height": height, "OffsetX": left, "OffsetY": top}
        for name, value in wanted.items():
            if name in corner or name in ("Width", "Height"):
                self._set(f"region's {name}", [name], value)
        found = {name: int(features.number(name)) if features.has(name) else 0 for name in wanted}
        if found != wanted:
            got = [found[name] for name in ("OffsetX", "OffsetY", "Width", "Height")]
            raise DeviceError(
                f"the camera {self._camera} cannot take [camera] region = {list(region)}; the "
                f"nearest that it takes is {got}"
            )

    def _set_pixel_format(self, name: str | None) -> None:
        features = self._features
        offered = list(features.choices(_PIXEL_FORMAT))
        possible = [each for each in offered if pixel_format(each) is not None]
        if name is None:
            if pixel_format(features.choice(_PIXEL_FORMAT)) is not None or not possible:
                return
            name = "Mono8" if "Mono8" in possible else possible[0]
        if name not in offered:
            there = ", ".join(possible) or "none that can be made grey"
            raise DeviceError(
                f"the camera {self._camera} has no [camera] pixel_format {name}; it has {there}"
            )
        self._choose(_PIXEL_FORMAT, name)

    def _set_rate(self, wanted_hz: float | None, rate_hz: float) -> None:
        """Set the rate; one that only the protocol asks for is left where it cannot be set."""
        name = self._name_of(_FRAME_RATE)
        if name is None and wanted_hz is None:
            return
        if self._features.has(_RATE_SWITCH):
            self._features.switch_on(_RATE_SWITCH)
        self._set("frame_rate_hz", _FRAME_RATE, rate_hz if wanted_hz is None else wanted_hz)

    def _set_trigger(self, trigger: str, line: str) -> None:
        features = self._features
        if not features.has("TriggerMode"):
            if trigger == FREE:
                return
            raise self._lacks("trigger")
        if features.has("TriggerSelector"):
            for selector in features.choices("TriggerSelector"):
                self._choose("TriggerSelector", selector)
                self._choose("TriggerMode", "Off")
            self._choose_if_there("TriggerSelector", "FrameStart")
        if trigger == FREE:
            self._choose("TriggerMode", "Off")
            return
        source = "Software" if trigger == SOFTWARE else line
        offered = list(features.choices("TriggerSource"))
        if source not in offered:
            key = "trigger" if trigger == SOFTWARE else "trigger_input"
            raise DeviceError(
                f"the camera {self._camera} has no trigger source {source} ([camera] {key}); it "
                f"has {', '.join(offered)}"
            )
        self._choose("TriggerSource", source)
        self._choose_if_there("TriggerActivation", "RisingEdge")
        self._choose("TriggerMode", "On")


def read_back(features: Features) -> AcquisitionSettings:
    """Return what the camera has set; None for what it does not have. Raises DeviceError."""

    def of(names: Sequence[str], scale: float = 1.0) -> float | None:
        found = [name for name in names if features.has(name)]
        return features.number(found[0]) / scale if found else None

    def pixels(name: str) -> int:
        return int(features.number(name)) if features.has(name) else 0

    trigger = FREE
    if features.has("TriggerMode") and features.choice("TriggerMode") == "On":
        trigger = SOFTWARE if features.choice("TriggerSource") == "Software" else HARDWARE
    return AcquisitionSettings(
        exposure_s=of(_EXPOSURE, _US_PER_S),
        gain=of(_GAIN),
        pixel_format=features.choice(_PIXEL_FORMAT),
        region=(pixels("OffsetX"), pixels("OffsetY"), pixels("Width"), pixels("Height")),
        frame_rate_hz=of(_FRAME_RATE) if trigger == FREE else None,
        trigger=trigger,
    )


def format_of(settings: AcquisitionSettings, camera: str) -> PixelFormat:
    """Return the pixel format that was read back. Raises DeviceError for one that is not grey."""
    found = pixel_format(settings.pixel_format or "")
    if found is None:
        raise DeviceError(
            f"the camera {camera} sends {settings.pixel_format} pixels, which cannot be made grey; "
            "set [camera] pixel_format"
        )
    return found
