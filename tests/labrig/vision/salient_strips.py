"""Maps of what stands out, drawn: a strip along a path, as a network would show it."""

from __future__ import annotations

import cv2
import numpy as np

SIZE = (240, 320)  # rows, columns
CLAMP = np.array([60.0, 120.0])


def arc(length: float = 160.0, turn: float = 1.2, places: int = 400) -> np.ndarray:
    """Return a path that leaves the clamp to the right and turns by an angle."""
    angle = np.linspace(0, turn, places)
    steps = length / (places - 1) * np.column_stack([np.cos(angle), np.sin(angle)])
    return CLAMP + np.vstack([[0, 0], np.cumsum(steps[:-1], axis=0)])


def strip_map(path: np.ndarray, width: float = 12.0, *things: tuple[int, int, int, int]):
    """Return the map of a strip with blunt ends, and of boxes (u, v, columns, rows)."""
    big = np.zeros((SIZE[0] * 4, SIZE[1] * 4), dtype=np.float32)
    along = np.gradient(path, axis=0)
    left = np.column_stack([-along[:, 1], along[:, 0]]) / np.hypot(*along.T)[:, None]
    outline = np.vstack([path + width / 2 * left, (path - width / 2 * left)[::-1]])
    cv2.fillPoly(big, [np.round((outline + 0.5) * 4 * 16).astype(np.int32)], 1.0, shift=4)
    for u, v, columns, rows in things:
        big[v * 4 : (v + rows) * 4, u * 4 : (u + columns) * 4] = 1.0
    small = cv2.resize(big, SIZE[::-1], interpolation=cv2.INTER_AREA)
    return cv2.GaussianBlur(small, (0, 0), 1.0)
