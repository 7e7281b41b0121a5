"""Measure a curve midway between a strip's two edges, block by block.

The fit of intensities takes a strip to be equally bright across and along. One that is shiny,
shaded on one half, ringed or short and thick is not: but its edges are where the image changes
most, to either brightness. A smooth curve is fitted to the middles of blocks
(`fit.outline_blocks`), and to what is stated of the strip.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve.shape import CurveShape
from labrig.vision.curve.smoothness import JUMP_PRIORS, averaged, covariance
from labrig.vision.fit.curve_fit import information, spread
from labrig.vision.fit.outline_blocks import (
    FRAY_HALF_BLOCKS,
    Blocks,
    measure_blocks,
    roughness,
    without_lonely,
)
from labrig.vision.fit.outline_profiles import running_middle
from labrig.vision.fit.stated_places import StatedPlaces, end_pull_px, likeliest_pull_px
from labrig.vision.image.image import GreyImage
from labrig.vision.search.work import OutlineWork
from labrig.vision.thresholds import (
    OUTLINE_PROFILE_SIGMA_MIN_PX,
    OUTLINE_PROFILE_SIGMA_RATIO,
    OUTLINE_PROFILE_SIGMA_THIN_RATIO,
    OUTLINE_SIGMA_MIN_PX,
    OUTLINE_SIGMA_MIN_RATIO,
    OUTLINE_TAPER_SHARES,
)

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

ROUNDS = 5
UNSEEN_TURN_MIN_RAD = 0.3  # that a straight strip may make along its length, unseen
GAP_WIDTHS = 1.5  # of a gap that a smooth curve leads over; in a longer one it may bend
MISFIT_HALF_BLOCKS = 1
TAPER_DEGREE = 4  # of the polynomial that a strip's width follows along it
TAPER_FROM = 0.08  # of the usual width: a smaller difference may be the light's
TAPER_RATIOS = (0.3, 1.25)  # wider is more often a shadow
TAPER_MIN_PX = 4.0  # a thinner part is looked at as one of that width
END_WIDTHS = 1.0  # along a strip: what lies beside its clamp and its tip
CLAMP_APART_SIGMAS = 1.5  # further from the stated clamp no edges are pulled
TIP_APART_SIGMAS = 3.0  # from a stated tip, which was looked at
CLAMP_SIGMA_MIN_PX = 3.0  # of a clamp that is clicked, across the strip
INDEPENDENT_BLOCKS = 4  # neighbouring blocks share texture and frays


@dataclass(frozen=True, eq=False, kw_only=True)
class OutlineFit:
    """A fitted curve with what was measured along it."""

    shape: CurveShape
    beside: CurveShape  # the one before it, beside which the blocks were measured
    taper: FloatArray  # (nodes,) see `fitted_taper`
    blocks: Blocks
    normal: FloatArray
    pull: FloatArray
    residual_px: float
    misfit_px: FloatArray  # (blocks,) from the curve to the middle, where it is seen
    width_scatter_px: float
    stated_node: IntArray  # of places on the strip that were stated
    stated_apart_px: float = 0.0  # RMS, by which they lie further aside than they are known to
    elsewhere_px: float | FloatArray = 0.0  # (nodes,): where another way is about as likely
    rival_px: FloatArray | None = None  # (2, nodes): see `fit.rival_edges`
    rival_near: FloatArray | None = None  # (nodes,) the likelihood of any there, 0 to 1

    def known_to(self, elsewhere_px: float | FloatArray) -> OutlineFit:
        """Return it where the strip may lie so far elsewhere."""
        return replace(self, elsewhere_px=elsewhere_px)

    @property
    def width_px(self) -> float:
        """The strip's usual width."""
        return float(np.median(self.blocks.width_px[self.blocks.by_edges]))

    @property
    def covariance(self) -> FloatArray:
        """(parameters, parameters); the curvature may jump where edges are long unseen."""
        basis = self.shape.basis
        priors, log_weight = basis.priors, basis.log_weight
        if self.blocks.longest_gap_px(basis.step_px) > GAP_WIDTHS * self.width_px:
            priors, log_weight = priors[JUMP_PRIORS], log_weight[JUMP_PRIORS]
        return covariance(self.normal, self.pull, priors, log_weight)

    @property
    def systematic_px(self) -> FloatArray:
        """(nodes,) what no averaging removes: which part of an edge's slope is the strip's edge.

        Where a strip looks thinner or thicker than elsewhere, it may taper, or one edge is not
        its own but that of light or shade on it. So it is where the width wanders along it, and
        where a second edge lies outside of one.
        """
        blocks = self.blocks
        at, wide = blocks.node[blocks.by_edges], blocks.width_px[blocks.by_edges]
        usual = self.width_px
        least = max(OUTLINE_SIGMA_MIN_PX, OUTLINE_SIGMA_MIN_RATIO * usual)
        few = running_middle(wide, FRAY_HALF_BLOCKS)
        apart = np.interp(np.arange(len(self.shape.x)), at, np.abs(few - usual))
        unsure = np.hypot(max(least, 0.5 * self.width_scatter_px), 0.5 * _wander(few))
        if self.rival_px is not None:  # if it is the strip's edge, the middle lies half as far out
            unsure = np.hypot(unsure, 0.5 * np.hypot(*self.rival_px))
        unsure = np.hypot(unsure, np.hypot(self.stated_apart_px, self.elsewhere_px))
        unsure = np.hypot(unsure, self._misfit_px)
        one_edge = np.interp(np.arange(len(self.shape.x)), blocks.node, 1.0 * blocks.by_profile)
        of_profile = max(
            OUTLINE_PROFILE_SIGMA_RATIO * usual,
            min(OUTLINE_PROFILE_SIGMA_MIN_PX, OUTLINE_PROFILE_SIGMA_THIN_RATIO * usual),
        )
        unsure = np.hypot(unsure, of_profile * one_edge)
        return np.asarray(np.hypot(unsure, self._taper_share(few - usual) * np.abs(apart)))

    @property
    def _misfit_px(self) -> FloatArray:
        """(nodes,) how far the strip's middle leaves the curve over some blocks in a row.

        A bend that is tighter than the curve can be is cut off.
        """
        seen = self.blocks.seen
        aside = np.abs(running_middle(self.misfit_px[seen], MISFIT_HALF_BLOCKS))
        return np.asarray(np.interp(np.arange(len(self.shape.x)), self.blocks.node[seen], aside))

    def _taper_share(self, wider: FloatArray) -> FloatArray:
        """Return (nodes,) the share of a local change of width that may be in the middle.

        A strip that is thinner, with nothing outside of its edges, is thinner.
        """
        least, most = OUTLINE_TAPER_SHARES
        if self.rival_near is None:
            return np.full(len(self.shape.x), most)
        at = self.blocks.node[self.blocks.by_edges]
        thinner = np.interp(np.arange(len(self.shape.x)), at, 1.0 * (wider < 0))
        return np.asarray(most - (most - least) * thinner * (1 - self.rival_near))

    @property
    def sigma_px(self) -> FloatArray:
        """(nodes,) standard deviation along the normal."""
        return np.asarray(np.hypot(self.inner_sigma_px, self.end_px))

    @property
    def inner_sigma_px(self) -> FloatArray:
        """(nodes,) the same without what both ends' own edges may pull."""
        loose = spread(self.shape.normal_modes(), self.covariance)
        return np.asarray(np.sqrt(loose**2 + self.systematic_px**2 + self.unseen_px**2))

    @property
    def end_px(self) -> FloatArray:
        """(nodes,) what the clamp's and the tip's own edges may pull, near both ends."""
        s = self.shape.basis.s
        return end_pull_px(np.minimum(s, s[-1] - s), self.width_px)

    @property
    def unseen_px(self) -> FloatArray:
        """(nodes,) how far the strip may lie beside the curve between places where it is known.

        In a gap it may bend as much more, or less, as it usually bends: so much sags an arc.
        """
        shape, blocks = self.shape, self.blocks
        s = shape.basis.s
        least = UNSEEN_TURN_MIN_RAD / shape.basis.total_px
        bend = max(float(np.sqrt(np.mean(shape.k**2))), least)
        at = s[np.sort(np.concatenate([blocks.node[blocks.seen], self.stated_node]))]
        after = np.searchsorted(at, s)
        before = s - at[np.maximum(after - 1, 0)]
        ahead = at[np.minimum(after, len(at) - 1)] - s
        free = before * ahead
        free = np.where(after == 0, ahead**2, np.where(after == len(at), before**2, free))
        return np.asarray(0.5 * bend * free)


