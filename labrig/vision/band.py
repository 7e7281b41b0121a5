"""The pixels beside a curve, and what they say of it: the kernels of the intensity fit.

Model of a pixel at distance d (along the normal) from the curve: b + a d + c P(d) + f Q(d), with P
the band of the sheet's thickness blurred by the lens, Q the sheet's far face where one is seen
beside it, and b, a, c, f slow along the sheet (solved in
windows). A shift of the curve by +delta changes the pixel by -(a + c P') delta; b, a, c and what
they could imitate of a shift are projected out, so what is left is the full likelihood's answer.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from labrig.vision._jit import jit

FloatArray = npt.NDArray[np.float64]
MapArray = npt.NDArray[np.float32]
IntArray = npt.NDArray[np.int64]
MaskArray = npt.NDArray[np.uint8]


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
    """Intensities (pixels,), distances (pixels,) and the first pixel of each cell (cells + 1,).

    A cell lies between the normals of two neighbouring nodes, so each pixel belongs to one.
    `plane` (rows, columns, 2): every pixel's place in the sheet's plane; `node_u`, `node_v`: the
    nodes in the picture; `reach` how far beside the curve, `pixel_size` a pixel's largest extent
    in plane units; pixels where `mask` (rows, columns) is not 0 are left out.
    """
    rows, columns = image.shape
    cells = len(x) - 1
    first = np.zeros(cells + 1, dtype=np.int64)
    capacity = int(cells * (2 * reach + 3) * 2.2 / (pixel_size * pixel_size)) + 1000
    value = np.empty(capacity)
    distance = np.empty(capacity)
    many = 0
    margin = reach / pixel_size + 1.5
    cos, sin = np.cos(phi), np.sin(phi)
    for i in range(cells):
        first[i] = many
        low_v = max(0, math.floor(min(node_v[i], node_v[i + 1]) - margin))
        high_v = min(rows - 1, math.ceil(max(node_v[i], node_v[i + 1]) + margin))
        low_u = max(0, math.floor(min(node_u[i], node_u[i + 1]) - margin))
        high_u = min(columns - 1, math.ceil(max(node_u[i], node_u[i + 1]) + margin))
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
def template(d: float, half_width: float, blur: float) -> tuple[float, float]:
    """The blurred band P and its derivative P'."""
    scale = 1.0 / (math.sqrt(2.0) * blur)
    up, low = (d + half_width) * scale, (d - half_width) * scale
    value = 0.5 * (math.erf(up) - math.erf(low))
    slope = (math.exp(-up * up) - math.exp(-low * low)) * scale / math.sqrt(math.pi)
    return value, slope


@jit
def window_sums(sums: FloatArray, half: int) -> FloatArray:
    """Moving sums over `2 half + 1` cells of (cells, columns)."""
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
def _solve(n: FloatArray, size: int, low: FloatArray, out: FloatArray) -> None:
    """Solve a window's equations for three right-hand sides, into `out` (3, 4).

    n: the upper triangle of four by four by rows, then the right-hand sides; `size` 3 leaves the
    face out; `low` (4, 4) is room to work in. A trace of a ridge keeps empty windows solvable.
    """
    tiny = 1e-9 * (n[0] + n[4] + n[7] + n[9]) + 1e-12
    at = 0
    for i in range(size):
        for j in range(i, size):
            low[j, i] = n[at] + (tiny if i == j else 0.0)
            at += 1
        at += 4 - size
    for i in range(size):  # Cholesky
        for j in range(i + 1):
            total = low[i, j]
            for q in range(j):
                total -= low[i, q] * low[j, q]
            low[i, j] = math.sqrt(max(total, tiny)) if i == j else total / low[j, j]
    for k in range(3):
        for i in range(size):
            total = n[10 + 4 * k + i]
            for q in range(i):
                total -= low[i, q] * out[k, q]
            out[k, i] = total / low[i, i]
        for i in range(size - 1, -1, -1):
            total = out[k, i]
            for q in range(i + 1, size):
                total -= low[q, i] * out[k, q]
            out[k, i] = total / low[i, i]


