"""Draw curves over an image, readable at any size of the image."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.drawing import write_drawing
from labrig.vision.curve import NeutralCurve

Canvas = npt.NDArray[np.uint8]
LONG_SIDE_PX = (1000, 1800)  # of an overlay: small pictures are enlarged, large ones reduced
ZOOM_MIN = 2.0  # of a picture whose overlay is not too large then
TEXT_WIDTH_MIN_PX = 480  # a narrow picture has a margin beside it, so that text fits
LETTER_WIDTH_PX, LINE_HEIGHT_PX = 10, 20
RING_SHARE = 1 / 50  # radius of the ring where a curve was refused, over the long side
LINE_SHARE = 1 / 700  # a curve's width over the long side
SEEN, BRIDGED, TEXT = (40, 40, 255), (0, 220, 255), (90, 255, 90)  # blue, green, red
SUBPIXEL_BITS = 4


def write_overlay(path: Path, image: npt.NDArray[Any], *curves: NeutralCurve) -> None:
    """Write the picture with its curves, red where seen, yellow where not, and their figures."""
    rows, columns = image.shape[:2]
    low, high = LONG_SIDE_PX
    long_px = int(np.clip(ZOOM_MIN * max(rows, columns), low, high))
    canvas = picture_with(image, curves, long_px)
    write_drawing(path, _with_text(canvas, "; ".join(map(_figures, curves))))


def _figures(curve: NeutralCurve) -> str:
    if not curve.ok:
        return curve.why
    return f"covered {curve.covered:.0%}, residual {curve.residual_px:.3f} px"


def picture_with(
    image: npt.NDArray[Any], curves: Sequence[NeutralCurve], long_side_px: int, line_px: int = 1
) -> Canvas:
    """Return the picture (rows, columns, 3) in this size with the curves on it.

    Where a curve was refused for one place, that has a yellow ring.

    `line_px`: their least width.
    """
    import cv2

    zoom = long_side_px / max(image.shape[:2])
    rows, columns = (max(1, round(zoom * side)) for side in image.shape[:2])
    smooth = cv2.INTER_AREA if zoom < 1 else cv2.INTER_NEAREST
    canvas = _colour(np.asarray(cv2.resize(image, (columns, rows), interpolation=smooth)))
    thick = max(line_px, round(LINE_SHARE * long_side_px))
    for curve in curves:
        if curve.ok:
            _draw(canvas, curve, zoom, thick)
        elif curve.refused_at_px is not None:
            _draw_ring(canvas, curve.refused_at_px, zoom, thick)
    return canvas


def jpeg_bytes(canvas: Canvas, quality: int = 85) -> bytes:
    """Return a canvas as JPEG."""
    import cv2

    _, data = cv2.imencode(".jpg", canvas, [int(cv2.IMWRITE_JPEG_QUALITY), quality])
    return bytes(data.tobytes())


def _draw(canvas: Canvas, curve: NeutralCurve, zoom: float, thick: int) -> None:
    import cv2

    places = ((curve.points_px + 0.5) * zoom - 0.5) * 2**SUBPIXEL_BITS
    nodes = [(int(u), int(v)) for u, v in np.round(places)]
    for first, second, seen in zip(nodes[:-1], nodes[1:], curve.seen, strict=False):
        colour = SEEN if seen else BRIDGED
        cv2.line(canvas, first, second, colour, thick, cv2.LINE_AA, SUBPIXEL_BITS)


def _draw_ring(canvas: Canvas, at_px: tuple[float, float], zoom: float, thick: int) -> None:
    import cv2

    u, v = ((place + 0.5) * zoom - 0.5 for place in at_px)
    radius = round(RING_SHARE * max(canvas.shape))
    cv2.circle(canvas, (round(u), round(v)), radius, BRIDGED, thick, cv2.LINE_AA)


def _with_text(canvas: Canvas, said: str) -> Canvas:
    """Return the canvas with a sentence below it."""
    import cv2

    size = max(1.0, max(canvas.shape) / LONG_SIDE_PX[0])
    width = max(canvas.shape[1], round(TEXT_WIDTH_MIN_PX * size))
    lines = textwrap.wrap(said, max(1, int(width / (LETTER_WIDTH_PX * size))))
    below = round(size * (LINE_HEIGHT_PX * len(lines) + LINE_HEIGHT_PX // 2))
    out = np.zeros((canvas.shape[0] + below, width, 3), np.uint8)
    out[: canvas.shape[0], : canvas.shape[1]] = canvas
    for k, line in enumerate(lines, 1):
        at = (round(size * LETTER_WIDTH_PX), canvas.shape[0] + round(size * LINE_HEIGHT_PX * k))
        cv2.putText(
            out, line, at, cv2.FONT_HERSHEY_SIMPLEX, fontScale=0.5 * size, color=TEXT,
            thickness=max(1, round(size)), lineType=cv2.LINE_AA,
        )  # fmt: skip
    return out


def _colour(image: npt.NDArray[Any]) -> Canvas:
    grey = image if image.ndim == 2 else image[:, :, :3]
    if grey.dtype != np.uint8:
        low, high = float(grey.min()), float(grey.max())
        grey = ((grey - low) * (255 / max(high - low, 1e-9))).astype(np.uint8)
    if grey.ndim == 2:
        grey = np.repeat(grey[:, :, None], 3, axis=2)
    return np.ascontiguousarray(grey)
