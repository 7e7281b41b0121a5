"""The fit context: everything that stays the same while one image is fitted, and its pixels."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve.shape import CurveShape
from labrig.vision.image.image import GreyImage, plane_map
from labrig.vision.image.mask import polygon_mask

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]
MaskArray = npt.NDArray[np.uint8]
Pixels = tuple[FloatArray, FloatArray, npt.NDArray[np.int64]]  # values, distances, first of a cell

WINDOW_CELLS = 8  # contrast and background are taken from this many cells to each side
ROLL_MARGIN_PX = 2.5  # a roll's blurred rim


@dataclass(frozen=True, eq=False, kw_only=True)
class FitContext:
    """What stays the same during a fit."""

    image: GreyImage
    optics: Optics
    sign: float  # +1: the sheet is brighter
    prior: FloatArray  # (2,) standard deviations of clamp offset (px) and angle
    spectral: float  # q in 1/px^3
    mask: MaskArray  # (rows, columns): not 0 where rolls, wires or polygons hide the view

    def nodes_px(self, shape: CurveShape) -> FloatArray:
        """Return the curve's nodes in the image (nodes, 2)."""
        plane = np.stack([shape.x, shape.y], axis=1)
        return self.optics.world_to_pixel(plane / self.optics.px_per_m)


@dataclass(frozen=True, eq=False, kw_only=True)
class CrossSection:
    """How the sheet looks across: its width in each cell and the blur of its edges, pixels."""

    half_width: FloatArray  # (cells,)
    blur: float
    elongation: BoolArray  # (cells,): beyond the free length, where the width is not known
    side_face: (
        FloatArray  # (cells,): visible width of the side face, to the side of its sign; 0: none
    )
    side_face_share: float = 0.0  # its grey over the band's
    corrupted: BoolArray | None = None  # (cells,): where something lies along the sheet

    @property
    def reach(self) -> float:
        """How far beside the curve pixels are of use."""
        side_face = float(np.abs(self.side_face).max()) if self.side_face_share > 0 else 0.0
        return float(self.half_width.max()) + side_face + 3 * self.blur + 2.5

    def is_close_to(self, other: CrossSection, within: float) -> bool:
        """Return whether blur and widths differ by no more than `within`."""
        wider = float(np.abs(self.half_width - other.half_width).max())
        return max(wider, abs(self.blur - other.blur)) <= within

    def with_look(self, blur: float, elongation_half_width: float) -> CrossSection:
        """Return it with another blur and elongation width."""
        half = np.where(self.elongation, elongation_half_width, self.half_width)
        return replace(self, half_width=half, blur=blur)


def roll_mask(optics: Optics, shape: tuple[int, int]) -> MaskArray:
    """Return where the rolls and polygons named in the optics hide the view."""
    import cv2

    mask = polygon_mask(optics, shape)
    for u, v, radius in optics.rolls_px or ():
        centre = (round(u * 16), round(v * 16))
        cv2.circle(mask, centre, round((radius + ROLL_MARGIN_PX) * 16), 1, -1, cv2.LINE_8, 4)
    return mask


def measure_along(
    shape: CurveShape, context: FitContext, section: CrossSection, noise: float, used: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Measure the sheet along a curve: see `cross_section.measure`, and the share of pixels."""
    pixels = pixels_beside(shape, context, section.reach)
    share = np.diff(pixels[2]) / (2 * section.reach * shape.basis.step_px)
    return measured(pixels, section, noise, used), share


def pixels_beside(shape: CurveShape, context: FitContext, reach: float) -> Pixels:
    """Return the pixels within `reach` beside a curve: see cross_section.collect."""
    from labrig.vision.fit.cross_section import collect

    nodes = context.nodes_px(shape)
    return collect(
        context.image.grey,
        plane_map(context.optics, context.image.grey.shape),
        node_u=nodes[:, 0],
        node_v=nodes[:, 1],
        x=shape.x,
        y=shape.y,
        phi=shape.phi,
        k=shape.k,
        reach=reach,
        pixel_size=0.9,
        mask=context.mask,
    )


def measured(pixels: Pixels, section: CrossSection, noise: float, used: BoolArray) -> FloatArray:
    """Return the table of `cross_section.measure` for these pixels."""
    from labrig.vision.fit.cross_section import measure

    return measure(
        *pixels,
        half_width=section.half_width,
        blur=section.blur,
        window=WINDOW_CELLS,
        noise=noise,
        rounds=2,
        used=used.astype(float),
        widen=section.elongation.astype(float),
        side_face=section.side_face,
        side_face_share=section.side_face_share,
    )
