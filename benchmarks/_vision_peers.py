"""The peers' side of `vision_peers`: what else there is, each with what it can use of the scene.

Runs in the peers' environment and knows nothing of labrig: `python _vision_peers.py SCENES RESULT`,
both .npz files. Points that no method gave are an empty array.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import numpy as np

Points = np.ndarray
Scene = dict  # image, truth_px, clamp_px, bright


def threshold_skeleton(scene: Scene) -> Points:
    """Otsu, skeletonize, the longest path from the clamp, a smoothing spline."""
    from scipy.interpolate import splev, splprep
    from skimage.filters import gaussian, threshold_otsu
    from skimage.morphology import skeletonize

    image = gaussian(scene["image"].astype(float), 1)
    image = image if scene["bright"] else -image
    path = _longest_path(skeletonize(image > threshold_otsu(image)), scene["clamp_px"])
    if len(path) < 50:
        return np.empty((0, 2))
    spline, _ = splprep(path.T, s=len(path) * 0.25)
    return np.array(splev(np.linspace(0, 1, 450), spline)).T


def _longest_path(skeleton: np.ndarray, clamp: np.ndarray) -> Points:
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra
    from scipy.spatial import cKDTree

    v, u = np.nonzero(skeleton)
    if len(u) < 10:
        return np.empty((0, 2))
    points = np.stack([u, v], axis=1).astype(float)
    pairs = cKDTree(points).query_pairs(1.5, output_type="ndarray")
    length = np.hypot(*(points[pairs[:, 0]] - points[pairs[:, 1]]).T)
    graph = coo_matrix((length, pairs.T), shape=(len(points),) * 2)
    near = np.hypot(*(points - clamp).T)
    if near.min() > 12:
        return np.empty((0, 2))
    away, before = dijkstra(
        graph, directed=False, indices=int(near.argmin()), return_predecessors=True
    )
    away[~np.isfinite(away)] = -1
    at, path = int(away.argmax()), []
    while at >= 0:
        path.append(points[at])
        at = int(before[at])
    return np.array(path[::-1])


def snake(scene: Scene) -> Points:
    """Active contour, started from the truth displaced by 3 px: a generous start."""
    from skimage.filters import gaussian
    from skimage.segmentation import active_contour

    start = scene["truth_px"][::9] + np.array([0, 3.0])
    image = gaussian(scene["image"].astype(float) / 255, 2)
    line = 5.0 if scene["bright"] else -5.0
    found = active_contour(
        image, start[:, ::-1], alpha=0.01, beta=0.1, w_line=line, w_edge=0, gamma=0.01,
        boundary_condition="free",
    )  # fmt: skip
    return found[:, ::-1]


def steger(scene: Scene) -> Points:
    """ridge-detector (Steger): its longest line."""
    from ridge_detector import RidgeDetector

    detector = RidgeDetector(
        line_widths=[3], low_contrast=15, high_contrast=40, min_len=30,
        dark_line=not scene["bright"], estimate_width=False, extend_line=True, correct_pos=False,
    )  # fmt: skip
    detector.detect_lines(np.repeat(scene["image"][:, :, None], 3, axis=2))
    lines = [np.stack([np.asarray(c.col), np.asarray(c.row)], axis=1) for c in detector.contours]
    return max(lines, key=len, default=np.empty((0, 2)))


METHODS: dict[str, Callable[[Scene], Points]] = {
    "threshold_skeleton": threshold_skeleton,
    "snake": snake,
    "steger": steger,
}


def main(source: str, target: str) -> None:
    data = np.load(source)
    scenes = [
        {key: data[f"{key}_{i}"] for key in ("image", "truth_px", "clamp_px", "bright")}
        for i in range(int(data["count"]))
    ]
    out: dict[str, np.ndarray] = {}
    for name, method in METHODS.items():
        method(scenes[0])  # compiles and imports what it needs
        for i, scene in enumerate(scenes):
            began = time.process_time()
            try:
                points = method(scene)
            except (ValueError, IndexError, TypeError):
                points = np.empty((0, 2))
            out[f"{name}_{i}"] = points
            out[f"{name}_{i}_s"] = np.array(time.process_time() - began)
    np.savez_compressed(target, **out)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