@jit
def _faces(
    distance: FloatArray, first: IntArray, half_width: FloatArray, blur: float, face: FloatArray
) -> FloatArray:
    """The far face's plateau beside the band: `face` (cells,) pixels wide, negative: below it."""
    out = np.zeros_like(distance)
    for i in range(len(first) - 1):
        if face[i] == 0:
            continue
        width, side = abs(face[i]), 1.0 if face[i] > 0 else -1.0
        for q in range(first[i], first[i + 1]):
            d = side * distance[q] - half_width[i] - 0.5 * width
            out[q], _ = template(d, 0.5 * width, blur)
    return out


@jit
def _templates(
    distance: FloatArray, first: IntArray, half_width: FloatArray, blur: float, widen: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """P, P' and the derivative for the look (blur or half width) of each pixel."""
    p, slope, look_slope = np.empty_like(distance), np.empty_like(distance), np.empty_like(distance)
    unit, root = math.sqrt(2 * math.pi) * blur, math.sqrt(0.5)
    for i in range(len(first) - 1):
        for q in range(first[i], first[i + 1]):
            up, low = (distance[q] + half_width[i]) / blur, (distance[q] - half_width[i]) / blur
            high = math.exp(-0.5 * up * up) / unit
            deep = math.exp(-0.5 * low * low) / unit
            p[q] = 0.5 * (math.erf(up * root) - math.erf(low * root))
            slope[q] = high - deep
            look_slope[q] = high + deep if widen[i] > 0 else low * deep - up * high
    return p, slope, look_slope


@jit
def _gather(
    sums: FloatArray,
    low: int,
    high: int,
    size: int,
    basis: FloatArray,
    weight: FloatArray,
    right: FloatArray,
) -> None:
    """Sum the window equations of one cell: products of the basis, three right-hand sides."""
    for q in range(low, high):
        w, d, t = weight[q], basis[q, 1], basis[q, 2]
        f, g, h = right[q, 0], right[q, 1], right[q, 2]
        wd, wt = w * d, w * t
        sums[0] += w
        sums[1] += wd
        sums[2] += wt
        sums[4] += wd * d
        sums[5] += wd * t
        sums[7] += wt * t
        sums[10] += w * f
        sums[11] += wd * f
        sums[12] += wt * f
        sums[14] += w * g
        sums[15] += wd * g
        sums[16] += wt * g
        sums[18] += w * h
        sums[19] += wd * h
        sums[20] += wt * h
        if size == 4:
            e = basis[q, 3]
            we = w * e
            sums[3] += we
            sums[6] += wd * e
            sums[8] += wt * e
            sums[9] += we * e
            sums[13] += we * f
            sums[17] += we * g
            sums[21] += we * h


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
    face: FloatArray,
) -> FloatArray:
    """Per cell (cells, 11) what the pixels say.

    Columns: contrast c, background b, slope a, sum g^2, sum g res, sum res^2, sum of weights,
    sum h res, sum h^2, mean intensity, the far face's contrast. g is the derivative of a pixel
    with respect to a shift, what b, a, c and the face could imitate projected out; h the same for
    the blur, or, where `widen` is not 0, for the half width. `noise` is one pixel's, the scale of
    the robust weights; `half_width`, `used`, `widen` and `face` are (cells,).
    """
    cells, pixels = len(first) - 1, len(value)
    right = np.empty((pixels, 3))
    basis = np.zeros((pixels, 4))
    basis[:, 0] = 1.0
    right[:, 0] = value
    basis[:, 1] = distance
    basis[:, 2], right[:, 1], right[:, 2] = _templates(distance, first, half_width, blur, widen)
    size = 4 if np.any(face != 0) else 3
    if size == 4:
        basis[:, 3] = _faces(distance, first, half_width, blur, face)
    low, solved = np.zeros((4, 4)), np.zeros((3, 4))
    weight = np.ones(pixels)
    out = np.zeros((cells, 11))
    for turn in range(rounds):
        sums = np.zeros((cells, 22))
        for i in range(cells):
            if used[i] > 0:
                _gather(sums[i], first[i], first[i + 1], size, basis, weight, right)
        total = window_sums(sums, window)
        for i in range(cells):
            _solve(total[i], size, low, solved)
            b0, b1, c, b3 = solved[0]
            g0, g1, g2, g3 = solved[1]
            h0, h1, h2, h3 = solved[2]
            for q in range(first[i], first[i + 1]):
                d, t, e = basis[q, 1], basis[q, 2], basis[q, 3]
                miss = right[q, 0] - (b0 + b1 * d + c * t + b3 * e)
                if turn < rounds - 1:
                    # Tukey's weights: an outlier beyond 4.7 sigma counts for nothing
                    ratio = miss / (4.7 * noise)
                    weight[q] = (1.0 - ratio * ratio) ** 2 if abs(ratio) < 1.0 else 0.0
                    continue
                g = right[q, 1] - (g0 + g1 * d + g2 * t + g3 * e)
                h = right[q, 2] - (h0 + h1 * d + h2 * t + h3 * e)
                w = weight[q]
                out[i, 3] += w * c * c * g * g
                out[i, 4] -= w * c * g * miss
                out[i, 5] += w * miss * miss
                out[i, 6] += w
                out[i, 7] += w * c * h * miss
                out[i, 8] += w * c * c * h * h
                out[i, 9] += value[q] / (first[i + 1] - first[i])
            out[i, 0], out[i, 1], out[i, 2], out[i, 10] = c, b0, b1, b3
    return out


