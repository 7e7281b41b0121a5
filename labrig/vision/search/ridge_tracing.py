"""Find a first curve from nothing: ridge maps, path search from the clamp, a curve fit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import StripGeometry, smallness
from labrig.vision.curve.shape import CurveShape, ShapeBasis, fit_angles, make_shape
from labrig.vision.image.image import GreyImage
from labrig.vision.thresholds import CURVATURE_MAX_PER_M, TURN_MAX_RAD

FloatArray = npt.NDArray[np.float64]
MapArray = npt.NDArray[np.float32]
MaskArray = npt.NDArray[np.uint8]

ANGLE_NOISE_RAD = 0.02  # of a step of the beam


@dataclass(frozen=True, eq=False)
class Trace:
    """A path in raw pixels, and how ridge-like each of its steps was (-0.3 .. 1)."""

    path: FloatArray  # (steps + 1, 2)
    gains: FloatArray  # (steps,)
    score: float


@dataclass(frozen=True, eq=False)
class RidgeMaps:
    """The ridge maps of an image, bright ridges positive; `scale` reduces large images."""

    maps: MapArray  # (layers, 5, rows, columns), see path_search.ridge_score
    scale: int

    @contextmanager
    def without(self, path: FloatArray, radius: float) -> Iterator[None]:
        """Wipe out everything near a path (raw pixels) for a while; copies would take long."""
        import cv2

        mask = np.zeros(self.maps.shape[2:], np.uint8)
        points = np.round(((path + 0.5) / self.scale - 0.5) * 16).astype(np.int32)
        thickness = max(1, round(2 * radius / self.scale))
        cv2.polylines(
            mask,
            [points.reshape(-1, 1, 2)],
            isClosed=False,
            color=1,
            thickness=thickness,
            lineType=cv2.LINE_8,
            shift=4,
        )
        near = np.flatnonzero(mask.view(bool))
        pixels = self.maps.reshape(-1, mask.size)  # the same memory
        kept = pixels[:, near]
        pixels[:, near] = 0
        try:
            yield
        finally:
            pixels[:, near] = kept

    def raw(self, places: FloatArray) -> FloatArray:
        """Return raw pixels of places (..., 2) in the maps."""
        return (places + 0.5) * self.scale - 0.5

    def hide(self, mask: MaskArray) -> None:
        """Wipe out what a mask of the image hides."""
        rows, columns = self.maps.shape[2:]
        hidden = np.nonzero(mask[:: self.scale, :: self.scale][:rows, :columns])
        self.maps[:, :, hidden[0], hidden[1]] = 0


def ridge_maps(image: GreyImage, thickness_px: float, *, wide: bool) -> RidgeMaps:
    """Return second derivatives and slopes over their noise, at the sheet's width and wider."""
    import cv2

    scale = max(1, round(thickness_px / 2.5))
    grey, unit = image.grey, scale / image.ridge_unit
    if scale > 1:
        size = (grey.shape[1] // scale, grey.shape[0] // scale)
        grey = grey[: size[1] * scale, : size[0] * scale]
        grey = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
    grey = grey * np.float32(unit)
    narrow = max(1.2, 0.45 * thickness_px / scale)
    blurs = [narrow, 2.5 * narrow] if wide else [narrow]
    maps = np.empty((len(blurs), 5, *grey.shape), np.float32)
    for layer, blur in zip(maps, blurs, strict=True):
        _derivatives(grey, blur, layer)
    return RidgeMaps(maps, scale)


def _derivatives(grey: MapArray, blur: float, out: MapArray) -> None:
    """Fill in one layer (5, rows, columns) of the maps."""
    import cv2

    reach = math.ceil(3.2 * blur)
    t = np.arange(-reach, reach + 1) / blur
    g0 = np.exp(-t * t / 2)
    g0 /= g0.sum()
    g1, g2 = -t * g0 / blur, (t * t - 1) * g0 / blur**2
    unit = 1 / (np.linalg.norm(g0) * np.linalg.norm(g2))
    # filter2D correlates: an odd kernel is turned round
    kernels = (
        (g2 * unit, g0),
        (g1 * unit, g1),
        (g0 * unit, g2),
        (g1[::-1] * unit / blur, g0),
        (g0 * unit / blur, g1[::-1]),
    )
    for (across, down), plane in zip(kernels, out, strict=True):
        cv2.sepFilter2D(grey, cv2.CV_32F, across, down, dst=plane)


def trace_from_clamp(
    ridges: RidgeMaps,
    optics: Optics,
    strip: StripGeometry,
    sign: float,
    *,
    share: float = 1.0,
    offsets: tuple[float, ...] = (-2, -1, 0, 1, 2),
    width: int = 120,
) -> Trace | None:
    """Return the likeliest sheet from the clamp on.

    None when every path leaves what a sheet can do.

    `share` of the length is traced, with `width` states kept, from `offsets` beside the clamp in
    units of its uncertainty.
    """
    from labrig.vision.search.path_search import BEND_QUANTUM_RAD, search

    heading, local_scale = _clamp_direction(optics)
    scale = ridges.scale
    total = strip.length_m * optics.px_per_m * local_scale / scale
    steps = int(np.clip(round(total / 6), 12, 400))
    length = total / steps
    most = CURVATURE_MAX_PER_M * smallness(strip.length_m)
    most_bend = math.ceil(
        most / (optics.px_per_m * local_scale) * scale * length / BEND_QUANTUM_RAD
    )
    free_share = strip.free_length_m / strip.length_m
    u0, v0 = (np.array(optics.clamp_px) + 0.5) / scale - 0.5
    spread = np.array(
        [
            (step * optics.clamp_sigma_px / scale, turn * optics.clamp_angle_sigma_rad, 0.0)
            for step in offsets
            for turn in (-2, 0, 2)
        ]
    )
    bent_steps = max(1, math.ceil(free_share * steps))
    beam = search(
        ridges.maps,
        sign,
        place=(float(u0), float(v0)),
        heading=heading,
        spread=spread,
        steps=max(6, round(share * steps)),
        straight_from=bent_steps if free_share < 1 and strip.elongation_straight else steps,
        wide_from=steps if free_share >= 1 and ridges.maps.shape[0] == 1 else bent_steps % steps,
        length=length,
        most_bend=int(np.clip(most_bend, 3, 40)),
        most_turn=TURN_MAX_RAD,
        width=width,
        half=5.0,
    )
    path, gains = beam.best()
    if len(path) == 0:
        return None
    return Trace(ridges.raw(path), gains, float(gains.mean()))


def _clamp_direction(optics: Optics) -> tuple[float, float]:
    """Return angle of the clamped sheet in the raw image (u right, v down), and the scale there."""
    start = optics.clamp_m()
    a = optics.clamp_angle_rad
    step_m = 10 / optics.px_per_m
    ends = optics.world_to_pixel([start, start + step_m * np.array([math.cos(a), math.sin(a)])])
    du, dv = ends[1] - ends[0]
    return math.atan2(dv, du), math.hypot(du, dv) / 10


def shape_through(trace: Trace, optics: Optics, basis: ShapeBasis, spectral: float) -> CurveShape:
    """Return a smooth curve that follows a traced path."""
    nodes = optics.pixel_to_world(trace.path) * optics.px_per_m
    start = optics.clamp_m() * optics.px_per_m
    chord = np.diff(nodes, axis=0)
    lengths = np.hypot(chord[:, 0], chord[:, 1])
    phi = np.unwrap(np.arctan2(chord[:, 1], chord[:, 0]))
    heading = optics.clamp_angle_rad
    phi -= 2 * math.pi * round((phi[0] - heading) / (2 * math.pi))
    middle = np.cumsum(lengths) - lengths / 2
    at_nodes = np.interp(basis.s, middle * basis.total_px / lengths.sum(), phi - heading)
    gain = np.interp(basis.s, middle, np.clip(trace.gains, 0.05, 1.0))
    weight = gain / (ANGLE_NOISE_RAD**2 * float(lengths.mean()))
    c = fit_angles(basis, at_nodes, weight, 1 / spectral)
    offset = float((nodes[0] - start) @ np.array([-math.sin(heading), math.cos(heading)]))
    return make_shape(basis, start, heading, np.concatenate([[offset, 0.0], c]))
