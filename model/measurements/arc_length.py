"""The length along a curve through measured points."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre

from model.measurements.data import FloatArray

FEWEST = 16  # points from which noise is told from bending
LENGTHENED = 1e-4  # relative: from which on noise counts that lengthens the chords
MOST_DEGREE, POINTS_A_TERM = 14, 4  # of the polynomials
BEYOND_NOISE = 4.0  # variance of what is left, over the noise's: the polynomials do not follow
PARTS = 4  # of each stretch between two points, by which a smooth curve is measured


def arc_length_m(x_m: FloatArray, y_m: FloatArray) -> FloatArray:
    """Return the length (n,) along a curve through points (n,), from the first one on.

    Each chord is lengthened to the arc of the circle that turns as the chords beside it do, so the
    error falls with the fourth power of the spacing. Noise lengthens chords by about its variance
    over the square of the spacing: points 0.5 mm apart that are good to 0.1 mm by 4 %, a line of
    pixels by up to 8 %. Where that counts it is the length of polynomials through the points, whose
    degree Schwarz's criterion chooses (1978, Ann. Statist. 6, 461).
    """
    chord = np.hypot(np.diff(x_m), np.diff(y_m))
    if len(x_m) >= FEWEST and np.all(chord > 0.0):
        along = np.concatenate([[0.0], np.cumsum(chord)])
        variance = _variance_m2(along, x_m, y_m)
        if variance > LENGTHENED * float(np.mean(chord)) ** 2:
            smooth = _of_polynomials(along, x_m, y_m, BEYOND_NOISE * variance)
            return _of_arcs(x_m, y_m) if smooth is None else smooth
    return _of_arcs(x_m, y_m)


def _of_arcs(x_m: FloatArray, y_m: FloatArray) -> FloatArray:
    dx, dy = np.diff(x_m), np.diff(y_m)
    chord = np.hypot(dx, dy)
    turn = np.diff(np.unwrap(np.arctan2(dy, dx)))  # at each inner point
    if turn.size == 0:
        return np.concatenate([[0.0], np.cumsum(chord)])
    # A chord turns by half of the turns at its two ends; the outermost ones as their neighbours.
    own = 0.5 * (np.concatenate([turn[:1], turn]) + np.concatenate([turn, turn[-1:]]))
    half = 0.5 * own
    longer = np.where(np.abs(half) < 1e-6, 1.0, half / np.sin(np.where(half == 0, 1.0, half)))
    return np.concatenate([[0.0], np.cumsum(chord * longer)])


def _variance_m2(along_m: FloatArray, x_m: FloatArray, y_m: FloatArray) -> float:
    """Return the variance of a coordinate: off the cubic through two neighbours on either side."""
    inner = np.arange(2, len(along_m) - 2)
    beside = inner[:, None] + np.array([-2, -1, 1, 2])
    at, nodes = along_m[inner], along_m[beside]
    weights = np.ones(beside.shape)  # Lagrange's
    for j in range(4):
        for k in {0, 1, 2, 3} - {j}:
            weights[:, j] *= (at - nodes[:, k]) / (nodes[:, j] - nodes[:, k])
    off_x, off_y = (p[inner] - np.sum(weights * p[beside], axis=1) for p in (x_m, y_m))
    return float(np.mean(0.5 * (off_x**2 + off_y**2) / (1.0 + np.sum(weights**2, axis=1))))


def _of_polynomials(
    along_m: FloatArray, x_m: FloatArray, y_m: FloatArray, most_m2: float
) -> FloatArray | None:
    """Return the length of polynomials x and y; None where they leave more than a variance."""
    count = len(along_m)
    unit = 2.0 * along_m / along_m[-1] - 1.0
    degrees = min(MOST_DEGREE, count // POINTS_A_TERM)
    basis, triangle = np.linalg.qr(legendre.legvander(unit, degrees))
    both = np.stack([x_m, y_m], axis=1)
    terms = basis.T @ both
    left = np.maximum(np.sum(both**2) - np.cumsum(np.sum(terms**2, axis=1)), 1e-300)  # by degree
    used = 1 + np.arange(len(left))
    best = int(np.argmin(2 * count * np.log(left) + 2 * used * np.log(2 * count))) + 1
    if left[best - 1] > 2 * count * most_m2:
        return None
    found = np.linalg.solve(triangle[:best, :best], terms[:best])
    part = np.arange(PARTS) / PARTS
    fine = np.append((unit[:-1, None] + np.diff(unit)[:, None] * part).ravel(), unit[-1])
    steps = np.diff(legendre.legval(fine, found), axis=1)
    return np.concatenate([[0.0], np.cumsum(np.hypot(*steps))])[::PARTS]
