"""A first shape of a curve: along a path, the first part of another one, or one that is led on."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve.shape import CurveShape, fit_angles, make_basis, make_shape
from labrig.vision.fit.leading_on import LedOn

FloatArray = npt.NDArray[np.float64]

BEND_WIDTHS = 4.0  # before an end: beyond it the curve bends as it does there
BEYOND_TURN_MAX_RAD = 0.5  # of the strip there, as it bends before
LONGEST_CELL_PX = 1.0
COEFFICIENTS = (6, 41)


def _coefficients(length_px: float, width_px: float) -> int:
    """Return enough for bends of a few widths."""
    least, most = COEFFICIENTS
    return int(np.clip(round(length_px / (3 * width_px)) + 3, least, most))


def first_shape(
    plane: FloatArray, optics: Optics, width: float, free_px: float, length_px: float
) -> tuple[Optics, CurveShape]:
    """Return the optics with the clamp where a path begins, and a curve along the path."""
    ppm = optics.px_per_m
    u, v = optics.world_to_pixel(plane[:1] / ppm)[0]
    chord = np.diff(plane, axis=0)
    lengths = np.hypot(chord[:, 0], chord[:, 1])
    phi = np.unwrap(np.arctan2(chord[:, 1], chord[:, 0]))
    middle = np.cumsum(lengths) - lengths / 2
    heading = float(phi[0])
    there = optics.model_copy(
        update={
            "clamp_px": (float(u), float(v)),
            "origin_px": optics.origin_undistorted_px,
            "clamp_angle_rad": heading,
        }
    )
    basis = make_basis(
        round(free_px, 3), round(length_px, 3), _coefficients(free_px, width), LONGEST_CELL_PX
    )
    wanted = np.interp(basis.s, middle, phi - heading)
    smooth = 1e-2 * free_px**3
    c = fit_angles(basis, wanted, np.ones(len(basis.s)), smooth / basis.size)
    return there, make_shape(basis, plane[0], heading, np.concatenate([[0.0, 0.0], c]))


def cut(
    shape: CurveShape,
    length_px: float,
    width: float,
    *,
    begin_px: float = 0,
    way: LedOn | None = None,
) -> CurveShape:
    """Return the first part of a curve without its begin, or all of it led on along a way."""
    if begin_px > 0:
        return _cut_begin(shape, begin_px, length_px - begin_px, width)
    basis = make_basis(
        round(length_px, 3), round(length_px, 3), _coefficients(length_px, width), LONGEST_CELL_PX
    )
    turn = float(shape.parameters[1])
    wanted = _led_on(shape, basis.s, width, way) - shape.heading - turn
    c = fit_angles(basis, wanted, np.full(len(basis.s), 1e6), 1.0)
    return make_shape(basis, shape.start, shape.heading, np.concatenate([shape.parameters[:2], c]))


def _led_on(shape: CurveShape, s: FloatArray, width: float, way: LedOn | None) -> FloatArray:
    """Return the direction along a curve; beyond its end it bends as it did shortly before."""
    along = shape.basis.s
    last = float(along[-1])
    few = min(BEND_WIDTHS * width, 0.25 * last)
    bend = float(shape.phi[-1] - np.interp(last - few, along, shape.phi)) / few
    further = np.clip(bend * np.maximum(s - last, 0), -BEYOND_TURN_MAX_RAD, BEYOND_TURN_MAX_RAD)
    aside = 0.0 if way is None else np.arctan(np.interp(s, way.s, way.slope, left=0.0))
    return np.asarray(np.interp(s, along, shape.phi) + further + aside)


def _cut_begin(shape: CurveShape, begin_px: float, length_px: float, width: float) -> CurveShape:
    along = shape.basis.s
    basis = make_basis(
        round(length_px, 3), round(length_px, 3), _coefficients(length_px, width), LONGEST_CELL_PX
    )
    start = np.array([np.interp(begin_px, along, each) for each in (shape.x, shape.y)])
    heading = float(np.interp(begin_px, along, shape.phi))
    wanted = np.interp(basis.s + begin_px, along, shape.phi) - heading
    c = fit_angles(basis, wanted, np.full(len(basis.s), 1e6), 1.0)
    return make_shape(basis, start, heading, np.concatenate([[0.0, 0.0], c]))
