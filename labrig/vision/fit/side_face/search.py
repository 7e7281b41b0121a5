"""The search for the side face beside a curve, and how far one that is not seen may pull it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from labrig.vision.fit.context import CrossSection, FitContext
from labrig.vision.fit.curve_fit import CurveFit
from labrig.vision.fit.side_face.face import SideFace
from labrig.vision.fit.side_face.pixels import SHIFT_MAX_PX, PixelsBeside, cells_to_explain
from labrig.vision.fit.side_face.residuals import PIECE_CELLS, BandResiduals
from labrig.vision.fit.side_face.simplex import lowest
from labrig.vision.thresholds import (
    CAMERA_TILT_CHI2_MAX,
    FOCUS_BLUR_MAX_PX,
    LIT_EDGE_FACE_MAX_RATIO,
    LOCAL_STRUCTURE_GAIN_MIN,
    SIDE_FACE_BIAS_MIN_PX,
    SIDE_FACE_COMMON_GAIN_RATIO,
    SIDE_FACE_COMMON_PIECES_SHARE,
    SIDE_FACE_GAIN_MIN,
    SIDE_FACE_GUESS_GAIN_MIN,
    THICKNESS_EXCESS_MAX_RATIO,
)

FloatArray = npt.NDArray[np.float64]

# to begin with: the sheet's width over the far edge's distance, and the face's grey over the
# edge's; a faint guess gains something with any face, a strong one only near the truth
SIDE_FACE_GUESSES = ((0.012, 0.15), (0.012, 0.6), (0.018, 0.9), (0.025, 0.2), (0.025, 0.8))
GUESS_PRIOR_PROBABILITY = 0.2  # the odds of each guess before the image is checked
DEPTH_RATIO_MIN, DEPTH_RATIO_MAX = 1e-4, 0.12
FACE_RATIO_MIN, FACE_RATIO_MAX = 0.02, 1.0
CENTRE_SIGMA_RATIO = 0.06  # of the image's width: how square the camera looks at the plane
BIAS_SIGMA_FACTOR = 2.0  # widths and greys of one pull are hard to tell apart
EVALUATIONS_MAX = 130
BLUR_MIN_PX = 0.5


class SideFaceSearch:
    """The search for the side face, from a curve that was fitted without one.

    That curve runs in the middle of edge and face together; one fitted with a face, on the edge.
    """

    def __init__(self, fit: CurveFit, context: FitContext) -> None:
        self.context, self.used = context, cells_to_explain(fit)
        self.residuals = BandResiduals(self.used, fit.noise)
        rows, columns = context.image.grey.shape
        optics = context.optics
        away = optics.vanishing_px((columns, rows))
        self.centre = optics.undistorted_to_world([away])[0] * optics.px_per_m
        self.spread = CENTRE_SIGMA_RATIO * columns
        self.silhouette = optics.look == "silhouette"
        self.most_share = LIT_EDGE_FACE_MAX_RATIO if optics.look == "lit_edge" else FACE_RATIO_MAX
        self.plain = replace(fit.section, side_face=np.zeros(len(fit.used)), side_face_share=0.0)
        self.seen = PixelsBeside(fit, context, self.plain.reach + SHIFT_MAX_PX, on_edge=False)
        self.nothing = self.residuals.squares(self.seen, self.plain, tuned=True, swinging=True)
        self.wider_px = 0.0  # than stated, as which the sheet looks without a face
        self.possible_bias_px = 0.0  # how far a face that is not seen may pull the curve
        self.guessed: tuple[list[SideFace], list[float]] = ([], [])  # and what each gains

    def first(self) -> SideFace | None:
        """Return the likeliest face beside the curve without one.

        None where that explains as much.
        """
        shown = [*SIDE_FACE_GUESSES, *self._beside_thin_elongation()]
        guesses = [self._guess(depth, self._allowed(share)) for depth, share in shown]
        gains = [float(self._gains(self.seen, side_face).sum()) for side_face in guesses]
        self.guessed = (guesses, gains)
        best = int(np.argmax(gains))
        if gains[best] < SIDE_FACE_GUESS_GAIN_MIN:
            self.possible_bias_px = self._possible_bias_px(guesses, gains)
            return None
        self._fit_without_face()
        return self._accepted(self.seen, self._refined(self.seen, guesses[best]))

    def again(self, fit: CurveFit, side_face: SideFace) -> SideFace | None:
        """Return the likeliest face beside the curve that was fitted with the last one."""
        seen = PixelsBeside(fit, self.context, self.seen.reach, on_edge=True)
        return self._accepted(seen, self._refined(seen, side_face))

    def _accepted(self, seen: PixelsBeside, side_face: SideFace) -> SideFace | None:
        """Return a face that explains enough, and more than one place; else None.

        `possible_bias_px` is then how well it is known, else how far the curve may be off without.
        """
        gains = self._gains(seen, side_face)
        total = float(gains.sum()) - self._prior_cost(side_face)
        common = float(np.sort(gains)[: round(SIDE_FACE_COMMON_PIECES_SHARE * len(gains))].sum())
        widespread = seen.on_edge or common > SIDE_FACE_COMMON_GAIN_RATIO * total
        least = (
            0.0 if seen.on_edge else SIDE_FACE_GAIN_MIN
        )  # on the edge it has been believed before
        if self._prior_cost(side_face) < CAMERA_TILT_CHI2_MAX and total > least and widespread:
            pull = seen.lateral_bias_px(side_face.on(self.plain, seen.shape))[self.used]
            relative_sigma = BIAS_SIGMA_FACTOR / float(np.sqrt(max(total, SIDE_FACE_GAIN_MIN)))
            self.possible_bias_px = float(np.sqrt(np.mean(pull**2))) * relative_sigma
            return side_face
        if not seen.on_edge and not self._may_be_local(gains):
            common = SIDE_FACE_COMMON_PIECES_SHARE * total
        gain = (
            SIDE_FACE_GAIN_MIN
            if seen.on_edge
            else min(total, common / SIDE_FACE_COMMON_PIECES_SHARE)
        )
        faces, gained = self.guessed
        self.possible_bias_px = self._possible_bias_px([side_face, *faces], [gain, *gained])
        return None

    def _may_be_local(self, gains: FloatArray) -> bool:
        """Return whether something in one place beside the sheet explains (pieces,) gains too.

        It is strong there, and it is not only an elongation, whose width nobody knows, that is
        indifferent.
        """
        beyond = self.plain.elongation[::PIECE_CELLS]
        indifferent = bool(beyond.any()) and float(gains[beyond].sum()) > -SIDE_FACE_GAIN_MIN
        return float(gains.sum()) > LOCAL_STRUCTURE_GAIN_MIN and not indifferent

    def _possible_bias_px(self, faces: Sequence[SideFace], gains: Sequence[float]) -> float:
        """Return how far faces that are not believed may have pulled the curve.

        RMS, by their odds.
        """
        odds = GUESS_PRIOR_PROBABILITY * np.exp(0.5 * np.minimum(gains, 2 * SIDE_FACE_GAIN_MIN))
        pulls = [
            self.seen.lateral_bias_px(side_face.on(self.plain, self.seen.shape))
            for side_face in faces
        ]
        square = [float(np.mean(np.square(pull[self.used]))) for pull in pulls]
        doubt = float(np.sqrt(odds @ square / (1 + odds.sum())))
        return doubt if doubt > SIDE_FACE_BIAS_MIN_PX else 0.0

    def _beside_thin_elongation(self) -> list[tuple[float, float]]:
        """Return the faces that an elongation as thick as the sheet, or half so, would show.

        As dark as the edge they change nothing of how it looks: only the free sheet can tell.
        """
        section = self.plain
        excess = 2 * float(section.half_width[-1] - section.half_width[0])
        if not section.elongation.any() or excess <= 0:
            return []
        unit = self._guess(DEPTH_RATIO_MIN, 1.0).widths(self.seen.shape)[section.elongation]
        depth = DEPTH_RATIO_MIN * excess / max(float(np.median(np.abs(unit))), 1e-6)
        if depth > DEPTH_RATIO_MAX:
            return []
        return [(depth, 0.9), (depth, 1.0), (0.5 * depth, 1.0)]

    def _allowed(self, share: float) -> float:
        return 1.0 if self.silhouette else min(share, self.most_share)

    def _guess(self, depth: float, share: float) -> SideFace:
        """Return a face, with the blur and the elongation's width that are left beside it."""
        section, centre = self.plain, (float(self.centre[0]), float(self.centre[1]))
        side_face = SideFace(depth=depth, share=share, centre=centre, blur=1.0, elongation_half=1.0)
        wide = np.abs(side_face.widths(self.seen.shape))
        thick = 2 * float(section.half_width[-1])
        if not section.elongation.any():
            # the fitted blur of a band of known width is led by its flanks: all of it is the face's
            more = float(np.mean(_spread(thick, wide, share)))
            half = thick / 2
        else:
            # nobody knows an elongation's width: what the face takes may be missing there
            wide = wide[section.elongation]
            half = max((thick - share * float(np.median(wide))) / 2, 0.5)
            own = (2 * half) ** 3 / 12 / (2 * half + share * wide)
            more = float(np.mean(own + _spread(2 * half, wide, share))) - thick**2 / 12
        blur = float(np.sqrt(max(section.blur**2 - more, BLUR_MIN_PX**2)))
        return replace(side_face, blur=blur, elongation_half=half)

    def _refined(self, seen: PixelsBeside, side_face: SideFace) -> SideFace:
        """Return the likeliest face, from a guess."""
        start = np.array(
            [
                np.log(side_face.depth),
                side_face.share,
                0,
                0,
                np.log(side_face.blur),
                side_face.elongation_half,
            ]
        )
        start[2:4] = (np.array(side_face.centre) - self.centre) / self.spread
        steps = np.array([0.3, -0.15, 0.4, 0.4, 0.15, 0.2])
        used = slice(0, 6 if self.plain.elongation.any() else 5)

        def unlikely(p: FloatArray) -> float:
            outside = max(0.0, p[1] - self.most_share) + max(0.0, FACE_RATIO_MIN - p[1])
            side_face = self._face(p)
            left = float(self.residuals.squares(seen, side_face.on(self.plain, seen.shape)).sum())
            return left + self._prior_cost(side_face) + 100.0 * float(outside)

        return self._face(lowest(unlikely, start, steps, used, EVALUATIONS_MAX))

    def _prior_cost(self, side_face: SideFace) -> float:
        off = (np.array(side_face.centre) - self.centre) / self.spread
        return float(off @ off)

    def _fit_without_face(self) -> None:
        """Give the band alone its best chance: a lens may blur, and an elongation may be thick.

        A sheet may be thicker than stated, and looks so far out of focus, where a lens draws discs.
        """
        plain = self.plain

        def section(p: FloatArray) -> CrossSection:
            low, high = [BLUR_MIN_PX, 0.5, 0.5], [6.0, 40.0, 40.0]
            blur, half, beyond = np.clip([np.exp(p[0]), p[1], p[2]], low, high)
            half = min(half, thickest)
            wide = replace(plain, half_width=np.full(len(self.used), half))
            return wide.with_look(float(blur), float(beyond))

        thin, beyond = float(plain.half_width[0]), float(plain.half_width[-1])
        thickest = (1 + THICKNESS_EXCESS_MAX_RATIO) * thin + max(
            0.0, plain.blur - FOCUS_BLUR_MAX_PX
        )
        start = np.array([np.log(plain.blur), thin, beyond])
        used = slice(0, 3 if plain.elongation.any() else 2)
        steps = np.array([-0.3, 0.5, 0.3])

        def unlikely(p: FloatArray) -> float:
            return float(self.residuals.squares(self.seen, section(p)).sum())

        best = section(lowest(unlikely, start, steps, used, 60))
        before, self.nothing = (
            self.nothing,
            self.residuals.squares(self.seen, best, tuned=True, swinging=True),
        )
        if float((before - self.nothing).sum()) > SIDE_FACE_GAIN_MIN:
            self.wider_px = max(0.0, 2 * (float(best.half_width[0]) - thin))
        self.plain = plain.with_look(best.blur, float(best.half_width[-1]))

    def _face(self, p: FloatArray) -> SideFace:
        x, y = self.centre + self.spread * p[2:4]
        blur = float(np.clip(np.exp(p[4]), BLUR_MIN_PX, 6.0))
        share = 1.0 if self.silhouette else float(np.clip(p[1], FACE_RATIO_MIN, self.most_share))
        depth = float(np.clip(np.exp(p[0]), DEPTH_RATIO_MIN, DEPTH_RATIO_MAX))
        return SideFace(
            depth=depth,
            share=share,
            centre=(float(x), float(y)),
            blur=blur,
            elongation_half=max(float(p[5]), 0.5),
        )

    def _gains(self, seen: PixelsBeside, side_face: SideFace) -> FloatArray:
        """Return (pieces,) what a face explains, twice the log-likelihood."""
        return self.nothing - self.residuals.squares(
            seen, side_face.on(self.plain, seen.shape), tuned=True
        )


def _spread(thick: float, wide: FloatArray, share: float) -> FloatArray:
    """Return the second moment of a sheet and its face about their middle, less the sheet's own.

    That is thick^3 / 12 over the grey of both.
    """
    grey = share * wide
    apart = thick * grey / (thick + grey) * ((thick + wide) / 2) ** 2
    return np.asarray((grey * wide**2 / 12 + apart) / (thick + grey))