@jit
def ridge_offsets(
    smooth: MapArray,
    u: FloatArray,
    v: FloatArray,
    along_u: FloatArray,
    along_v: FloatArray,
    reach: IntArray,
    sign: float,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Offset of the ridge nearest to each point, its height and its full width at half height.

    In steps of (along_u, along_v), looked for within `reach` (points,) steps. The offset is the
    middle between the two places at half height, so thin and thick bands are measured alike; NaN
    where there is none. The height is counted from the mean of the two ends.
    """
    rows, columns = smooth.shape
    n = len(u)
    offset, width = np.full(n, np.nan), np.full(n, np.nan)
    height = np.zeros(n)
    profile = np.empty(2 * reach.max() + 1)
    for i in range(n):
        r = reach[i]
        inside = True
        for q in range(-r, r + 1):
            a, b = u[i] + q * along_u[i], v[i] + q * along_v[i]
            col, row = math.floor(a), math.floor(b)
            if row < 0 or col < 0 or row >= rows - 1 or col >= columns - 1:
                inside = False
                break
            fa, fb = a - col, b - row
            profile[q + r] = sign * (
                (smooth[row, col] * (1 - fa) + smooth[row, col + 1] * fa) * (1 - fb)
                + (smooth[row + 1, col] * (1 - fa) + smooth[row + 1, col + 1] * fa) * fb
            )
        if not inside:
            continue
        floor = 0.5 * (profile[0] + profile[2 * r])
        best, where = 0.0, 0
        for q in range(1, 2 * r):
            if profile[q] >= profile[q - 1] and profile[q] >= profile[q + 1]:
                worth = (profile[q] - floor) * (1.0 - 0.5 * abs(q - r) / r)
                if worth > best:
                    best, where = worth, q
        if where == 0:
            continue
        half = floor + 0.5 * (profile[where] - floor)
        left = where
        while left > 0 and profile[left] > half:
            left -= 1
        right = where
        while right < 2 * r and profile[right] > half:
            right += 1
        if profile[left] > half or profile[right] > half:
            continue
        low = left + (half - profile[left]) / (profile[left + 1] - profile[left])
        high = right - (half - profile[right]) / (profile[right - 1] - profile[right])
        offset[i] = 0.5 * (low + high) - r
        width[i] = high - low
        height[i] = profile[where] - floor
    return offset, height, width
