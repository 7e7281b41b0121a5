"""Fit a curve to sub-pixel ridge points, then to the intensities.

Both are Gauss-Newton on the curve's parameters, with a prior that curvature is smooth and with the
clamp's calibration as one on the first two parameters. For points a weak penalty
int (dk/ds)^2 ds / q is enough; with the intensities the image decides how smooth it is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import StripGeometry, smallness
from labrig.vision.curve.shape import CurveShape
from labrig.vision.curve.smoothness import JUMP_PRIORS, averaged, covariance
from labrig.vision.fit.context import WINDOW_CELLS, CrossSection, FitContext, measure_along
from labrig.vision.thresholds import (
    CELL_CONTRAST_MIN_SIGMAS,
    CELL_CONTRAST_RATIOS,
    NEIGHBOURS_USED_SHARE_MIN,
    PRESENT_SHARE_MIN,
    UNHIDDEN_SHARE_MIN,
)

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

# q in 1/m^3: curvature that wanders by 100 per m over 20 mm
SPECTRAL_PER_M3 = 5e5
POINT_NOISE_PX = 0.15
CONVERGED_STEP_PX = 0.008
CONVERGED_SECTION_PX = 0.03
NEIGHBOUR_CELLS = 12


def spectral_of(optics: Optics, strip: StripGeometry) -> float:
    """Return how much a strip's curvature changes along it, as assumed: q in 1/px^3."""
    return SPECTRAL_PER_M3 * (smallness(strip.length_m) / optics.px_per_m) ** 3


@dataclass(frozen=True, eq=False, kw_only=True)
class CurveFit:
    """A fitted curve, with the measurements of each cell."""

    shape: CurveShape
    section: CrossSection
    cells: FloatArray  # (cells, 12), see cross_section.measure
    present: FloatArray  # (cells,): share of the pixels beside the curve that are in the image
    used: BoolArray  # (cells,)
    noise: float  # grey levels, of a pixel, from the residuals
    normal: FloatArray  # (parameters, parameters): information of data and clamp prior
    pull: FloatArray  # (parameters,): normal @ (the parameters the data alone would take)
    step_px: float  # largest movement of the last iteration

    @property
    def contrast(self) -> FloatArray:
        """(cells,) grey levels, positive where the sheet is brighter."""
        return self.cells[:, 0]

    @cached_property
    def usual_contrast(self) -> float:
        """Its median size where the sheet is seen; 0 where it is nowhere."""
        seen = self.contrast[self.used]
        return float(np.median(np.abs(seen))) if len(seen) else 0.0

    @property
    def in_view(self) -> BoolArray:
        """(cells,): where nothing that is known to hide the sheet does."""
        return self.present > PRESENT_SHARE_MIN

    @property
    def covariance(self) -> FloatArray:
        """(parameters, parameters), from noise and clamp, smoothness included."""
        basis = self.shape.basis
        return covariance(self.normal, self.pull, basis.priors, basis.log_weight)

    @property
    def cautious_covariance(self) -> FloatArray:
        """The same for a curvature that may jump where nothing is seen of it."""
        basis = self.shape.basis
        priors, log_weight = basis.priors[JUMP_PRIORS], basis.log_weight[JUMP_PRIORS]
        return covariance(self.normal, self.pull, priors, log_weight)

    @property
    def offsets_px(self) -> tuple[FloatArray, FloatArray]:
        """Each cell's own measured distance from the curve, and its standard deviation."""
        information = np.maximum(self.cells[:, 3], 1e-12)
        return self.cells[:, 4] / information, self.noise / np.sqrt(information)


def seen_start(fit: CurveFit, context: FitContext) -> tuple[FloatArray, FloatArray]:
    """Return (2,) the sheet's own offset and angle at the start, and their covariance (2, 2).

    That is without the clamp's calibration.
    """
    normal = fit.normal.copy()
    # what is nowhere seen must not make this singular
    normal[[0, 1], [0, 1]] += np.array([1e-6, 1e-2]) - 1 / context.prior**2
    # at its root a sheet may curve more than where it is seen
    spectral = max(context.spectral, fit.shape.basis.free_px**-3)
    covariance = np.asarray(np.linalg.inv(penalised(normal, fit.shape, spectral)), dtype=np.float64)
    return (covariance @ fit.pull)[:2], covariance[:2, :2]


