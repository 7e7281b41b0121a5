"""The corners of a calibration board in an image, to a few hundredths of a pixel."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.errors import BadInputError
from labrig.vision.calibration.board import CalibrationBoard
from labrig.vision.thresholds import BOARD_CORNERS_MIN

FloatArray = npt.NDArray[np.float64]


def find_corners(
    image: npt.NDArray[Any], board: CalibrationBoard, name: str
) -> tuple[FloatArray, FloatArray]:
    """Return corners in the board's mm (n, 2) and in the image's pixels (n, 2)."""
    grey = _eight_bit(image, name)
    found = _charuco(grey, board) if board.marker_mm > 0 else _checkerboard(grey, board)
    if found is None or len(found[0]) < BOARD_CORNERS_MIN:
        count = 0 if found is None else len(found[0])
        whole = "" if board.marker_mm > 0 else ", and that the whole checkerboard is in the image"
        raise BadInputError(
            f"{name}: only {count} corners of the {board.columns} x {board.rows} board were found, "
            f"{BOARD_CORNERS_MIN} are needed; check light, focus and the board's numbers{whole}."
        )
    return found


def _eight_bit(image: npt.NDArray[Any], name: str) -> npt.NDArray[np.uint8]:
    if not isinstance(image, np.ndarray) or image.size == 0 or image.ndim not in (2, 3):
        raise BadInputError(f"{name}: this is not an image.")
    if image.ndim == 3:
        image = image[:, :, :3].mean(axis=2)
    if image.dtype == np.uint8:
        return np.ascontiguousarray(image)
    values = image.astype(float)
    low, high = float(values.min()), float(values.max())
    return ((values - low) * (255 / max(high - low, 1e-9))).astype(np.uint8)


def _charuco(
    grey: npt.NDArray[np.uint8], board: CalibrationBoard
) -> tuple[FloatArray, FloatArray] | None:
    import cv2

    detector = cv2.aruco.CharucoDetector(board.opencv())
    corners, ids, _, _ = detector.detectBoard(grey)
    if ids is None or len(ids) == 0:
        return None
    which = np.asarray(ids).reshape(-1)
    pixels = np.asarray(corners, dtype=np.float32).reshape(-1, 2)
    return board.corners_mm()[which], _sharpened(grey, pixels, board)


def _checkerboard(
    grey: npt.NDArray[np.uint8], board: CalibrationBoard
) -> tuple[FloatArray, FloatArray] | None:
    import cv2

    size = (board.columns - 1, board.rows - 1)
    good, corners = cv2.findChessboardCornersSB(grey, size, flags=cv2.CALIB_CB_ACCURACY)
    if not good:
        return None
    return board.corners_mm(), np.asarray(corners, dtype=float).reshape(-1, 2)


def _sharpened(
    grey: npt.NDArray[np.uint8], pixels: npt.NDArray[np.float32], board: CalibrationBoard
) -> FloatArray:
    import cv2

    spacing = np.hypot(*(pixels[:, None] - pixels[None]).transpose(2, 0, 1))
    spacing[spacing == 0] = np.inf
    # a window that reached the markers would be biased by them
    margin = 0.5 * (board.square_mm - board.marker_mm) / board.square_mm
    half = int(np.clip(np.median(spacing.min(axis=1)) * margin * 0.8, 2, 9))
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 50, 1e-4)
    fine = cv2.cornerSubPix(grey, pixels.reshape(-1, 1, 2).copy(), (half, half), (-1, -1), stop)
    return np.asarray(fine, dtype=float).reshape(-1, 2)
