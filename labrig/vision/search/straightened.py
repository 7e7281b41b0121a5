"""Straighten the image along a path: rows along the path, columns across it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
MapArray = npt.NDArray[np.float32]


def resampled(path: FloatArray, step_px: float) -> FloatArray:
    """Return a path (n, 2) with places about `step_px` apart."""
    lengths = np.hypot(*np.diff(path, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    places = np.linspace(0, along[-1], max(2, round(float(along[-1]) / step_px) + 1))
    return np.stack([np.interp(places, along, path[:, axis]) for axis in (0, 1)], axis=1)


def smoothed(path: FloatArray, half: int) -> FloatArray:
    """Return a path without the steps of a search: means over `half` places to each side."""
    if half < 1 or len(path) < 3:
        return path
    half = min(half, (len(path) - 1) // 2)
    # mirrored at its ends, so that these stay where they are
    before = 2 * path[0] - path[half:0:-1]
    after = 2 * path[-1] - path[-2 : -half - 2 : -1]
    padded = np.concatenate([before, path, after])
    box = np.ones(2 * half + 1) / (2 * half + 1)
    return np.stack([np.convolve(padded[:, axis], box, mode="valid") for axis in (0, 1)], axis=1)


def distances(one: FloatArray, other: FloatArray) -> FloatArray:
    """Return (n, m) from each place of one path to each of another."""
    return np.asarray(np.hypot(*(one[:, None] - other[None]).transpose(2, 0, 1)))


def normals(path: FloatArray) -> FloatArray:
    """Return (n, 2) unit vectors to the right of a path in the image (u right, v down)."""
    along = np.gradient(path, axis=0)
    along /= np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-9)[:, None]
    return np.stack([-along[:, 1], along[:, 0]], axis=1)


def straightened(grey: MapArray, path: FloatArray, across_px: FloatArray) -> FloatArray:
    """Return (n, across) the grey values beside a path; NaN outside of the image."""
    import cv2

    places = path[:, None] + across_px[None, :, None] * normals(path)[:, None]
    places = places.astype(np.float32)
    return np.asarray(
        cv2.remap(
            grey,
            places[..., 0],
            places[..., 1],
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=float("nan"),
        ),
        dtype=np.float64,
    )


def slopes(profiles: FloatArray, blur_steps: float) -> FloatArray:
    """Return the slope across of profiles (n, across), smoothed by a Gaussian; in grey levels.

    A step between two levels gives its height.
    """
    reach = max(2, round(3 * blur_steps))
    t = np.arange(-reach, reach + 1) / blur_steps
    kernel = -t * np.exp(-t * t / 2)
    kernel /= np.abs(kernel[:reach]).sum()
    there = np.isfinite(profiles)
    filled, whole = profiles, bool(there.all())
    if not whole:
        mean = np.where(there, profiles, 0.0).sum(axis=1) / np.maximum(there.sum(axis=1), 1)
        filled = np.where(there, profiles, mean[:, None])
    rows, across = profiles.shape
    padded = np.empty((rows, across + 2 * reach))
    padded[:, :reach], padded[:, -reach:] = filled[:, :1], filled[:, -1:]
    padded[:, reach:-reach] = filled
    # np.convolve turns the kernel round, and so a rise is positive; all rows in one go are faster
    out = np.convolve(padded.ravel(), kernel, mode="same").reshape(rows, -1)[:, reach:-reach]
    return out if whole else np.where(there, out, 0.0)
