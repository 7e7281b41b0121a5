"""The printable calibration board: a ChArUco board, as a PDF at its true size."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.errors import BadInputError

FloatArray = npt.NDArray[np.float64]

POINTS_PER_MM = 72 / 25.4


@dataclass(frozen=True)
class Board:
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
        """OpenCV's object for a ChArUco board; lengths in mm."""
        import cv2

        words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_250)
        return cv2.aruco.CharucoBoard(
            (self.columns, self.rows), self.square_mm, self.marker_mm, words
        )

    def corners_mm(self) -> FloatArray:
        """The inner corners (n, 2), row by row, x to the right and y down."""
        v, u = np.mgrid[1 : self.rows, 1 : self.columns]
        return np.stack([u.ravel(), v.ravel()], axis=1) * self.square_mm

    def picture(self, px_per_mm: int = 20) -> npt.NDArray[np.uint8]:
        """The board as pixels, for looking and for tests; without a margin."""
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


def write_board_pdf(path: Path, board: Board) -> None:
    """One page with the board at its true size, and a ruler to check the printer's scale."""
    dots = 8  # per mm; every edge of the markers falls on a whole dot below
    picture = board.picture(dots * 5)[2::5, 2::5]
    width, height = board.columns * board.square_mm, board.rows * board.square_mm
    page_w, page_h = width + 30, height + 40
    where = f"{width * POINTS_PER_MM:.4f} 0 0 {height * POINTS_PER_MM:.4f}"
    left, bottom = 15 * POINTS_PER_MM, 25 * POINTS_PER_MM
    marks = [f"q {where} {left:.4f} {bottom:.4f} cm /Board Do Q", "0.2 w"]
    ruler_mm = int(min(100, width))
    for mm in range(ruler_mm + 1):
        x, tall = left + mm * POINTS_PER_MM, (4 if mm % 10 == 0 else 2) * POINTS_PER_MM
        base = 15 * POINTS_PER_MM
        marks.append(f"{x:.4f} {base:.4f} m {x:.4f} {base + tall:.4f} l S")
    note = (
        f"{board.columns} x {board.rows} squares of {board.square_mm:g} mm, markers "
        f"{board.marker_mm:g} mm. Print at 100 %; the ruler is {ruler_mm} mm long: measure it."
    )
    marks.append(f"BT /F 7 Tf {left:.2f} {8 * POINTS_PER_MM:.2f} Td ({note}) Tj ET")
    _write_pdf(path, picture, "\n".join(marks), page_w, page_h)


def _write_pdf(
    path: Path, picture: npt.NDArray[np.uint8], content: str, width_mm: float, height_mm: float
) -> None:
    import zlib

    rows, columns = picture.shape
    pixels = zlib.compress(picture.tobytes())
    box = f"[0 0 {width_mm * POINTS_PER_MM:.3f} {height_mm * POINTS_PER_MM:.3f}]"
    resources = "<< /XObject << /Board 5 0 R >> /Font << /F 6 0 R >> >>"
    objects = [
        b"<< /Type /Catalog /Pages 2 0 R >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R /MediaBox {box} /Contents 4 0 R "
        f"/Resources {resources} >>".encode(),
        f"<< /Length {len(content)} >>\nstream\n{content}\nendstream".encode("ascii"),
        (
            f"<< /Type /XObject /Subtype /Image /Width {columns} /Height {rows} /ColorSpace "
            f"/DeviceGray /BitsPerComponent 8 /Filter /FlateDecode /Length {len(pixels)} >>\n"
            "stream\n"
        ).encode()
        + pixels
        + b"\nendstream",
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>",
    ]
    out = bytearray(b"%PDF-1.4\n")
    places = []
    for number, text in enumerate(objects, start=1):
        places.append(len(out))
        out += f"{number} 0 obj\n".encode() + text + b"\nendobj\n"
    start = len(out)
    out += f"xref\n0 {len(objects) + 1}\n0000000000 65535 f \n".encode()
    for place in places:
        out += f"{place:010d} 00000 n \n".encode()
    out += (
        f"trailer << /Size {len(objects) + 1} /Root 1 0 R >>\nstartxref\n{start}\n%%EOF\n".encode()
    )
    path.write_bytes(bytes(out))