def fit_outline(
    shape: CurveShape,
    images: Sequence[GreyImage],
    optics: Optics,
    *,
    width_px: float,
    prior: FloatArray,
    work: OutlineWork,
    rounds: int = ROUNDS,
    completed: Callable[[CurveShape, FloatArray, Blocks], Blocks] | None = None,
    tapers: bool = False,
    places: StatedPlaces | None = None,
) -> OutlineFit | None:
    """Return the curve between the edges beside a first one; None where they are nowhere seen.

    `images`: the same one in each colour channel in which an edge may show. `completed`: sees the
    strip in blocks whose edges are too faint. `tapers`: its width is followed along it, which
    only a curve that is known well allows: another width confirms itself. `places`: stated ones,
    which it passes.
    """
    fit = None
    taper = np.ones(len(shape.x))
    for _ in range(rounds):
        work.count_round()
        blocks = measure_blocks(shape, images, optics, width_px, taper)
        if blocks.seen.sum() < 4:
            return None
        if completed is not None:
            blocks = completed(shape, taper, blocks)
        if tapers:
            blocks = without_lonely(blocks)
        if places is not None:
            kept = ~places.contradicted(shape, blocks.node, blocks.middle_px, width_px)
            blocks = replace(blocks, seen=blocks.seen & kept, by_profile=blocks.by_profile & kept)
        if blocks.by_edges.sum() < 4:
            return None
        fit = smooth_fit(shape, blocks, prior, taper, places)
        shape = fit.shape
        if tapers:
            taper = fitted_taper(blocks, width_px, len(shape.x))
    return fit


