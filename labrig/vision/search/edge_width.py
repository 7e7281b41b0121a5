"""How thick a path's strip is, and how far it goes: the clearest pair of edges along it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from labrig.vision.image.image import GreyImage
from labrig.vision.search.beam_paths import END_RUN_SHARE, END_RUN_STEPS
from labrig.vision.search.located import Located, aside_px
from labrig.vision.search.straightened import resampled, slopes, smoothed, straightened
from labrig.vision.thresholds import END_PRESENT_RATIO

FloatArray = npt.NDArray[np.float64]
Point = tuple[float, float]

THINNEST_PX = 2.5
WIDTHS_COMPARED = 19
ONE_EDGE_BLURS = 6.0  # two edges further apart than so many blurs are not one
STATED_WIDTH_RATIOS = (0.75, 1.45)  # of the width that is seen to one that is stated
EDGE_BLUR_RATIO = 0.12  # of the width: what an edge is smoothed by
BORDER_PX = 10.0  # a strip that leaves the image is followed up to here


def measured_along(
    image: GreyImage,
    path: FloatArray,
    width: float,
    sign: float,
    *,
    fixed: float | None,
    clamp: Point,
) -> Located | None:
    """Return a path with the thickness that its edges show."""
    from labrig.vision.search.edge_pairs import OUTLIER_RATIO, edge_pairs  # numba: slow to import

    step = max(1.0, 0.25 * width)
    line = smoothed(resampled(path, step), round(2 * width / step))
    line, leaves = _inside(line, image.grey.shape)
    if len(line) < 8:
        return None
    unit = max(0.5, 0.1 * width)
    across = np.arange(-3.2 * width, 3.2 * width + unit / 2, unit)
    many = max(1, round(width / step))
    strip = straightened(image.grey, line, across)
    blocks = len(strip) // many
    if blocks < 4:
        return None
    rows = strip[: blocks * many].reshape(blocks, many, -1)
    profiles = rows.mean(axis=1)
    found = []
    low, high = (0.4, 2.2) if fixed is None else STATED_WIDTH_RATIOS
    slope, slope_blur = profiles, 0.0
    for wide in (fixed or width) * np.geomspace(low, high, WIDTHS_COMPARED):
        blur = max(0.8, EDGE_BLUR_RATIO * wide) / unit
        if max(blur, 1.0) != slope_blur:  # thin ones are all looked at through the same filter
            slope_blur = max(blur, 1.0)
            slope = slopes(profiles, slope_blur)
        shown, edges = edge_pairs(
            slope,
            wide / unit,
            int(0.7 * width / unit),
            opposite=bool(wide < ONE_EDGE_BLURS * blur * unit),
            run_blocks=END_RUN_STEPS,
            run_share=END_RUN_SHARE,
            present_ratio=END_PRESENT_RATIO,
        )
        found.append((shown, edges, wide, slope))
    _, edges, wide, slope = max(found, key=lambda each: each[0])
    if len(edges) < 4:
        return None
    beside = np.abs(slope[: len(edges), np.abs(across) > 1.2 * wide])
    texture = max(float(np.median(beside)) / 0.6745 if beside.size else 0.0, 1e-3)
    clear = float(np.mean(np.minimum(edges, OUTLIER_RATIO * np.median(edges))))
    if len(edges) < blocks:
        line, leaves = line[: len(edges) * many + 1], False
        profiles = profiles[: len(edges)]
    return Located(
        path_px=line,
        thickness_px=float(wide),
        edge=clear,
        leaves_image=leaves,
        sign=sign,
        clearness=clear / texture,
        likeness=_likeness(profiles, across, float(wide)),
        aside_px=aside_px(line, clamp),
        scale_px=max(width, THINNEST_PX),
    )


def _likeness(profiles: FloatArray, across: FloatArray, wide: float) -> float:
    """Return how alike the ground to both sides is, against how the strip differs from it."""
    out = (np.abs(across) > 0.6 * wide) & (np.abs(across) < 0.6 * wide + max(2.0, 0.3 * wide))
    left, right = (_mean(profiles[:, out & (sign * across > 0)]) for sign in (-1, 1))
    inside = _mean(profiles[:, np.abs(across) < 0.4 * wide])
    apart = np.abs(left - right)
    differs = np.abs(inside - left) + np.abs(inside - right)
    return float(1 - np.median(apart / np.maximum(np.maximum(differs, apart), 1e-9)))


def _mean(values: FloatArray) -> FloatArray:
    return np.asarray(np.where(np.isfinite(values), values, 0.0).mean(axis=1))


def _inside(line: FloatArray, shape: tuple[int, ...]) -> tuple[FloatArray, bool]:
    """Return a line up to where it comes near the border, and whether it does."""
    room = np.minimum(line, np.array([shape[1], shape[0]]) - 1 - line).min(axis=1)
    near = np.flatnonzero(room < BORDER_PX)
    begin = len(line) // 4  # a clamp may lie at the border
    late = near[near > begin]
    if len(late) == 0:
        return line, False
    return line[: late[0]], True
