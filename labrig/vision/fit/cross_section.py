"""Kernels of the intensity fit: the pixels beside a curve, and the cross-section fitted to them.

Model of a pixel at distance d (along the normal) from the curve: b + a d + c P(d), with P a band
of the sheet's thickness blurred by the lens, and beside it the sheet's side face where one is seen,
grey by a share of the band; b, a, c are slow along the sheet (solved in windows). A shift of the
curve by +delta changes the pixel by -(a + c P') delta; b, a, c and what they could imitate of a
shift are projected out, so what is left is the full likelihood's answer.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from labrig.vision.jit import jit

FloatArray = npt.NDArray[np.float64]
MapArray = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]
MaskArray = npt.NDArray[np.uint8]


# the normal distribution by Hermite's cubics between these points is good to 1e-9
_STEPS, _REACH = 64, 7
_AT = np.arange(-_REACH * _STEPS, _REACH * _STEPS + 1) / _STEPS
_DENSITY = np.exp(-0.5 * _AT**2) / math.sqrt(2 * math.pi)
_TOTAL = np.array([0.5 * math.erfc(-x / math.sqrt(2)) for x in _AT])


@jit
def normal(x: float) -> tuple[float, float]:
    """Return the standard normal distribution's integral up to x, and its density there."""
    if x <= -_REACH:
        return 0.0, 0.0
    if x >= _REACH:
        return 1.0, 0.0
    place = (x + _REACH) * _STEPS
    i = int(place)
    t = place - i
    y0, y1 = _TOTAL[i], _TOTAL[i + 1]
    m0, m1 = _DENSITY[i] / _STEPS, _DENSITY[i + 1] / _STEPS
    rise = y1 - y0
    a, b = m0 - rise, rise - m1
    value = y0 + t * rise + t * (1 - t) * ((1 - t) * a + t * b)
    slope = rise + (1 - 2 * t) * ((1 - t) * a + t * b) + t * (1 - t) * (b - a)
    return value, slope * _STEPS


