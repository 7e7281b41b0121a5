"""The camera: where it puts the points of a curve, and at which moment."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.locations.basis import (
    EACH_POLARITY,
    LEAST_BENDING_PER_M,
    bases_of,
    cosine_wave,
    odd_functions,
    perturbation,
    step_at,
    time_span,
)
from model.locations.contract import Basis, BasisTerm, Function, Linearised, Location, Term
from model.locations.quantities import (
    WAVE_DEGREES,
    AcquisitionTimes,
    ImagePoints,
    wave_count,
)
from model.measurements import FloatArray

AMPLITUDE_M = 5e-4  # of a distortion of the image
IN_X, IN_Y = (tuple(names) for names in zip(*WAVE_DEGREES, strict=True))
IMAGE_X_M, IMAGE_Y_M, BELOW_M = 0.05, 0.08, 0.03  # what the waves across the image span
AMPLITUDE_OF_AGE = 0.1  # of the EIBM
WAVES_ALONG_CURVE = 5
WAVES_IN_SESSION = 4  # of the whole image
KNOCK, KNOCKS, KNOCK_WAYS = "knock", 20, 3  # times at which it may be knocked: moved and turned
OUT_OF_PLANE = "place, each polarity"
SIDE_M = 2e-4  # towards the concave side, where the sheet is bent most
WAVES_OF_AGE = 7  # one for each position of the paper: frames fall where they happen to


@dataclass(frozen=True, kw_only=True)
class Camera(Location):
    """Points off along the normal of the curve, or images of another moment than the reading."""

    def curve(self, points: ImagePoints, term: Term) -> tuple[FloatArray, FloatArray] | None:
        """See `Location.curve`."""
        for names, degree in WAVE_DEGREES.items():
            if term.along in names:
                sizes = term(np.arange(wave_count(term.along), dtype=float))
                moved = 1e-3 * _moved_by(points, degree, sizes)
                # how far along the curve is seen by nothing
                off = moved * (points.normal_x if term.along in IN_X else points.normal_y)
                off = off * term.share(np.asarray(points.voltage_V))
                return off * points.normal_x, off * points.normal_y
        if term.along not in ("s", "curvature"):
            return None
        off = 1e-3 * term(points.s_m if term.along == "s" else _curvature_per_m(points))
        off = term.share(np.asarray(points.voltage_V)) * off
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
        coarse, fine = WAVE_DEGREES
        # a sheet that twists or leans under voltage is nearer to the camera, and larger
        for in_x_and_y, part, under in (
            (coarse, "place", ""), (fine, "place, fine", ""), (coarse, OUT_OF_PLANE, "polarity"),
        ):  # fmt: skip
            for number in range(wave_count(in_x_and_y[0])):
                for along in in_x_and_y:
                    yield self._wave(at, number, along, part, under)
        yield from self._along_curve(at)
        yield from self._by_side(at)
        yield from self._moved(at)
        waves = (cosine_wave(j, AMPLITUDE_OF_AGE) for j in range(WAVES_OF_AGE))
        for one in bases_of(self, at, waves, along="position", part="age"):
            yield replace(one, unit="relative")

    def _wave(self, at: Linearised, number: int, along: str, part: str, under: str) -> Basis:
        """Return one wave across the image; fine ones are looked for by themselves only."""
        count = wave_count(along)
        term = BasisTerm(
            along=along, function=_only(number, count, at.scale.length), low=0.0, high=count - 1.0,
            nodes=count, under=under,
        )  # fmt: skip
        step = perturbation(self, at, term)
        step.points_m = step.points_m * at.has_curve[:, None]
        return Basis(
            part=part, along="place", function=None, unit="mm",
            span=(0.0, 1e3 * at.beam.sheet.free_length_m, "mm"), step=step, shared=True, term=term,
            alone=part != "place",
        )  # fmt: skip

    def _along_curve(self, at: Linearised) -> Iterator[Basis]:
        """Return what goes with the sheet: a stain that is taken for it, an edge that turns up."""
        end_m = at.beam.sheet.free_length_m + at.beam.sheet.elongation_m
        for part, under in (("s", ""), (EACH_POLARITY, "voltage"), (EACH_POLARITY, "polarity")):
            for j in range(WAVES_ALONG_CURVE):
                wave = cosine_wave(j, 1e3 * AMPLITUDE_M * at.scale.length)
                term = BasisTerm(along="s", function=wave, low=0.0, high=end_m, under=under)
                step = perturbation(self, at, term)
                step.points_m = step.points_m * at.has_curve[:, None]
                yield Basis(
                    part=part, along="s", function=wave, unit="mm", span=(0.0, 1e3 * end_m, "mm"),
                    step=step, term=term, alone=True,
                )  # fmt: skip

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
        """Return how the whole image moves, turns and grows in the course of the session.

        Slowly, all of it or in scale alone; or at once, where the camera is knocked, which may be
        at any of some times. Not from one sheet to the next: what differs between them may be
        theirs.
        """
        size, similar = AMPLITUDE_M * at.scale.length, list(_similar(at.points))
        for j in range(1, WAVES_IN_SESSION + 1):
            wave, grown = cosine_wave(j, size), [_grown(at.points)]
            yield from self._in_session(at, "place, session", wave, similar)
            yield from self._in_session(at, "scale, session", wave, grown)
        for j in range(1, KNOCKS + 1):
            when = j / (KNOCKS + 1)
            if any(first < when <= last for first, last in at.pictured):
                part, knock = f"{KNOCK} {j}, session", step_at(when, size)
                share = f"{100.0 * when:.0f} %"
                shows = f"; about {share} into the session the whole picture moves at once"
                for one in self._in_session(at, part, knock, similar[:KNOCK_WAYS]):
                    yield replace(one, shows=shows)

    def _in_session(
        self, at: Linearised, part: str, course: Function, ways: Iterable[FloatArray]
    ) -> Iterator[Basis]:
        off = (course(at.measured_at) * at.has_curve)[:, None]
        for along_normal in ways:
            step = at.nothing()
            step.points_m = off * along_normal
            yield Basis(
                part=part, along="time", function=course, unit="mm", span=time_span(part),
                step=step, shared=True, alone=True,
            )  # fmt: skip


def _similar(points: ImagePoints) -> Iterator[FloatArray]:
    """Yield how far points go along their normals where the image moves, turns and grows."""
    normal_x, normal_y = points.normal_x, points.normal_y
    x = points.x_m / (IMAGE_X_M * points.length_scale) - 0.5
    y = points.y_m / (IMAGE_X_M * points.length_scale)
    yield normal_x
    yield normal_y
    yield x * normal_y - y * normal_x
    yield x * normal_x + y * normal_y


def _grown(points: ImagePoints) -> FloatArray:
    """Return how far points go along their normals where the image grows about the clamp.

    The clamp is found in each picture, so that it stays where it is when a lens breathes.
    """
    along = points.x_m * points.normal_x + points.y_m * points.normal_y
    return along / (IMAGE_X_M * points.length_scale)


def _moved_by(points: ImagePoints, degree: int, sizes: FloatArray) -> FloatArray:
    """Return the sum of the waves across the image at points, each times its size."""
    scale, result = points.length_scale, np.zeros_like(points.x_m)
    x, y = points.x_m / (IMAGE_X_M * scale), (points.y_m + BELOW_M * scale) / (IMAGE_Y_M * scale)
    numbers = [(i, j) for i in range(degree) for j in range(degree - i)]
    for (i, j), size in zip(numbers, sizes.tolist(), strict=True):
        if size:
            wave = np.cos(i * np.pi * x) * np.cos(j * np.pi * y)
            result = result + size * wave / (1.0 + 0.5 * (i + j))
    return result


def _curvature_per_m(points: ImagePoints) -> FloatArray:
    """Return the curvature of curves at their points, of their shape."""
    if points.s_m.shape[-1] < 2:
        return np.zeros_like(points.s_m)
    phi = np.unwrap(np.arctan2(-points.normal_x, points.normal_y), axis=-1)
    length, turned = np.gradient(points.s_m, axis=-1), np.gradient(phi, axis=-1)
    return np.asarray(np.where(length > 0.0, turned / np.where(length > 0.0, length, 1.0), 0.0))


def _only(number: int, count: int, scale: float) -> Function:
    """Return the function of 0 .. 1 that is one wave's amplitude in mm, and nothing elsewhere."""

    def value(t: FloatArray) -> FloatArray:
        return np.where(np.rint(t * (count - 1)) == number, 1e3 * AMPLITUDE_M * scale, 0.0)

    return value


LOCATION = Camera(
    name="camera",
    meaning="the camera",
    depends="in the pictures alone, not in the forces",
    unit="mm",
    order=70,
)
