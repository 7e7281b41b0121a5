"""From a possible path of the sheet to a curve: fit it to the image and check it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics, SheetAppearance
from labrig.vision.checks.sheet_end import SheetEnd, find_sheet_end
from labrig.vision.checks.verdict import Verdict, check_curve
from labrig.vision.curve import StripGeometry, smallness
from labrig.vision.curve.shape import CurveShape, ShapeBasis, coefficients_for, make_basis
from labrig.vision.fit.context import CrossSection, FitContext, roll_mask
from labrig.vision.fit.curve_fit import (
    CurveFit,
    fit_intensities,
    fit_points,
    led_by,
    ridge_points,
    spectral_of,
)
from labrig.vision.fit.edges import middle_of_edges
from labrig.vision.fit.occlusion import see_through_cells
from labrig.vision.fit.side_face import SideFaceSearch
from labrig.vision.image.image import GreyImage
from labrig.vision.search.ridge_tracing import Trace, shape_through
from labrig.vision.thresholds import COVERED_SHARE_GOOD

LONGEST_STEP_M = 0.45e-3  # between the points of a usual strip's curve, or a larger one's
SIDE_FACE_ROUNDS = 3
EDGE_ROUNDS = 3
LENGTH_SIGMA_PX = 0.5  # the stated length, as it shows in the image

FACES_OF_REFUSED_MAX = 1  # searches for a side face beside curves that are refused without one
FACE_START_SHARE = 0.6  # of the first eighth of such a curve: a face hides no start


@dataclass(frozen=True, eq=False, kw_only=True)
class CurveCandidate:
    """A fitted curve and its verdict."""

    fit: CurveFit
    context: FitContext
    sheet_end: SheetEnd
    verdict: Verdict
    wider_px: float = 0.0  # than it is thick: out of focus, or a face not (well) separated from it
    between_edges: bool = False  # of a thick strip, whatever light falls on it

    @property
    def confirmed(self) -> bool:
        """Whether it passes, continues behind what hides it, and ends where it should."""
        sheet_end, continuous = self.sheet_end, not self.verdict.join.doubtful
        return (
            not self.verdict.why
            and continuous
            and sheet_end.beyond_px is not None
            and not sheet_end.at_least
        )

    @property
    def rank(self) -> tuple[bool, bool, float]:
        """What passes comes first, then what ends where it should, then what explains most."""
        return not self.verdict.why, self.confirmed, self.verdict.worth


class Refiner:
    """Fits curves to one image."""

    def __init__(self, image: GreyImage, optics: Optics, strip: StripGeometry) -> None:
        self.image, self.optics, self.strip = image, optics, strip
        self.thickness_px = strip.thickness_m * optics.px_per_m
        free_px = strip.free_length_m * optics.px_per_m
        self.basis: ShapeBasis = make_basis(
            free_px,
            strip.length_m * optics.px_per_m,
            coefficients_for(free_px),
            LONGEST_STEP_M / max(1.0, smallness(strip.length_m)) * optics.px_per_m,
            straight_rest=strip.elongation_straight,
        )
        self.mask = roll_mask(optics, image.grey.shape)
        self.faces = 0  # searches for a side face, in this image

    def context(self, sign: float) -> FitContext:
        """Return the fit context for a sheet of this brightness against the background."""
        optics = self.optics
        return FitContext(
            image=self.image,
            optics=optics,
            sign=sign,
            prior=np.array([optics.clamp_sigma_px, optics.clamp_angle_sigma_rad]),
            spectral=spectral_of(optics, self.strip),
            mask=self.mask,
        )

    def beyond(self) -> npt.NDArray[np.bool_]:
        """Return (cells,) whether they are the elongation."""
        middle = 0.5 * (self.basis.s[1:] + self.basis.s[:-1])
        return np.asarray(middle > self.basis.free_px)

    def refine(self, trace: Trace, sign: float) -> CurveCandidate:
        """Return from a traced path to a judged curve."""
        shape = shape_through(trace, self.optics, self.basis, self.context(sign).spectral)
        return self.improved(shape, sign)

    def improved(self, shape: CurveShape, sign: float) -> CurveCandidate:
        """Return the curve near a first one, looked for again where parts of it were lost."""
        context = self.context(sign)
        half = self._elongation_half_width(shape, context)
        shape = fit_points(shape, context, half_width=half)
        beyond = self.beyond()
        section = CrossSection(
            half_width=np.where(beyond, half, self.thickness_px / 2),
            blur=1.0,
            elongation=beyond,
            side_face=np.zeros(len(beyond)),
        )
        best = self.judged(fit_intensities(shape, context, section), context)
        if best.verdict.covered < COVERED_SHARE_GOOD:
            # parts were lost: look for them further from the curve, now that most of it is known
            again = fit_points(best.fit.shape, context, half_width=half, reaches=(9, 7, 5, 4))
            other = self.judged(fit_intensities(again, context, best.fit.section), context)
            best = max(best, other, key=lambda c: c.verdict.worth)
            best = self._without_strangers(best)
        return self.led_by_edges(self._anchored(self._faced(best)))

    def led_by_edges(self, found: CurveCandidate) -> CurveCandidate:
        """Return the curve midway between a thick strip's edges, not in the middle of its light."""
        fit, context = found.fit, found.context
        if self.image.full_resolution is None or found.verdict.why:
            return found
        for _ in range(EDGE_ROUNDS):
            middle = middle_of_edges(fit, context)
            if middle is None:
                return found
            fit = led_by(fit, context, middle.offset_px, middle.sigma_px)
        verdict = check_curve(fit, context, found.sheet_end, followed=True, beside=False)
        if verdict.why:
            return found
        return replace(found, fit=fit, verdict=verdict, between_edges=True)

    def _without_strangers(self, found: CurveCandidate) -> CurveCandidate:
        """Return the curve without stretches that cannot be the sheet."""
        see_through = see_through_cells(found.fit)
        if not see_through.any():
            return found
        section = replace(found.fit.section, corrupted=see_through)
        return self.judged(fit_intensities(found.fit.shape, found.context, section), found.context)

    def _faced(self, plain: CurveCandidate) -> CurveCandidate:
        """Return the curve with the side face separated, where one is seen."""
        # a thicker sheet looks like one with a face as dark as its edge
        separable = self.strip.thickness_known or self.optics.look != SheetAppearance.AUTO
        if plain.verdict.covered < 0.5 or not separable:
            return plain
        # the dearest step: after some tries only for what passes without it
        if plain.verdict.why:
            used = plain.fit.used
            start = float(used[: max(1, len(used) // 8)].mean())
            if self.faces >= FACES_OF_REFUSED_MAX or start < FACE_START_SHARE:
                return plain
        self.faces += 1
        search = SideFaceSearch(plain.fit, plain.context)
        found, side_face = plain, search.first()
        for turn in range(SIDE_FACE_ROUNDS):  # the curve moves when the face is separated
            if side_face is None:
                # where the face led the curve, a sheet without one explains as much
                wider_px = float(np.hypot(search.wider_px, 2 * search.possible_bias_px))
                return replace(plain, wider_px=wider_px)
            section = side_face.on(found.fit.section, found.fit.shape)
            found = self.judged(
                fit_intensities(found.fit.shape, found.context, section), found.context
            )
            if turn < SIDE_FACE_ROUNDS - 1:
                side_face = search.again(found.fit, side_face)
        return replace(found, wider_px=2 * search.possible_bias_px)

    def judged(self, fit: CurveFit, context: FitContext) -> CurveCandidate:
        """Return a fit with its end and its verdict."""
        sheet_end = find_sheet_end(fit, context)
        return CurveCandidate(
            fit=fit,
            context=context,
            sheet_end=sheet_end,
            verdict=check_curve(fit, context, sheet_end),
        )

    def _anchored(self, found: CurveCandidate) -> CurveCandidate:
        """Move the start along the clamped sheet to the place that its visible end implies.

        The clamp's place is known to a pixel only, the length much better.
        """
        beyond, clamp = found.sheet_end.beyond_px, self.optics.clamp_sigma_px
        if beyond is None or abs(beyond) > 4 * clamp or found.verdict.why:
            return found
        known = clamp**2 / (clamp**2 + found.sheet_end.sigma_px**2 + LENGTH_SIGMA_PX**2)
        shape = found.fit.shape
        moved = shape.slid(known * beyond)
        fit = fit_intensities(
            moved, found.context, found.fit.section, rounds=3, contrast=found.fit.usual_contrast
        )
        # its end and its surroundings were checked: the line is the same
        verdict = check_curve(fit, found.context, found.sheet_end, followed=True, beside=False)
        return replace(found, fit=fit, verdict=verdict)

    def _elongation_half_width(self, shape: CurveShape, context: FitContext) -> float:
        """Return half the elongation's visible width, from its height's halves.

        The sheet's if none.
        """
        if self.strip.elongation_m == 0:
            return self.thickness_px / 2
        beyond = self.basis.s > self.basis.free_px
        reach = np.full(len(beyond), round(12 + 4 * self.thickness_px))
        _, _, width = ridge_points(shape, context, reach)
        seen = beyond & np.isfinite(width)
        if not seen.any():
            return self.thickness_px / 2
        # the blur of lens and smoothing makes a thin sheet look about 2.7 pixels wide
        full = float(np.median(width[seen]))
        return 0.5 * max(float(np.sqrt(max(full**2 - 2.7**2, 0.0))), self.thickness_px)
