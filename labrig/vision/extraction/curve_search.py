"""Search for the sheet in one image: along an earlier curve, or from the clamp."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.checks.sheet_end import SheetEnd
from labrig.vision.checks.verdict import check_curve
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.curve.background_lines import BackgroundLine, hidden_by
from labrig.vision.curve.shape import CurveShape, make_shape
from labrig.vision.extraction.refinement import CurveCandidate, Refiner
from labrig.vision.fit.context import CrossSection
from labrig.vision.fit.curve_fit import fit_intensities, fit_points
from labrig.vision.image.image import GreyImage
from labrig.vision.image.mask import polygon_mask
from labrig.vision.search.ridge_tracing import RidgeMaps, Trace, ridge_maps, trace_from_clamp
from labrig.vision.search.straight_lines import OUTSIDE_DISTANCE_PX, find_branches, find_wires
from labrig.vision.thresholds import BROAD_SCORE_MIN, LINE_LENGTH_MIN_PX

FloatArray = npt.NDArray[np.float64]

MASK_MARGIN_PX = 3.0
# of one image, so that a refusal costs little:
BROAD_MAX = 1  # broad searches
QUICK_WIDTH, BROAD_WIDTH = 90, 500  # states that a search keeps
RIVALS_MAX = 3  # other paths than the likeliest
HEAD_MARGIN = 0.1  # of a share, in which a rival's first part may be seen better
SOMETHING_SHARE = 0.1  # of a curve, for it to be looked at further
LINE_ROUNDS = 2  # of finding lines beside the best curve, and searching without them


class CurveSearch(Refiner):
    """The search of one image for the sheet: where it may be, and which of these paths it is."""

    def __init__(self, image: GreyImage, optics: Optics, strip: StripGeometry) -> None:
        super().__init__(image, optics, strip)
        self.roll_mask = self.mask
        self.wires: tuple[BackgroundLine, ...] = ()
        self.led_by_lines = False  # whether a path that looked best ran with one
        self.broad = 0  # broad searches, which cost several times a quick one
        self.rivals = 0  # other paths that were searched
        self.known_sign = 0.0  # the polarity, once it is known

    def follow(self, start: NeutralCurve) -> CurveCandidate | None:
        """Return the curve near an earlier one; None where the sheet is no longer there."""
        if len(start.parameters) != self.basis.size:
            return None
        self._leave_out(start.wires)
        context = self.context(1.0 if start.polarity == "bright" else -1.0)
        shape = self._shape_of(start)
        beyond = self.beyond()
        half = np.where(beyond, start.elongation_width_px / 2, self.thickness_px / 2)
        section = CrossSection(
            half_width=half,
            blur=start.blur_px,
            elongation=beyond,
            side_face=start.side_face_px[1:].copy(),
            side_face_share=start.side_face_share,
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
                converged_px=0.02,
            )
            found = CurveCandidate(
                fit=fit,
                context=context,
                sheet_end=SheetEnd(None),
                verdict=check_curve(fit, context, SheetEnd(None), followed=True),
            )
            good = found.verdict.covered > start.covered - 0.04
            if good and not found.verdict.why and fit.step_px < 0.1:
                return self.led_by_edges(found)
        return None

    def _shape_of(self, curve: NeutralCurve) -> CurveShape:
        """Return a reported curve as a shape to start from."""
        ppm, heading = self.optics.px_per_m, self.optics.clamp_angle_rad
        parameters = curve.parameters.copy()
        parameters[0] *= ppm
        parameters[2:] /= ppm
        sideways = np.array([-math.sin(heading), math.cos(heading)])
        first = np.array([curve.x_m[0], curve.y_m[0]]) * ppm
        return make_shape(self.basis, first - parameters[0] * sideways, heading, parameters)

    def search(self) -> CurveCandidate | None:
        """Return the best curve from the clamp on; None where no path leaves it."""
        self._leave_out(())
        best = self._best_of_searches()
        for _ in range(LINE_ROUNDS):
            before = self.wires
            # where next to nothing is seen of any path, no line led it
            if best is None or best.verdict.covered < SOMETHING_SHARE:
                break
            if not self._leaves_out_lines(best):
                break
            again = self._best_of_searches(best)
            if (again is None or again.verdict.why) and self._is_the_sheet_itself(best):
                self._leave_out(before)
                break
            best = again
        return best

    def _is_the_sheet_itself(self, best: CurveCandidate) -> bool:
        """Return whether the wire along the best curve can only be the sheet's own end.

        Its end is seen where the sheet's should be, and nothing continues there.
        """
        nodes, reach = best.context.nodes_px(best.fit.shape), best.fit.section.reach
        along = [wire for wire in self.wires if wire.runs_with(nodes, reach)]
        return best.confirmed and all(wire.ends_with(nodes) for wire in along)

    def _best_of_searches(self, known: CurveCandidate | None = None) -> CurveCandidate | None:
        """Return the best of a quick search, and of a broader one where none passes.

        `known`: of a search before wires were hidden; it may be right but for those.
        """
        found = []
        if known is not None:
            found = [self.improved(known.fit.shape, known.context.sign)]
            self.known_sign = known.context.sign
            if known.confirmed and found[0].confirmed:
                return found[0]  # what is left of a wire might explain more than a gap in the sheet
        found += self._candidates(width=QUICK_WIDTH, hasty=True)
        if all(c.verdict.why for c in found) and self.broad < BROAD_MAX:
            self.broad += 1
            found += self._candidates(width=BROAD_WIDTH, hasty=False)
        best = max(found, key=lambda c: c.rank, default=None)
        if known is not None and best is not None and best.verdict.why:
            # its reason explains more than that of a path beside the wires
            return known if known.verdict.why else found[0]
        return best

    def _leaves_out_lines(self, best: CurveCandidate) -> bool:
        """Return whether there are more wires where the sheet may be.

        Their pixels are not used then.
        """
        sign, nodes = best.context.sign, best.context.nodes_px(best.fit.shape)
        reach, clamp = best.fit.section.reach, np.array(self.optics.clamp_px)
        scale = self.ridges.scale
        least, apart = LINE_LENGTH_MIN_PX * scale, reach + OUTSIDE_DISTANCE_PX * scale
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
            self._leave_out((*self.wires, *wires))
            self.led_by_lines |= any(wire.runs_with(nodes, reach) for wire in wires)
        return bool(wires)

    def _leave_out(self, wires: tuple[BackgroundLine, ...]) -> None:
        """Use none of the pixels of these lines, and those of all others again."""
        self.wires = wires
        if wires:
            self.mask = np.maximum(self.roll_mask, hidden_by(wires, self.mask.shape))
        else:
            self.mask = self.roll_mask

    def _candidates(self, *, width: int, hasty: bool) -> list[CurveCandidate]:
        """Return a curve for each polarity that is possible.

        `hasty`: leave out the unlikely one.
        """
        wide = self.strip.elongation_m > 0 or not hasty
        ridges = ridge_maps(self.image, self.thickness_px, wide=wide)
        if self.wires:
            ridges.hide(hidden_by(self.wires, self.mask.shape))
        if self.optics.mask_px:
            # a ridge map shows the border of what is masked as far as its filter reaches
            ridges.hide(polygon_mask(self.optics, self.image.grey.shape, MASK_MARGIN_PX))
        self.ridges = ridges
        signs = {"bright": [1.0], "dark": [-1.0], "auto": [1.0, -1.0]}[self.optics.polarity]
        if self.known_sign:
            signs = [self.known_sign]
        elif hasty and len(signs) == 2:
            signs = self._likely_signs(ridges, signs)
        found = []
        for sign in signs:
            trace = trace_from_clamp(ridges, self.optics, self.strip, sign, width=width)
            # the quick search's curve gives the reason, where nothing better is seen
            if trace is not None and (hasty or trace.score >= BROAD_SCORE_MIN):
                found.append(self.refine(trace, sign))
                if not found[-1].confirmed:
                    enough = 0.75 if found[-1].verdict.why else 0.7
                    found += self._rivals(ridges, trace, found[-1], width, enough)
        return found

    def _rivals(
        self, ridges: RidgeMaps, trace: Trace, first: CurveCandidate, width: int, enough: float
    ) -> list[CurveCandidate]:
        """Return other paths that the sheet may take where a wire may have been followed."""
        used, sign = first.fit.used, first.context.sign
        for share in (0.7, 0.45):
            head = float(used[: round(share * len(used))].mean())
            if share * head + 1 - share < enough - HEAD_MARGIN or self.rivals >= RIVALS_MAX:
                continue  # they share its first part: it could not be seen enough
            self.rivals += 1
            tail = trace.path[round(share * len(trace.path)) :]
            with ridges.without(tail, 1.5 + 0.5 * self.thickness_px):
                rival = trace_from_clamp(ridges, self.optics, self.strip, sign, width=width)
            if rival is not None:
                other = self.refine(rival, sign)
                # a wiped stretch is no excuse for a curve that is hardly seen
                if other.confirmed and other.verdict.covered > enough:
                    return [other]
        return []

    def _likely_signs(self, ridges: RidgeMaps, signs: list[float]) -> list[float]:
        """Return the polarities worth tracing, from a short search at the clamp."""
        short = [
            trace_from_clamp(ridges, self.optics, self.strip, s, share=0.35, width=40)
            for s in signs
        ]
        scores = [trace.score if trace else -1.0 for trace in short]
        best = max(scores)
        return [s for s, score in zip(signs, scores, strict=True) if score > best - 0.25]