def spread(rows: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return (n,) standard deviation of rows (n, parameters) of what has a covariance."""
    return np.asarray(np.sqrt(((rows @ covariance) * rows).sum(axis=1)))


def penalised(normal: FloatArray, shape: CurveShape, spectral: float) -> FloatArray:
    """Return an information matrix with the smoothness prior added."""
    full = normal.copy()
    full[2:, 2:] += shape.basis.penalty / spectral
    # a constant curvature costs nothing; a curve that is nowhere seen must not make this singular
    full[2:, 2:] += 1e-6 * spectral ** (-2 / 3) * np.eye(len(full) - 2)
    return full


def solved(full: FloatArray, pull: FloatArray) -> FloatArray:
    """Return the parameters."""
    return np.asarray(np.linalg.solve(full, pull), dtype=np.float64)


def information(
    shape: CurveShape, modes: FloatArray, offset: FloatArray, weight: FloatArray, prior: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the normal matrix and right-hand side for the parameters themselves.

    Of sum weight (offset - modes (p - p_now))^2 + (p_0, p_1)^2 / prior^2.
    """
    normal = (modes * weight[:, None]).T @ modes
    pull = modes.T @ (weight * offset) + normal @ shape.parameters
    normal[0, 0] += 1 / prior[0] ** 2
    normal[1, 1] += 1 / prior[1] ** 2
    return normal, pull


def fit_points(
    shape: CurveShape,
    context: FitContext,
    *,
    half_width: float,
    reaches: tuple[int, ...] = (6, 5, 4),
) -> CurveShape:
    """Pull the curve onto the ridge's sub-pixel points, robustly, from further to nearer."""
    beyond = shape.basis.s > shape.basis.free_px
    for reach in reaches:
        extra = np.where(beyond, round(half_width), 0)
        offset, height, _ = ridge_points(shape, context, reach + extra)
        good = np.isfinite(offset) & (height > context.image.noise)
        if good.sum() < 12:
            break
        offset = np.where(good, offset, 0.0)
        weight = np.where(good, _tukey(offset, good), 0.0)
        weight *= np.minimum(1.0, height / (0.5 * np.median(height[good])))
        normal, pull = information(
            shape,
            shape.normal_modes(),
            offset,
            weight / POINT_NOISE_PX**2 / 3,  # neighbours share their noise
            context.prior,
        )
        shape = shape.moved(solved(penalised(normal, shape, context.spectral), pull))
    return shape


def ridge_points(
    shape: CurveShape, context: FitContext, reach: npt.NDArray[np.int64]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return offset, height and width of the ridge beside each node.

    See ridge_points.ridge_offsets.
    """
    from labrig.vision.search.ridge_points import ridge_offsets

    centre = context.nodes_px(shape)
    sideways = replace(shape, x=shape.x - np.sin(shape.phi), y=shape.y + np.cos(shape.phi))
    beside = context.nodes_px(sideways) - centre
    offset, height, width = ridge_offsets(
        context.image.smooth,
        centre[:, 0].copy(),
        centre[:, 1].copy(),
        beside[:, 0].copy(),
        beside[:, 1].copy(),
        reach.astype(np.int64),
        context.sign,
    )
    if not context.mask.any():
        return offset, height, width
    rows, columns = context.mask.shape
    place = centre + np.nan_to_num(offset)[:, None] * beside
    at = np.clip(np.round(place).astype(int), 0, [columns - 1, rows - 1])
    hidden = context.mask[at[:, 1], at[:, 0]] != 0
    return np.where(hidden, np.nan, offset), height, np.where(hidden, np.nan, width)


def _tukey(offset: FloatArray, good: BoolArray) -> FloatArray:
    spread = max(0.3, 1.48 * float(np.median(np.abs(offset[good]))))
    ratio = np.minimum(np.abs(offset) / (4.7 * spread), 1.0)
    return np.asarray((1 - ratio**2) ** 2)


def fit_intensities(
    shape: CurveShape,
    context: FitContext,
    section: CrossSection,
    *,
    rounds: int = 8,
    contrast: float | None = None,
    converged_px: float = CONVERGED_STEP_PX,
) -> CurveFit:
    """Fit the image's own intensities beside the curve, with blur and widths.

    `contrast`: of the sheet, where it is known from before. `converged_px`: the last step's size.
    """
    used = np.ones(len(section.half_width), dtype=bool)
    # before the first step the curve misses by more than the noise: allow a tenth of the sheet
    contrast = contrast or _contrast(shape, context, section)
    noise = max(context.image.noise, 0.1 * contrast)
    fit = _iteration(shape, context, section, noise, used)
    for _ in range(rounds - 1):
        before = fit.section
        fit = _iteration(fit.shape, context, _retuned(fit), fit.noise, fit.used)
        if fit.step_px < converged_px and fit.section.is_close_to(before, CONVERGED_SECTION_PX):
            break
    return fit


def _contrast(shape: CurveShape, context: FitContext, section: CrossSection) -> float:
    everywhere = np.ones(len(section.half_width), dtype=bool)
    cells, _ = measure_along(shape, context, section, 1e6, everywhere)
    return float(np.median(np.abs(cells[:, 0])))


def _retuned(fit: CurveFit) -> CrossSection:
    section = fit.section
    sheet = _newton(fit, ~section.elongation)
    ends = _newton(fit, section.elongation) if section.elongation.any() else 0.0
    blur = float(np.clip(section.blur + np.clip(sheet, -0.3, 0.3), 0.4, 6.0))
    half = float(np.clip(section.half_width[-1] + np.clip(ends, -0.4, 0.4), 0.5, 40.0))
    return section.with_look(blur, half)


def _newton(fit: CurveFit, where: BoolArray) -> float:
    table = fit.cells[fit.used & where]
    return float(table[:, 7].sum() / max(table[:, 8].sum(), 1e-9))


def _iteration(
    shape: CurveShape, context: FitContext, section: CrossSection, noise: float, used: BoolArray
) -> CurveFit:
    # far from all that is used, contrast and background come from the doubtful cells themselves
    measured_cells = used | ~_grown(used, WINDOW_CELLS)
    cells, present = measure_along(shape, context, section, noise, measured_cells)
    used = usable_cells(cells, present, context, section, noise)
    level = float(np.sqrt(cells[used, 5].sum() / max(cells[used, 6].sum(), 1.0)))
    # Tukey's weights shrink the residuals of pure noise by 6 %
    # and no lens draws a sheet just as the template has it
    contrast = float(np.median(np.abs(cells[used, 0]))) if used.any() else 0.0
    noise = max(level * 1.06, 0.3 * context.image.noise, _likeness(context, section) * contrast)
    return _moved(shape, context, section, cells, present, used, noise)


def led_by(fit: CurveFit, context: FitContext, beside: FloatArray, sigma: float) -> CurveFit:
    """Return the curve moved to a place measured otherwise than by intensities.

    `beside` (cells,): how far beside the curve; `sigma`: of each cell; both in pixels.
    """
    cells = fit.cells.copy()
    cells[:, 3] = (fit.noise / sigma) ** 2
    cells[:, 4] = beside * cells[:, 3]
    return _moved(fit.shape, context, fit.section, cells, fit.present, fit.used, fit.noise)


def _moved(
    shape: CurveShape,
    context: FitContext,
    section: CrossSection,
    cells: FloatArray,
    present: FloatArray,
    used: BoolArray,
    noise: float,
) -> CurveFit:
    """Return the curve moved by the distances of its cells from it."""
    weight = np.where(used, cells[:, 3], 0.0) / noise**2
    offset = np.clip(cells[:, 4] / np.maximum(cells[:, 3], 1e-12), -1.5, 1.5)
    modes = shape.normal_modes()
    middle = 0.5 * (modes[1:] + modes[:-1])
    normal, pull = information(shape, middle, offset, weight, context.prior)
    basis = shape.basis
    wanted = averaged(normal, pull, basis.priors, basis.log_weight)
    moved = middle @ (wanted - shape.parameters)
    return CurveFit(
        shape=shape.moved(wanted),
        section=section,
        cells=cells,
        present=present,
        used=used,
        noise=noise,
        normal=normal,
        pull=pull,
        step_px=float(np.abs(moved).max()),
    )


def _likeness(context: FitContext, section: CrossSection) -> float:
    """Return how well a sheet matches the template, as a share of its contrast.

    The wider a sheet shows, the more is seen of its frayed edges and its face's texture.
    """
    shown = context.image.downscaling * float(section.half_width[0])
    return float(np.clip(0.01 * shown, 0.01, 0.1))


def usable_cells(
    cells: FloatArray, present: FloatArray, context: FitContext, section: CrossSection, noise: float
) -> BoolArray:
    """Return where the sheet is really seen.

    Contrast of the usual sign and size, pixels that fit.
    """
    there = present > PRESENT_SHARE_MIN
    if section.corrupted is not None:
        there &= ~section.corrupted
    edge = round(2.5 * section.blur) + 1
    there[:edge] = False  # the clamp's blurred edge
    there[-edge:] = False  # and the sheet's own end
    contrast = context.sign * cells[:, 0]
    for part in (section.elongation, ~section.elongation):
        if (there & part).any():
            usual = float(np.median(contrast[there & part]))
            low, high = (ratio * usual for ratio in CELL_CONTRAST_RATIOS)
            there &= ~part | (contrast > low) & (contrast < high)
    there &= contrast > CELL_CONTRAST_MIN_SIGMAS * noise
    if there.sum() < 10:
        return there
    # what does not look like a sheet here, such as a roll's rim, would only pull the curve
    residual_squares = around(cells[:, 5], 2) / np.maximum(around(cells[:, 6], 2), 1.0)
    usual = max(float(np.median(residual_squares[there])), 1e-12)
    see_through = residual_squares > np.maximum(
        2.0 * usual, ((0.05 + _likeness(context, section)) * contrast) ** 2
    )
    lost = around(cells[:, 6], 2) < 0.6 * around(present * 2 * section.reach, 2)
    return _in_company(there & ~_grown(see_through | lost, 2), present)


def _in_company(good: BoolArray, present: FloatArray) -> BoolArray:
    """Return the cells without isolated ones in a gap: they are remains of what hides the sheet."""
    beside = _grown(present < UNHIDDEN_SHARE_MIN, 2)
    company = around(good.astype(float), NEIGHBOUR_CELLS)
    of = around(np.ones(len(good)), NEIGHBOUR_CELLS)
    return np.asarray(good & (~beside | (company > NEIGHBOURS_USED_SHARE_MIN * of)))


def around(values: npt.NDArray[Any], half: int) -> FloatArray:
    """Return sums over `half` cells to each side."""
    # "same" would be as long as the box where that is longer
    return np.convolve(values, np.ones(2 * half + 1))[half : half + len(values)]


def _grown(flags: BoolArray, by: int) -> BoolArray:
    return around(flags.astype(float), by) > 0.5
