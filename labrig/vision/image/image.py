"""An image prepared for the fit: grey floats, their noise, and the sheet's plane at every pixel."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import ColourChannel, Optics
from labrig.vision.image.colour_notes import GREY_USED
from labrig.vision.thresholds import (
    IMAGE_SIDE_MIN_PX,
    LEVEL_RANGE_MAX_SIGMAS,
    LEVEL_RANGE_MIN_RATIO,
    UNIT_RANGE_MARGIN,
)

FloatArray = npt.NDArray[np.float64]
MapArray = npt.NDArray[np.float32]

SMOOTHING_PX = 1.0


class ImageError(ValueError):
    """The image cannot hold a curve; the text is the sentence for the user."""


@dataclass(frozen=True, eq=False, kw_only=True)
class GreyImage:
    """A grey image. `noise` is one pixel's standard deviation in grey levels."""

    grey: MapArray
    noise: float
    full_scale: float
    clipped: float  # share of the pixels at full scale
    warnings: tuple[str, ...]
    downscaling: float = 1  # times, against the camera's
    full_resolution: MapArray | None = None  # the camera's own, of a downscaled image

    @cached_property
    def smooth(self) -> MapArray:
        """Smoothed with a Gaussian of one pixel, for finding ridges."""
        import cv2

        return np.asarray(cv2.GaussianBlur(self.grey, (0, 0), SMOOTHING_PX), dtype=np.float32)

    @cached_property
    def ridge_unit(self) -> float:
        """Grey levels in which ridges are measured: noise, or texture where there is hardly any."""
        return max(self.noise, 0.01 * float(np.ptp(self.grey)))

    def without(self, mask: npt.NDArray[np.uint8]) -> GreyImage:
        """Return the image with NaN where a mask (rows, columns) is not 0."""
        return replace(self, grey=np.where(mask > 0, np.float32("nan"), self.grey))

    def filled(self) -> GreyImage:
        """Return the image with its usual grey where it has none."""
        there = np.isfinite(self.grey)
        if there.all():
            return self
        usual = np.float32(np.median(self.grey[there]))
        return replace(self, grey=np.where(there, self.grey, usual))


def in_levels(image: npt.NDArray[Any], optics: Optics) -> npt.NDArray[Any]:
    """Return floats of 0 to 1, as other programs write them, in levels of the camera."""
    if image.dtype.kind != "f":
        return image
    if image.ndim == 3 and image.shape[2] == 4:  # how transparent it is has no levels
        image = on_white(image)
    low, high = float(image.min()), float(image.max())  # a NaN is in no range
    if low >= -UNIT_RANGE_MARGIN and high <= 1 + UNIT_RANGE_MARGIN:
        return np.asarray(image * (2**optics.bits - 1))
    return image


def read_grey_image(image: npt.NDArray[Any], optics: Optics) -> GreyImage:
    """Check an image and turn it into floats; colour is turned into grey with a warning."""
    if isinstance(image, np.ndarray):  # FITS, and some TIFF, have the bytes the other way round
        image = image.astype(image.dtype.newbyteorder("="), copy=False)
    grey, warnings = _grey(image, optics.channel)
    rows, columns = grey.shape
    if min(rows, columns) < IMAGE_SIDE_MIN_PX:
        raise ImageError(f"the image is only {columns} x {rows} pixels; a sheet needs more.")
    if optics.image_size is not None and optics.image_size != (columns, rows):
        raise ImageError(
            f"the image is {columns} x {rows} pixels but the optics were calibrated for "
            f"{optics.image_size[0]} x {optics.image_size[1]}; calibrate this camera setting."
        )
    full_scale = _full_scale(image, optics)
    clipped = float(np.mean(grey >= full_scale))
    noise = pixel_noise(grey, full_scale)
    low, high = float(grey.min()), float(grey.max())
    # a camera of ten bits leaves most of sixteen empty: what little there is may show all
    if high - low < min(LEVEL_RANGE_MIN_RATIO * full_scale, LEVEL_RANGE_MAX_SIGMAS * noise):
        floats = f"multiply floats from 0 to 1 by {full_scale:g}, or "
        raise ImageError(
            f"the image is uniform (levels {low:g} to {high:g} of {full_scale:g}); "
            f"{floats if image.dtype.kind == 'f' and high <= 1 + UNIT_RANGE_MARGIN else ''}"
            "check lens cap, light and exposure."
        )
    return GreyImage(
        grey=grey, noise=noise, full_scale=full_scale, clipped=clipped, warnings=tuple(warnings)
    )


def _grey(image: npt.NDArray[Any], channel: ColourChannel) -> tuple[MapArray, list[str]]:
    if not isinstance(image, np.ndarray) or image.size == 0:
        raise ImageError("this is not an image: an array of pixels is needed.")
    if image.dtype not in (np.uint8, np.uint16, np.float32, np.float64):
        raise ImageError(
            f"the image holds {image.dtype} values; save it with 8 or 16 bits, or as floats."
        )
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]
    if image.ndim == 3 and image.shape[2] == 4:
        image = on_white(image)
    if image.ndim == 3 and image.shape[2] == 3:
        if (image[:, :, 0] == image[:, :, 1]).all() and (image[:, :, 1] == image[:, :, 2]).all():
            return np.ascontiguousarray(image[:, :, 0], dtype=np.float32), []
        return _of_channel(image, channel)
    if image.ndim != 2:
        raise ImageError(f"the image has shape {image.shape}; rows and columns are needed.")
    grey = np.ascontiguousarray(image, dtype=np.float32)
    if image.dtype.kind == "f" and not np.isfinite(grey).all():
        raise ImageError("the image holds values that are not finite.")
    return grey, []