@jit
def collect(
    image: MapArray,
    plane: MapArray,
    node_u: FloatArray,
    node_v: FloatArray,
    x: FloatArray,
    y: FloatArray,
    phi: FloatArray,
    k: FloatArray,
    reach: float,
    pixel_size: float,
    mask: MaskArray,
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Return intensities and distances (pixels,) and the first pixel of each cell (cells + 1,).

    A cell lies between the normals of two neighbouring nodes, so each pixel belongs to one.
    `plane` (rows, columns, 2): every pixel's place in the sheet's plane; `node_u`, `node_v`: the
    nodes in the image; `reach` how far beside the curve, `pixel_size` a pixel's largest extent
    in plane units; pixels where `mask` (rows, columns) is not 0 are left out.
    """
    rows, columns = image.shape
    cells = len(x) - 1
    first = np.zeros(cells + 1, dtype=np.int64)
    capacity = int(cells * (2 * reach + 3) * 2.2 / (pixel_size * pixel_size)) + 1000
    value = np.empty(capacity)
    distance = np.empty(capacity)
    many = 0
    cos, sin = np.empty(cells + 1), np.empty(cells + 1)
    for i in range(cells + 1):
        cos[i], sin[i] = math.cos(phi[i]), math.sin(phi[i])
    for i in range(cells):
        first[i] = many
        du, dv = node_u[i + 1] - node_u[i], node_v[i + 1] - node_v[i]
        beside = reach / pixel_size / max(math.hypot(du, dv), 1e-9)
        wide, high = beside * abs(dv) + 1.5, beside * abs(du) + 1.5
        low_v = max(0, math.floor(min(node_v[i], node_v[i + 1]) - high))
        high_v = min(rows - 1, math.ceil(max(node_v[i], node_v[i + 1]) + high))
        low_u = max(0, math.floor(min(node_u[i], node_u[i + 1]) - wide))
        high_u = min(columns - 1, math.ceil(max(node_u[i], node_u[i + 1]) + wide))
        for row in range(low_v, high_v + 1):
            for column in range(low_u, high_u + 1):
                px, py = plane[row, column, 0], plane[row, column, 1]
                ahead = (px - x[i]) * cos[i] + (py - y[i]) * sin[i]
                if ahead < 0:
                    continue
                left = (px - x[i + 1]) * cos[i + 1] + (py - y[i + 1]) * sin[i + 1]
                if left >= 0:
                    continue
                d = -(px - x[i]) * sin[i] + (py - y[i]) * cos[i] - 0.5 * k[i] * ahead * ahead
                if abs(d) > reach or many >= capacity or mask[row, column] != 0:
                    continue
                value[many] = image[row, column]
                distance[many] = d
                many += 1
    first[cells] = many
    return value[:many].copy(), distance[:many].copy(), first


@jit
def window_sums(sums: FloatArray, half: int) -> FloatArray:
    """Return moving sums over `2 half + 1` cells of (cells, columns)."""
    cells, columns = sums.shape
    running = np.zeros((cells + 1, columns))
    for i in range(cells):
        for q in range(columns):
            running[i + 1, q] = running[i, q] + sums[i, q]
    out = np.empty_like(sums)
    for i in range(cells):
        low, high = max(0, i - half), min(cells, i + half + 1)
        for q in range(columns):
            out[i, q] = running[high, q] - running[low, q]
    return out


@jit
def _solve(n: FloatArray, low: FloatArray, out: FloatArray) -> None:
    """Solve a window's equations for three right-hand sides, into `out` (3, 3).

    n: the upper triangle of three by three by rows, then the right-hand sides; `low` (3, 3) is room
    to work in. A trace of a ridge keeps empty windows solvable.
    """
    tiny = 1e-9 * (n[0] + n[3] + n[5]) + 1e-12
    at = 0
    for i in range(3):
        for j in range(i, 3):
            low[j, i] = n[at] + (tiny if i == j else 0.0)
            at += 1
    for i in range(3):  # Cholesky
        for j in range(i + 1):
            total = low[i, j]
            for q in range(j):
                total -= low[i, q] * low[j, q]
            low[i, j] = math.sqrt(max(total, tiny)) if i == j else total / low[j, j]
    for k in range(3):
        for i in range(3):
            total = n[6 + 3 * k + i]
            for q in range(i):
                total -= low[i, q] * out[k, q]
            out[k, i] = total / low[i, i]
        for i in range(2, -1, -1):
            total = out[k, i]
            for q in range(i + 1, 3):
                total -= low[q, i] * out[k, q]
            out[k, i] = total / low[i, i]


@jit
def templates(
    distance: FloatArray,
    first: IntArray,
    half_width: FloatArray,
    blur: float,
    widen: FloatArray,
    side_face: FloatArray,
    side_face_share: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return P, P' and the derivative for blur or half width of each pixel, face included.

    `side_face` (cells,): the side face's width in pixels beside the band, negative: below it.
    """
    p, slope, width_slope = (
        np.empty_like(distance),
        np.empty_like(distance),
        np.empty_like(distance),
    )
    for i in range(len(first) - 1):
        half, width = half_width[i], abs(side_face[i])
        side = 1.0 if side_face[i] > 0 else -1.0
        for q in range(first[i], first[i + 1]):
            up, low = (distance[q] + half) / blur, (distance[q] - half) / blur
            step_up, high = normal(up)
            step_low, deep = normal(low)
            p[q] = step_up - step_low
            slope[q] = (high - deep) / blur
            width_slope[q] = (high + deep if widen[i] > 0 else low * deep - up * high) / blur
            if side_face_share > 0 and width > 0:
                near = (side * distance[q] - half) / blur
                far = near - width / blur
                step_near, near_high = normal(near)
                step_far, far_high = normal(far)
                p[q] += side_face_share * (step_near - step_far)
                slope[q] += side_face_share * side * (near_high - far_high) / blur
                if widen[i] > 0:
                    width_slope[q] += side_face_share * (far_high - near_high) / blur
                else:
                    width_slope[q] += side_face_share * (far * far_high - near * near_high) / blur
    return p, slope, width_slope


@jit
def _gather(
    sums: FloatArray,
    low: int,
    high: int,
    basis: FloatArray,
    weight: FloatArray,
    right: FloatArray,
) -> None:
    """Sum the window equations of one cell: products of the basis, three right-hand sides."""
    # kept in variables, so that no sum must be stored before the next pixel is read
    w0, wd, wt, dd, dt, tt = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    f0, fd, ft, g0, gd, gt, h0, hd, ht = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for q in range(low, high):
        d, t = basis[q, 0], basis[q, 1]
        w = weight[q]
        f, g, h = w * right[q, 0], w * right[q, 1], w * right[q, 2]
        w0 += w
        wd += w * d
        wt += w * t
        dd += w * d * d
        dt += w * d * t
        tt += w * t * t
        f0 += f
        fd += f * d
        ft += f * t
        g0 += g
        gd += g * d
        gt += g * t
        h0 += h
        hd += h * d
        ht += h * t
    sums[0], sums[1], sums[2], sums[3], sums[4], sums[5] = w0, wd, wt, dd, dt, tt
    sums[6], sums[7], sums[8] = f0, fd, ft
    sums[9], sums[10], sums[11] = g0, gd, gt
    sums[12], sums[13], sums[14] = h0, hd, ht


@jit
def measure(
    value: FloatArray,
    distance: FloatArray,
    first: IntArray,
    half_width: FloatArray,
    blur: float,
    window: int,
    noise: float,
    rounds: int,
    used: FloatArray,
    widen: FloatArray,
    side_face: FloatArray,
    side_face_share: float,
) -> FloatArray:
    """Return (cells, 12) sums and solutions of each cell's pixels.

    Columns: contrast c, background b, slope a, sum g^2, sum g res, sum res^2, sum of weights,
    sum h res, sum h^2, mean intensity, sum p res, sum p^2. g is the derivative of a pixel with
    respect to a shift, what b, a and c could imitate projected out; h the same for the blur, or,
    where `widen` is not 0, for the half width; p is P without its mean in the cell. The sums are
    weighted but for those with p, which hold for any content, also what does not fit. `noise` is
    one pixel's, the scale of the robust weights; `half_width`, `used`, `widen` and `side_face` are
    (cells,).
    """
    cells, pixels = len(first) - 1, len(value)
    right = np.empty((pixels, 3))
    basis = np.empty((pixels, 2))
    p, slope, width_slope = templates(
        distance, first, half_width, blur, widen, side_face, side_face_share
    )
    for q in range(pixels):
        right[q, 0], right[q, 1], right[q, 2] = value[q], slope[q], width_slope[q]
        basis[q, 0], basis[q, 1] = distance[q], p[q]
    low, solved = np.zeros((3, 3)), np.zeros((3, 3))
    weight = np.ones(pixels)
    out = np.zeros((cells, 12))
    for turn in range(rounds):
        sums = np.zeros((cells, 15))
        for i in range(cells):
            if used[i] > 0:
                _gather(sums[i], first[i], first[i + 1], basis, weight, right)
        total = window_sums(sums, window)
        for i in range(cells):
            _solve(total[i], low, solved)
            b0, b1, c = solved[0, 0], solved[0, 1], solved[0, 2]
            g0, g1, g2 = solved[1, 0], solved[1, 1], solved[1, 2]
            h0, h1, h2 = solved[2, 0], solved[2, 1], solved[2, 2]
            many = max(first[i + 1] - first[i], 1)
            shown, missed = 0.0, 0.0
            for q in range(first[i], first[i + 1]):
                d, t = basis[q, 0], basis[q, 1]
                miss = right[q, 0] - (b0 + b1 * d + c * t)
                if turn < rounds - 1:
                    # Tukey's weights: an outlier beyond 4.7 sigma counts for nothing
                    ratio = miss / (4.7 * noise)
                    weight[q] = (1.0 - ratio * ratio) ** 2 if abs(ratio) < 1.0 else 0.0
                    continue
                g = right[q, 1] - (g0 + g1 * d + g2 * t)
                h = right[q, 2] - (h0 + h1 * d + h2 * t)
                w = weight[q]
                out[i, 3] += w * c * c * g * g
                out[i, 4] -= w * c * g * miss
                out[i, 5] += w * miss * miss
                out[i, 6] += w
                out[i, 7] += w * c * h * miss
                out[i, 8] += w * c * c * h * h
                out[i, 9] += value[q] / many
                out[i, 10] += t * miss
                out[i, 11] += t * t
                shown += t
                missed += miss
            out[i, 10] -= shown * missed / many
            out[i, 11] -= shown * shown / many
            out[i, 0], out[i, 1], out[i, 2] = c, b0, b1
    return out
