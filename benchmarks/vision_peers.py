"""The extractor beside what else there is, on the same pictures.

Peers live in an environment of their own (`pip install labrig scikit-image ridge-detector`); one
that is not installed is left out and said so. Each gets what it can use: the polarity, the clamp
and the sheet's width; its points are judged as ours are, and 'failed' is more than 1 px RMSE, no
curve, or less than 80 % of the sheet.
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable

import cv2
import numpy as np

from benchmarks.vision_extraction import parts
from benchmarks.vision_scenes import Recipe, Scene, make_scene, mixed, rmse_px
from labrig.vision import neutral_curve

Points = np.ndarray


def labrig_curve(scene: Scene) -> Points | None:
    curve = neutral_curve(scene.image, *parts(scene))
    return curve.points_px if curve.ok else None


def threshold_skeleton(scene: Scene) -> Points | None:
    """Otsu, skeletonize, the longest path from the clamp, a smoothing spline."""
    from scipy.interpolate import splev, splprep
    from skimage.filters import gaussian, threshold_otsu
    from skimage.morphology import skeletonize

    image = gaussian(scene.image.astype(float), 1)
    image = image if scene.recipe.bright else -image
    skeleton = skeletonize(image > threshold_otsu(image))
    path = _longest_path(skeleton, scene.optics["clamp_px"])
    if path is None or len(path) < 50:
        return None
    spline, _ = splprep(path.T, s=len(path) * 0.25)
    return np.array(splev(np.linspace(0, 1, 450), spline)).T


def _longest_path(skeleton: np.ndarray, clamp: list[float]) -> Points | None:
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra
    from scipy.spatial import cKDTree

    v, u = np.nonzero(skeleton)
    if len(u) < 10:
        return None
    points = np.stack([u, v], axis=1).astype(float)
    pairs = cKDTree(points).query_pairs(1.5, output_type="ndarray")
    length = np.hypot(*(points[pairs[:, 0]] - points[pairs[:, 1]]).T)
    graph = coo_matrix((length, pairs.T), shape=(len(points),) * 2)
    near = np.hypot(*(points - clamp).T)
    if near.min() > 12:
        return None
    away, before = dijkstra(
        graph, directed=False, indices=int(near.argmin()), return_predecessors=True
    )
    away[~np.isfinite(away)] = -1
    at, path = int(away.argmax()), []
    while at >= 0:
        path.append(points[at])
        at = int(before[at])
    return np.array(path[::-1])


def snake(scene: Scene) -> Points | None:
    """Active contour of skimage, started from the truth displaced by 3 px: a generous start."""
    from skimage.filters import gaussian
    from skimage.segmentation import active_contour

    start = scene.truth_px[::9] + np.array([0, 3.0])
    image = gaussian(scene.image.astype(float) / 255, 2)
    line = 1.0 if scene.recipe.bright else -1.0
    found = active_contour(
        image, start[:, ::-1], alpha=0.01, beta=0.1, w_line=line * 5, w_edge=0, gamma=0.01,
        boundary_condition="free",
    )  # fmt: skip
    return found[:, ::-1]


def steger(scene: Scene) -> Points | None:
    """ridge-detector (Steger); its longest line."""
    from ridge_detector import RidgeDetector

    detector = RidgeDetector(
        line_widths=[3], low_contrast=15, high_contrast=40, min_len=30,
        dark_line=not scene.recipe.bright, estimate_width=False, extend_line=True,
        correct_pos=False,
    )  # fmt: skip
    detector.detect_lines(cv2.cvtColor(scene.image, cv2.COLOR_GRAY2RGB))
    lines = [np.stack([np.asarray(c.col), np.asarray(c.row)], axis=1) for c in detector.contours]
    return max(lines, key=len, default=None)


PEERS: dict[str, tuple[str, Callable[[Scene], Points | None]]] = {
    "labrig": ("labrig", labrig_curve),
    "threshold + skeleton + spline": ("skimage", threshold_skeleton),
    "active contour": ("skimage", snake),
    "ridge-detector (Steger)": ("ridge_detector", steger),
}


def compare(count: int) -> None:
    plain = [make_scene(Recipe(seed=500 + s, physical=True)) for s in range(count)]
    rough = []
    for seed in range(count):
        try:
            rough.append(make_scene(mixed(seed)))
        except RuntimeError:
            continue
    print("| method | RMSE median px (plain, SNR 20) | failed plain | failed mixed | ms |")
    print("|---|---|---|---|---|")
    for name, (module, method) in PEERS.items():
        if importlib.util.find_spec(module) is None:
            print(f"| {name} | not installed | | | |")
            continue
        method(plain[0])
        began = time.process_time()
        errors = [_error(method, scene) for scene in plain]
        spent = (time.process_time() - began) / len(plain) * 1000
        hard = [_error(method, scene) for scene in rough]
        print(
            f"| {name} | {np.median(errors):.3f} | {np.mean(np.array(errors) > 1):.0%} | "
            f"{np.mean(np.array(hard) > 1):.0%} | {spent:.1f} |"
        )


def _error(method: Callable[[Scene], Points | None], scene: Scene) -> float:
    try:
        points = method(scene)
    except (ValueError, IndexError, TypeError):
        return float("inf")
    if points is None or len(points) < 2:
        return float("inf")
    covered = np.hypot(*(scene.truth_px[::20, None] - points[None]).transpose(2, 0, 1)).min(axis=1)
    return rmse_px(points, scene.truth_px) if np.mean(covered < 3) > 0.8 else float("inf")