def fitted_taper(blocks: Blocks, width_px: float, nodes: int) -> FloatArray:
    """Return (nodes,) the strip's width there over its usual one, where it clearly differs.

    A worm, a stem or a cable in perspective is thinner at one end. The image beside such a
    strip is looked at in its own width, so that edges are where they are in a strip of one width.
    """
    seen = blocks.clear & ~blocks.by_profile
    if seen.sum() < 2 * FRAY_HALF_BLOCKS:
        return np.ones(nodes)
    ratio = running_middle(blocks.width_px[seen], FRAY_HALF_BLOCKS) / width_px - 1
    ratio = np.sign(ratio) * np.maximum(np.abs(ratio) - TAPER_FROM, 0.0)
    least = min(1.0, max(TAPER_RATIOS[0], TAPER_MIN_PX / width_px))
    ratio = np.clip(1 + ratio, least, TAPER_RATIOS[1])
    return np.asarray(np.interp(np.arange(nodes), blocks.node[seen], ratio))


def smooth_fit(
    shape: CurveShape,
    blocks: Blocks,
    prior: FloatArray,
    taper: FloatArray,
    places: StatedPlaces | None,
) -> OutlineFit:
    """Return the smooth curve through the middles of the blocks and what is stated."""
    seen = blocks.seen
    rough = roughness(blocks.middle_px[seen])
    width = float(np.median(blocks.width_px[blocks.by_edges]))
    middle = blocks.middle_px
    if places is not None:
        middle = middle - _end_pulls_px(shape, blocks, width, places)
    offset = np.where(seen, middle, 0.0)
    sigma = max(rough, 0.005 * width, 0.03) * math.sqrt(INDEPENDENT_BLOCKS)
    modes = shape.normal_modes()[blocks.node]
    weight = np.where(seen, 1 / sigma**2, 0.0)
    more = (0.0, 0.0) if places is None else places.information(shape)
    for _ in range(3):  # Tukey's weights: a fray or a fitting is an outlier
        normal, pull = information(shape, modes, offset, weight, prior)
        normal, pull = normal + more[0], pull + more[1]
        wanted = averaged(normal, pull, shape.basis.priors, shape.basis.log_weight)
        left = offset - modes @ (wanted - shape.parameters)
        scatter = max(sigma, 1.48 * float(np.median(np.abs(left[seen]))))
        ratio = np.minimum(np.abs(left) / (4.7 * scatter), 1.0)
        weight = np.where(seen, (1 - ratio**2) ** 2 / scatter**2, 0.0)
    moved = shape.moved(wanted)
    return OutlineFit(
        shape=moved,
        beside=shape,
        stated_node=np.empty(0, np.int64) if places is None else places.nodes(moved),
        stated_apart_px=0.0 if places is None else places.apart_px(moved),
        taper=taper,
        blocks=blocks,
        normal=normal,
        pull=pull,
        residual_px=float(np.sqrt(np.mean(left[seen] ** 2))),
        misfit_px=np.where(seen, left, 0.0),
        width_scatter_px=roughness(blocks.width_px[blocks.by_edges]),
    )


def _end_pulls_px(
    shape: CurveShape, blocks: Blocks, width_px: float, places: StatedPlaces
) -> FloatArray:
    """Return (blocks,) how far the middles beside the clamp and a stated tip lie too far left."""
    s, total = shape.basis.s[blocks.node], shape.basis.total_px
    near_px = END_WIDTHS * width_px
    pulls = np.zeros(len(s))
    clamp, tip = places.clamp_offset_px(shape), places.tip_offset_px(shape)
    known = max(places.clamp_sigma_px, CLAMP_SIGMA_MIN_PX)
    for away, offset, sigma, most in (
        (s, clamp, known, CLAMP_APART_SIGMAS),
        (total - s, tip, places.tip_sigma_px, TIP_APART_SIGMAS),
    ):
        if offset is not None:
            pulls += likeliest_pull_px(
                away,
                blocks.middle_px,
                blocks.seen & (away < near_px),
                width_px=width_px,
                end_offset_px=offset,
                end_sigma_px=sigma,
                sigmas_max=most,
            )
    return pulls


def _wander(widths: FloatArray) -> float:
    """Return how much a strip's width leaves a smooth taper, over lengths of many blocks."""
    if len(widths) < 2 * FRAY_HALF_BLOCKS:
        return 0.0
    along = np.linspace(-1, 1, len(widths))
    smooth = np.polynomial.polynomial.polyfit(along, widths, TAPER_DEGREE)
    return float(np.std(widths - np.polynomial.polynomial.polyval(along, smooth)))
