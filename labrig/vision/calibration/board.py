"""The printable calibration board: a ChArUco board, as a PDF at its true size."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.errors import BadInputError
from labrig.files import write_bytes

FloatArray = npt.NDArray[np.float64]

MM_PER_INCH = 25.4
DOTS_PER_MM = 40  # every edge of a marker is good to 0.0125 mm


@dataclass(frozen=True)
class CalibrationBoard:
    """A ChArUco board (`marker_mm` > 0), or a plain checkerboard (`marker_mm` = 0)."""

    columns: int = 12  # squares
    rows: int = 9
    square_mm: float = 5.0
    marker_mm: float = 3.6

    def __post_init__(self) -> None:
        if self.columns < 3 or self.rows < 3 or self.columns * self.rows > 400:
            raise BadInputError(
                f"the board has {self.columns} x {self.rows} squares; 3 x 3 to 400 are possible."
            )
        if not 0 <= self.marker_mm < self.square_mm <= 500:
            raise BadInputError(
                f"the board has squares of {self.square_mm:g} mm and markers of "
                f"{self.marker_mm:g} mm; a marker must be smaller than its square."
            )

    def opencv(self) -> Any:
        """Return OpenCV's object for a ChArUco board; lengths in mm."""
        import cv2

        words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_250)
        return cv2.aruco.CharucoBoard(
            (self.columns, self.rows), self.square_mm, self.marker_mm, words
        )

    def corners_mm(self) -> FloatArray:
        """Return the inner corners (n, 2), row by row, x to the right and y down."""
        v, u = np.mgrid[1 : self.rows, 1 : self.columns]
        return np.stack([u.ravel(), v.ravel()], axis=1) * self.square_mm

    def image(self, px_per_mm: int = 20) -> npt.NDArray[np.uint8]:
        """Return the board as pixels, for looking and for tests; without a margin."""
        size = (
            round(self.columns * self.square_mm * px_per_mm),
            round(self.rows * self.square_mm * px_per_mm),
        )
        if self.marker_mm > 0:
            return np.asarray(self.opencv().generateImage(size), dtype=np.uint8)
        v, u = np.mgrid[0 : size[1], 0 : size[0]]
        square = self.square_mm * px_per_mm
        dark = ((u // square).astype(int) + (v // square).astype(int)) % 2 == 0
        return np.where(dark, 0, 255).astype(np.uint8)


def write_board_pdf(path: Path, board: CalibrationBoard) -> None:
    """Write one page with the board at its true size, and a ruler to check the printer's scale."""
    from matplotlib.backends.backend_pdf import FigureCanvasPdf
    from matplotlib.figure import Figure

    width, height = board.columns * board.square_mm, board.rows * board.square_mm
    page_w, page_h = width + 30, height + 40
    figure = Figure(figsize=(page_w / MM_PER_INCH, page_h / MM_PER_INCH))
    page = figure.add_axes((0, 0, 1, 1))
    page.set_axis_off()
    # as it is, pixel by pixel: any smoothing would move the edges
    page.imshow(
        board.image(DOTS_PER_MM),
        cmap="gray",
        interpolation="none",
        extent=(15, 15 + width, 25, 25 + height),
    )
    ruler_mm = int(min(100, width))
    ticks = range(ruler_mm + 1)
    tops = [15 + (4 if mm % 10 == 0 else 2) for mm in ticks]
    page.vlines([15 + mm for mm in ticks], 15, tops, color="black", linewidth=0.2)
    note = (
        f"{board.columns} x {board.rows} squares of {board.square_mm:g} mm, markers "
        f"{board.marker_mm:g} mm. Print at 100 %; the ruler is {ruler_mm} mm long: measure it."
    )
    page.text(15, 8, note, fontsize=7)
    page.set(xlim=(0, page_w), ylim=(0, page_h), aspect="auto")
    page_file = io.BytesIO()  # the library's own error of a full disk is none of the disk's
    FigureCanvasPdf(figure).print_pdf(page_file)
    write_bytes(path, page_file.getvalue())
