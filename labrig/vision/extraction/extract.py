"""`neutral_curve`: one image in, the sheet's curve with its uncertainty out, or a reason."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.checks.acceptance import check_curve
from labrig.vision.checks.apparent_width import (
    corrupted_cells,
    excess_width_px,
    something_lies_along,
)
from labrig.vision.checks.lateral_bias import lateral_bias_px
from labrig.vision.checks.sheet_end import SheetEnd
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.curve.background_lines import BackgroundLine, hidden_by
from labrig.vision.curve.shape import CurveShape, make_shape
from labrig.vision.extraction.refinement import CurveCandidate, Refiner
from labrig.vision.fit.context import CrossSection
from labrig.vision.fit.curve_fit import fit_intensities, fit_points
from labrig.vision.fit.thickness import visible_thickness_m
from labrig.vision.image.downscaling import (
    downscaled_image,
    downscaled_optics,
    downscaling_factor,
    in_camera_pixels,
    scaled_curve,
)
from labrig.vision.image.image import GreyImage, ImageError, read_grey_image
from labrig.vision.search.ridge_tracing import RidgeMaps, Trace, ridge_maps, trace_from_clamp
from labrig.vision.search.straight_lines import BESIDE_PX, find_branches, find_wires
from labrig.vision.uncertainty.metric_curve import blamed, report, with_wires

FloatArray = npt.NDArray[np.float64]

BESIDE_CLAMP = (-12.0, -9.0, -6.0, -3.0, 0.0, 3.0, 6.0, 9.0, 12.0)
LEAST_DOUBLE_SCORE = 0.4
MOST_OF_A_REFLECTION = 0.5  # of the sheet's contrast: what shows more may be another sheet
MOST_EXCESS_PX = 6.0  # known to three pixels
MOST_EXCESS = 0.0135  # of the length, where there are many pixels
MOST_BRIDGED_SIGMA_PX = 1.2  # of a curve where what lies along the sheet was left out
LEAST_OF_A_WIRE_PX = 60.0
MOST_TURNS = 2  # of finding wires beside the best curve, and searching without them


def neutral_curve(
    image: npt.NDArray[Any],
    optics: Optics,
    strip: StripGeometry,
    *,
    start: NeutralCurve | None = None,
) -> NeutralCurve:
    """The neutral curve of the sheet in `image` (rows, columns), 8 or 16 bit grey.

    `start`: the curve of a image shortly before; it is followed, which is several times faster,
    and left for a search from the clamp where that does not lead to a curve that passes the
    self-check. What cannot be measured comes back with `ok` False and the reason, never raised.
    """
    try:
        grey_image = read_grey_image(image, optics)
    except ImageError as error:
        return NeutralCurve(ok=False, why=str(error))
    if not strip.thickness_known:
        seen_m = start.thickness_m if start is not None and start.ok else None
        strip = replace(strip, thickness_m=seen_m or visible_thickness_m(grey_image, optics, strip))
    by = downscaling_factor(strip.thickness_m * optics.px_per_m)
    if by == 1:
        return _found(grey_image, optics, strip, start)
    grey_image, optics = downscaled_image(grey_image, by), downscaled_optics(optics, by)
    start = scaled_curve(start, 1 / by) if start is not None else None
    return in_camera_pixels(_found(grey_image, optics, strip, start), by)


def _found(
    image: GreyImage, optics: Optics, strip: StripGeometry, start: NeutralCurve | None
) -> NeutralCurve:
    """The curve, or why there is none."""
    job = _Job(image, optics, strip)
    best = job.followed(start) if start is not None and start.ok else None
    if best is not None and start is not None:
        curve = report(best.fit, best.context, best.verdict, start.excess_px, start.lateral_bias_px)
        return replace(curve, wires=start.wires)
    best = job.cold()
    if best is None:
        return NeutralCurve(
            ok=False, why="no path that a sheet could take leaves the clamp; check clamp_px."
        )
    beside = 0.0 if best.verdict.why else job.strength_of_another(best)
    if beside > MOST_OF_A_REFLECTION:
        return NeutralCurve(
            ok=False,
            why="two sheets leave the clamp side by side, and nothing tells which is meant; take "
            "one away, or mask it in the image.",
        )
    if best.verdict.why:
        verdict = blamed(best.verdict) if job.led_by_wires else best.verdict
        return report(best.fit, best.context, verdict)
    excess = excess_width_px(best.fit, best.context)
    if something_lies_along(excess, best.fit):
        return job.bridged(best, excess)
    excess = np.maximum(excess, best.wider_px)
    if excess.max() > max(MOST_EXCESS_PX, MOST_EXCESS * job.basis.total_px):
        return NeutralCurve(
            ok=False,
            why=f"what was followed looks up to {excess.max():.1f} pixels wider than the sheet is "
            "thick, and nothing tells which part of it is the sheet's edge; light the edge, or "
            "check the sheet's thickness.",
        )
    # light on one side moves no edge
    bias_px = None if best.between_edges else lateral_bias_px(best.fit, best.context)
    curve = report(best.fit, best.context, best.verdict, excess, bias_px)
    if beside > 0:
        message = (
            f"something like the sheet, {beside:.0%} as strong, lies beside it, such as its "
            "reflection; the stronger of the two was taken"
        )
        curve = replace(curve, warnings=(*curve.warnings, message))
    return with_wires(curve, job.wires, image.grey.shape)


def _distance(candidate: CurveCandidate, nodes: FloatArray) -> FloatArray:
    """(nodes,) distance in the image, point by point along both curves."""
    gap = candidate.context.nodes_px(candidate.fit.shape) - nodes
    return np.asarray(np.hypot(gap[:, 0], gap[:, 1]))


class _Job(Refiner):
    """One image on its way to a curve: where the sheet may be, and which of that it is."""

    def __init__(self, image: GreyImage, optics: Optics, strip: StripGeometry) -> None:
        super().__init__(image, optics, strip)
        self.open_mask = self.mask
        self.wires: tuple[BackgroundLine, ...] = ()
        self.led_by_wires = False  # whether a path that looked best ran with one
        self.only = 0.0  # the polarity, once it is known

    def followed(self, start: NeutralCurve) -> CurveCandidate | None:
        """The curve near an earlier one; None when the sheet is not (quite) there any more."""
        if len(start.parameters) != self.basis.size:
            return None
        self._hide(start.wires)
        context = self.context(1.0 if start.polarity == "bright" else -1.0)
        shape = self._shape_of(start)
        beyond = self.beyond()
        half = np.where(beyond, start.elongation_width_px / 2, self.thickness_px / 2)
        section = CrossSection(
            half, start.blur_px, beyond, start.side_face_px[1:].copy(), start.side_face_share
        )
        found = None
        for reaches in ((), (6, 4)):  # a fast move must be caught by ridge points first
            near = fit_points(shape, context, half_width=half[-1], reaches=reaches)
            fit = fit_intensities(
                near,
                context,
                section,
                rounds=3,
                contrast=start.contrast,
                settled_px=0.02,
            )
            found = CurveCandidate(
                fit,
                context,
                SheetEnd(None),
                check_curve(fit, context, SheetEnd(None), followed=True),
            )
            good = found.verdict.covered > start.covered - 0.04
            if good and not found.verdict.why and fit.step_px < 0.1:
                return self.led_by_edges(found)
        return None

    def _shape_of(self, curve: NeutralCurve) -> CurveShape:
        """A reported curve as a shape to start from."""
        ppm, heading = self.optics.px_per_m, self.optics.clamp_angle_rad
        parameters = curve.parameters.copy()
        parameters[0] *= ppm
        parameters[2:] /= ppm
        sideways = np.array([-math.sin(heading), math.cos(heading)])
        first = np.array([curve.x_m[0], curve.y_m[0]]) * ppm
        return make_shape(self.basis, first - parameters[0] * sideways, heading, parameters)

    def cold(self) -> CurveCandidate | None:
        """The best curve without any idea where the sheet is."""
        self._hide(())
        best = self._searched()
        for _ in range(MOST_TURNS):
            before = self.wires
            if best is None or not self._hides_wires(best):
                break
            again = self._searched(best)
            if (again is None or again.verdict.why) and self._is_the_sheet(best):
                self._hide(before)
                break
            best = again
        return best

    def _is_the_sheet(self, best: CurveCandidate) -> bool:
        """Whether what looks like a wire along the best curve can only be the sheet's own end.

        Its end is seen where the sheet's should be, and nothing goes on there.
        """
        nodes, reach = best.context.nodes_px(best.fit.shape), best.fit.section.reach
        along = [wire for wire in self.wires if wire.runs_with(nodes, reach)]
        return best.confirmed and all(wire.ends_with(nodes) for wire in along)

    def _searched(self, known: CurveCandidate | None = None) -> CurveCandidate | None:
        """The best of a quick search, and of a broader one where none passes.

        `known`: of a search before wires were hidden; it may be right but for those.
        """
        found = []
        if known is not None:
            found = [self.improved(known.fit.shape, known.context.sign)]
            self.only = known.context.sign
            if known.confirmed and found[0].confirmed:
                return found[0]  # what is left of a wire might explain more than a gap in the sheet
        found += self._candidates(width=90, hasty=True)
        if all(c.verdict.why for c in found):
            found += self._candidates(width=800, hasty=False)
        best = max(found, key=lambda c: c.rank, default=None)
        if known is not None and best is not None and best.verdict.why:
            # its reason tells more than that of some path beside the wires
            return known if known.verdict.why else found[0]
        return best

    def _hides_wires(self, best: CurveCandidate) -> bool:
        """Whether there are more wires where the sheet may be; their pixels are not used then."""
        sign, nodes = best.context.sign, best.context.nodes_px(best.fit.shape)
        reach, clamp = best.fit.section.reach, np.array(self.optics.clamp_px)
        scale = self.ridges.scale
        least, apart = LEAST_OF_A_WIRE_PX * scale, reach + BESIDE_PX * scale
        crossing = find_wires(self.image, self.ridges, sign) if not self.wires else []
        found = find_branches(self.image, self.ridges, sign, nodes, best.fit.used, apart)
        # a lead from the clamp to the border that the sheet leaves looks like its face before
        faced = best.confirmed and best.fit.section.side_face_share > 0
        left = [wire for wire in crossing if faced and not wire.shows_at(nodes[-1])]
        wires = [
            wire
            for wire in crossing + found
            # where it does not run with the curve it must be seen, too
            if wire.length_beside_px(nodes, apart) > least
            and (wire in left or not wire.begins_at(clamp, least))
            and not (best.confirmed and wire.is_all_of(nodes, reach))
            and (best.verdict.why or wire.runs_with(nodes, reach))
        ]
        if wires:
            self._hide((*self.wires, *wires))
            self.led_by_wires |= any(wire.runs_with(nodes, reach) for wire in wires)
        return bool(wires)

    def _hide(self, wires: tuple[BackgroundLine, ...]) -> None:
        """Use no pixel of these any more."""
        self.wires = wires
        if wires:
            self.mask = np.maximum(self.open_mask, hidden_by(wires, self.mask.shape))
        else:
            self.mask = self.open_mask

    def _candidates(self, *, width: int, hasty: bool) -> list[CurveCandidate]:
        """A curve for each polarity that is possible; `hasty`: leave out the unlikely one."""
        wide = self.strip.elongation_m > 0 or not hasty
        ridges = ridge_maps(self.image, self.thickness_px, wide=wide)
        if self.wires:
            ridges.hide(hidden_by(self.wires, self.mask.shape))
        self.ridges = ridges
        signs = {"bright": [1.0], "dark": [-1.0], "auto": [1.0, -1.0]}[self.optics.polarity]
        if self.only:
            signs = [self.only]
        elif hasty and len(signs) == 2:
            signs = self._likely(ridges, signs)
        found = []
        for sign in signs:
            trace = trace_from_clamp(ridges, self.optics, self.strip, sign, width=width)
            if trace is not None:
                found.append(self.refine(trace, sign))
                if not found[-1].confirmed:
                    enough = 0.75 if found[-1].verdict.why else 0.7
                    found += self._rivals(ridges, trace, sign, width, enough)
        return found

    def strength_of_another(self, found: CurveCandidate) -> float:
        """Contrast of a second sheet that leaves the clamp, or close beside it, over the first's.

        0 where there is none.
        """
        nodes = found.context.nodes_px(found.fit.shape)
        half = float(found.fit.section.half_width.max())
        # at the clamp two sheets are one
        apart_from = len(nodes) // 12
        sign, optics, ridges = found.context.sign, self.optics, self.ridges
        with ridges.without(nodes[apart_from:], 2 + half + found.fit.section.blur):
            other = trace_from_clamp(
                ridges, optics, self.strip, sign, width=40, share=0.5, offsets=BESIDE_CLAMP
            )
            if other is None or other.score < LEAST_DOUBLE_SCORE:
                return 0.0
            # only now is the whole of it worth a fit; its own start stands for the clamp
            start = (float(other.path[0, 0]), float(other.path[0, 1]))
            moved = optics.model_copy(update={"clamp_px": start})
            trace = trace_from_clamp(ridges, moved, self.strip, sign, width=120)
        if trace is None:
            return 0.0
        job = _Job(self.image, moved, self.strip)
        second = job.refine(trace, sign)
        apart = _distance(second, nodes).max()
        if not second.confirmed or second.verdict.covered <= 0.8 or apart <= 4:
            return 0.0
        return second.fit.usual_contrast / found.fit.usual_contrast

    def bridged(self, found: CurveCandidate, excess: FloatArray) -> NeutralCurve:
        """The curve without the cells where something lies along the sheet.

        A refusal where the rest does not say to about a pixel where the sheet is.
        """
        before = found.fit.section.corrupted
        corrupted = corrupted_cells(excess)
        section = replace(
            found.fit.section, corrupted=corrupted if before is None else corrupted | before
        )
        fit = fit_intensities(found.fit.shape, found.context, section)
        again = self.judged(fit, found.context)
        if not again.verdict.why:
            excess = excess_width_px(fit, found.context)
            curve = report(fit, found.context, again.verdict, excess)
            loose = curve.sigma_m.max() * self.optics.px_per_m > MOST_BRIDGED_SIGMA_PX
            if not loose and not something_lies_along(excess, fit):
                message = "something lies along the sheet, such as a wire; it was left out there"
                return replace(curve, warnings=(*curve.warnings, message))
        return NeutralCurve(
            ok=False,
            why="something lies along the sheet and cannot be told from it, such as a wire; "
            "take it away, or mask it in the image.",
        )

    def _rivals(
        self, ridges: RidgeMaps, trace: Trace, sign: float, width: int, enough: float
    ) -> list[CurveCandidate]:
        """Other ways the sheet may go on, where a wire may have been taken for its end."""
        for share in (0.7, 0.45):
            tail = trace.path[round(share * len(trace.path)) :]
            with ridges.without(tail, 1.5 + 0.5 * self.thickness_px):
                rival = trace_from_clamp(ridges, self.optics, self.strip, sign, width=width)
            if rival is not None:
                other = self.refine(rival, sign)
                # a wiped stretch is no excuse for a curve that is hardly seen
                if other.confirmed and other.verdict.covered > enough:
                    return [other]
        return []

    def _likely(self, ridges: RidgeMaps, signs: list[float]) -> list[float]:
        """The polarities worth tracing, from a short search at the clamp."""
        short = [
            trace_from_clamp(ridges, self.optics, self.strip, s, share=0.35, width=40)
            for s in signs
        ]
        scores = [trace.score if trace else -1.0 for trace in short]
        best = max(scores)
        return [s for s, score in zip(signs, scores, strict=True) if score > best - 0.25]
