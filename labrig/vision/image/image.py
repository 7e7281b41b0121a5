"""An image as the fit wants it: grey floats, its noise, and the sheet's plane at every pixel."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.thresholds import (
    IMAGE_SIDE_MIN_PX,
    LEVEL_RANGE_MAX_SIGMAS,
    LEVEL_RANGE_MIN_RATIO,
    SATURATED_SHARE_MAX,
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
    downscaling: int = 1  # times, against the camera's
    full_resolution: MapArray | None = None  # the camera's own, of a downscaled image

    @cached_property
    def smooth(self) -> MapArray:
        """Smoothed with a Gaussian of one pixel, for finding ridges."""
        import cv2

        return np.asarray(cv2.GaussianBlur(self.grey, (0, 0), SMOOTHING_PX), dtype=np.float32)


def in_levels(image: npt.NDArray[Any], optics: Optics) -> npt.NDArray[Any]:
    """Return floats of 0 to 1, as other programs write them, in levels of the camera."""
    if image.dtype.kind != "f":
        return image
    low, high = float(image.min()), float(image.max())  # a NaN is in no range
    if low >= -UNIT_RANGE_MARGIN and high <= 1 + UNIT_RANGE_MARGIN:
        return np.asarray(image * (2**optics.bits - 1))
    return image


def read_grey_image(image: npt.NDArray[Any], optics: Optics) -> GreyImage:
    """Check an image and turn it into floats; colour is turned into grey with a warning."""
    grey, warnings = _grey(image)
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
    if clipped > SATURATED_SHARE_MAX:
        raise ImageError(
            f"the image is saturated ({clipped:.0%} of the pixels are at full scale); "
            "shorten the exposure."
        )
    noise = pixel_noise(grey, full_scale)
    low, high = float(grey.min()), float(grey.max())
    # a camera of ten bits leaves most of sixteen empty: what little there is may show all
    if high - low < min(LEVEL_RANGE_MIN_RATIO * full_scale, LEVEL_RANGE_MAX_SIGMAS * noise):
        raise ImageError(
            f"the image is uniform (levels {low:g} to {high:g} of {full_scale:g}); "
            "check lens cap, light and exposure."
        )
    return GreyImage(
        grey=grey, noise=noise, full_scale=full_scale, clipped=clipped, warnings=tuple(warnings)
    )


def _grey(image: npt.NDArray[Any]) -> tuple[MapArray, list[str]]:
    if not isinstance(image, np.ndarray) or image.size == 0:
        raise ImageError("this is not an image: an array of pixels is needed.")
    if image.dtype not in (np.uint8, np.uint16, np.float32, np.float64):
        raise ImageError(f"the image holds {image.dtype} values; 8 or 16 bit grey is needed.")
    if image.ndim == 3 and image.shape[2] == 1:
        image = image[:, :, 0]
    if image.ndim == 3 and image.shape[2] in (3, 4):
        if (image[:, :, 0] == image[:, :, 1]).all() and (image[:, :, 1] == image[:, :, 2]).all():
            return np.ascontiguousarray(image[:, :, 0], dtype=np.float32), []
        # OpenCV's order: blue, green, red
        grey = image[:, :, :3].astype(np.float32) @ np.array([0.114, 0.587, 0.299], np.float32)
        return np.ascontiguousarray(grey), ["the image is in colour; its grey values were used"]
    if image.ndim != 2:
        raise ImageError(f"the image has shape {image.shape}; rows and columns are needed.")
    grey = np.ascontiguousarray(image, dtype=np.float32)
    if image.dtype.kind == "f" and not np.isfinite(grey).all():
        raise ImageError("the image holds values that are not finite.")
    return grey, []


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