def on_white(image: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the colours of an image with transparent parts, as they look on white paper.

    image: (rows, columns, 4), integers, or floats from 0 to 1; the last channel is alpha. One that
    is the same everywhere says nothing, and the colours are as they are.
    """
    colours, cover = image[:, :, :3], image[:, :, 3:]
    top = float(np.iinfo(image.dtype).max) if image.dtype.kind == "u" else 1.0
    if (cover == cover.max()).all():
        return colours
    share = cover.astype(np.float64) / top
    blended = top - share * (top - colours)
    whole = np.rint(blended) if image.dtype.kind == "u" else blended
    return np.asarray(whole).astype(image.dtype)


def in_colours(image: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return (rows, columns, 3) of an image of any shape that one may have; grey thrice."""
    if image.ndim == 2:
        image = image[:, :, None]
    if image.shape[2] == 4:
        image = on_white(image)
    return np.repeat(image, 3, axis=2) if image.shape[2] == 1 else image


def is_coloured(image: npt.NDArray[Any]) -> bool:
    """Return whether an image has colours, and so channels that differ."""
    if image.ndim != 3 or image.shape[2] not in (3, 4):
        return False
    return bool((image[:, :, :1] != image[:, :, 1:3]).any())


def _of_channel(image: npt.NDArray[Any], channel: ColourChannel) -> tuple[MapArray, list[str]]:
    """Return one channel of a colour image, and what is said of it."""
    # OpenCV's order: blue, green, red
    weights = np.array(_CHANNEL_WEIGHTS[channel], np.float32)
    values = image[:, :, :3].astype(np.float32) @ weights
    if channel in (ColourChannel.AUTO, ColourChannel.GREY):
        return np.ascontiguousarray(values), [GREY_USED]
    if weights.sum() == 0:  # a difference may be negative: half of it, around the middle
        top = float(np.iinfo(image.dtype).max) if image.dtype.kind == "u" else 0.0
        values = 0.5 * (values + top)
    return np.ascontiguousarray(values), []


_CHANNEL_WEIGHTS = {
    ColourChannel.AUTO: (0.114, 0.587, 0.299),
    ColourChannel.GREY: (0.114, 0.587, 0.299),
    ColourChannel.RED: (0.0, 0.0, 1.0),
    ColourChannel.GREEN: (0.0, 1.0, 0.0),
    ColourChannel.BLUE: (1.0, 0.0, 0.0),
    ColourChannel.RED_GREEN: (0.0, -1.0, 1.0),
    ColourChannel.RED_BLUE: (-1.0, 0.0, 1.0),
    ColourChannel.GREEN_BLUE: (-1.0, 1.0, 0.0),
}


def _full_scale(image: npt.NDArray[Any], optics: Optics) -> float:
    if image.dtype == np.uint8:
        return 255.0
    if image.dtype == np.uint16:
        return float(2 ** (optics.bits if optics.bits > 8 else 16) - 1)
    return float(2**optics.bits - 1)


def pixel_noise(grey: MapArray, full_scale: float) -> float:
    """Return one pixel's noise, from second differences, which are blind to ramps and edges.

    At least a third of an 8-bit level, so that a flawless synthetic image has a scale too.
    """
    part = grey[::4] if grey.size > 100_000 else grey
    d = part[:, 2::3] - 2 * part[:, 1:-1:3] + part[:, :-2:3]
    spread = float(np.median(np.abs(d))) / 0.6745
    return max(spread / 6**0.5, full_scale / 255 * 0.3 if full_scale < 300 else 0.3)


@lru_cache(maxsize=8)
def plane_map(optics: Optics, shape: tuple[int, int]) -> MapArray:
    """Return (rows, columns, 2).

    Each pixel's place in the sheet's plane, world times px_per_m, y up.
    """
    rows, columns = shape
    if not optics.has_lens and optics.homography is None:
        return _affine(optics, shape)
    # the lens is smooth: every fourth pixel, linear between, is good to 0.002 pixels
    step = 4
    v = np.arange(0, rows + step, step, dtype=float)
    u = np.arange(0, columns + step, step, dtype=float)
    grid = np.stack(np.meshgrid(u, v), axis=-1)
    coarse = (optics.pixel_to_world(grid.reshape(-1, 2)) * optics.px_per_m).reshape(grid.shape)
    wv, wu = _linear_weights(rows, v), _linear_weights(columns, u)
    out = np.empty((rows, columns, 2), dtype=np.float32)
    for axis in range(2):
        out[:, :, axis] = wv @ coarse[:, :, axis] @ wu.T
    return out


def _affine(optics: Optics, shape: tuple[int, int]) -> MapArray:
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    origin, right, down = optics.pixel_to_world(corners) * optics.px_per_m
    v = np.arange(shape[0])[:, None, None]
    u = np.arange(shape[1])[None, :, None]
    return np.ascontiguousarray(
        origin + u * (right - origin) + v * (down - origin), dtype=np.float32
    )


def _linear_weights(count: int, nodes: FloatArray) -> FloatArray:
    at = np.arange(count)
    cell = np.minimum(at // 4, len(nodes) - 2)
    part = (at - nodes[cell]) / 4
    weights = np.zeros((count, len(nodes)))
    weights[at, cell] = 1 - part
    weights[at, cell + 1] = part
    return weights
