"""The camera: where it puts the points of a curve, and at which moment."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.locations.basis import (
    LEAST_BENDING_PER_M,
    bases_of,
    cosine_wave,
    odd_functions,
    perturbation,
    time_span,
)
from model.locations.contract import Basis, BasisTerm, Function, Linearised, Location, Term
from model.locations.quantities import AcquisitionTimes, ImagePoints
from model.measurements import FloatArray

AMPLITUDE_M = 5e-4  # of a distortion of the image
DEGREE = 4  # waves across the image: those with i + j < DEGREE
COUNT = DEGREE * (DEGREE + 1) // 2
IMAGE = ("image_x", "image_y")  # coordinates of terms that move points one way
IMAGE_X_M, IMAGE_Y_M, BELOW_M = 0.05, 0.08, 0.03  # what the waves across the image span
AMPLITUDE_OF_AGE = 0.1  # of the EIBM
WAVES_IN_SESSION = 4  # of the whole image
SIDE_M = 2e-4  # towards the concave side, where the sheet is bent most
WAVES_OF_AGE = 7  # one for each position of the paper: frames fall where they happen to


@dataclass(frozen=True, kw_only=True)
class Camera(Location):
    """Points off along the normal of the curve, or images of another moment than the reading."""

    def curve(self, points: ImagePoints, term: Term) -> tuple[FloatArray, FloatArray] | None:
        """See `Location.curve`."""
        if term.along in IMAGE:
            sizes = term(np.arange(COUNT, dtype=float))
            waves = zip(sizes, _waves(points), strict=True)
            off = 1e-3 * np.sum([size * wave for size, wave in waves], axis=0)
            none = np.zeros_like(off)
            return (off, none) if term.along == "image_x" else (none, off)
        if term.along not in ("s", "curvature"):
            return None
        off = 1e-3 * term(points.s_m if term.along == "s" else _curvature_per_m(points))
        return off * points.normal_x, off * points.normal_y

    def in_image(
        self, clock: AcquisitionTimes, position_m: FloatArray, term: Term
    ) -> FloatArray | None:
        """See `Location.in_image`: in the first pulse half of the change is still to come."""
        if term.along != "position":
            return None
        return np.asarray(term(position_m) * 0.5 * (1.0 - clock.opposite))

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """See `Location.bases`."""
        for number in range(COUNT):
            for along in IMAGE:
                term = BasisTerm(
                    along=along,
                    function=_only(number, at.scale.length),
                    low=0.0,
                    high=COUNT - 1.0,
                    nodes=COUNT,
                )
                step = perturbation(self, at, term)
                step.points_m = step.points_m * at.has_curve[:, None]
                yield Basis(
                    part="place", along="place", function=None, unit="mm",
                    span=(0.0, 1e3 * at.beam.sheet.free_length_m, "mm"), step=step, shared=True,
                    term=term,
                )  # fmt: skip
        yield from self._by_side(at)
        yield from self._moved(at)
        waves = (cosine_wave(j, AMPLITUDE_OF_AGE) for j in range(WAVES_OF_AGE))
        for one in bases_of(self, at, waves, along="position", part="age"):
            yield replace(one, unit="relative")

    def _by_side(self, at: Linearised) -> Iterator[Basis]:
        """Return what shows the sheet towards its concave or its convex side."""
        most = max(at.bent_per_m, LEAST_BENDING_PER_M / at.scale.length)
        # of the curvature, from the largest one way to the other
        for function in odd_functions(1e3 * SIDE_M * at.scale.length):
            term = BasisTerm(along="curvature", function=function, low=-most, high=most)
            step = perturbation(self, at, term)
            step.points_m = step.points_m * at.has_curve[:, None]
            yield Basis(
                part="side", along="curvature", function=function, unit="mm",
                span=(-most, most, "1/m"), step=step, shared=True, term=term, alone=True,
            )  # fmt: skip

    def _moved(self, at: Linearised) -> Iterator[Basis]:
        """Return how the whole image moves in the course of the session."""
        for j in range(1, WAVES_IN_SESSION + 1):
            wave = cosine_wave(j, AMPLITUDE_M * at.scale.length)
            off = (wave(at.measured_at) * at.has_curve)[:, None]
            for normal in (at.points.normal_x, at.points.normal_y):
                step = at.nothing()
                step.points_m = off * normal
                yield Basis(
                    part="place, session", along="time", function=wave, unit="mm",
                    span=time_span(at, "place, session"), step=step, shared=True, alone=True,
                )  # fmt: skip


def _waves(points: ImagePoints) -> Iterator[FloatArray]:
    """Yield the waves across the image at points, each of their shape."""
    scale = points.length_scale
    x, y = points.x_m / (IMAGE_X_M * scale), (points.y_m + BELOW_M * scale) / (IMAGE_Y_M * scale)
    for i in range(DEGREE):
        for j in range(DEGREE - i):
            yield np.cos(i * np.pi * x) * np.cos(j * np.pi * y) / (1.0 + 0.5 * (i + j))


def _curvature_per_m(points: ImagePoints) -> FloatArray:
    """Return the curvature of curves at their points, of their shape."""
    if points.s_m.shape[-1] < 2:
        return np.zeros_like(points.s_m)
    phi = np.unwrap(np.arctan2(-points.normal_x, points.normal_y), axis=-1)
    length, turned = np.gradient(points.s_m, axis=-1), np.gradient(phi, axis=-1)
    return np.asarray(np.where(length > 0.0, turned / np.where(length > 0.0, length, 1.0), 0.0))


def _only(number: int, scale: float) -> Function:
    """Return the function of 0 .. 1 that is one wave's amplitude in mm, and nothing elsewhere."""

    def value(t: FloatArray) -> FloatArray:
        return np.where(np.rint(t * (COUNT - 1)) == number, 1e3 * AMPLITUDE_M * scale, 0.0)

    return value


LOCATION = Camera(
    name="camera",
    meaning="the camera",
    depends="in the pictures alone, not in the forces",
    unit="mm",
    order=70,
    of_the_rig_along=frozenset({"s"}),
)
