"""The curve midway between the edges of a roughly located strip, up to where they end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from labrig.vision.calibration.optics import Optics
from labrig.vision.curve import StripGeometry
from labrig.vision.curve.shape import CurveShape
from labrig.vision.extraction.faint_tip import BEGIN_WIDTHS, tip_beyond
from labrig.vision.extraction.first_shape import cut, first_shape
from labrig.vision.extraction.likeliest_paths import CLAMP_REACH_PX
from labrig.vision.extraction.path_fit import fit_path
from labrig.vision.extraction.tip_middle import strip_shown, tip_middle_px
from labrig.vision.fit.course import StripCourse, completed, course_along
from labrig.vision.fit.leading_on import led_on_by_profile
from labrig.vision.fit.outline import ROUNDS, OutlineFit, fit_outline, smooth_fit
from labrig.vision.fit.outline_blocks import Blocks
from labrig.vision.fit.rival_edges import rival_px
from labrig.vision.fit.stated_places import StatedPlaces
from labrig.vision.image.image import GreyImage
from labrig.vision.search.located import Located
from labrig.vision.search.straightened import resampled
from labrig.vision.search.work import OutlineWork
from labrig.vision.thresholds import (
    LED_ON_MIN_WIDTHS,
    LENGTH_ERROR_MAX_PX,
    LENGTH_ERROR_MAX_RATIO,
    STATED_LENGTH_MAX_RATIO,
)

FloatArray = npt.NDArray[np.float64]

PATH_STEP_PX = 0.5
TIP_WIDTHS, TIP_MIN_PX = 2.5, 14.0  # beyond an end: so far a fading tip is followed
TIP_PASSES = 3  # each leads on from where the one before it ended
BEGIN_BLOCKS = 3  # that show both edges: so begins a strip
FURTHER_ROUNDS = 20  # in which a strip is followed beyond its located end, at most
# how far beyond an end it is looked for: in widths, at least, and of the length
BEYOND_WIDTHS, BEYOND_MIN_PX, BEYOND_SHARE = 4.0, 16.0, 0.06
COARSE_OFFSET_SIGMA_RATIO = 0.5  # of a located begin, in widths
COARSE_ANGLE_SIGMA_RAD = 0.4
END_ROOM_RATIO = 0.06  # of a stated length: how far beyond it the strip is looked for
WIDTH_CHANGES = (0.8, 1.25)  # from a located width to the fitted one, at most
BEGIN_SHARE = 1 / 16  # of the length, in which a clamp may hide where the strip begins
LED_ON_RATIO = 1.5  # of what is led on by the profile, to how far the strip is looked for
TIP_SIGMA_PX, TIP_ROOM_WIDTHS = 3.0, 0.5  # how well a tip is stated; how far off it may be seen
TIP_SEEN_SIGMA_PX, TIP_SEEN_SIGMA_WIDTHS = 1.0, 0.06  # of a tip's middle, across the strip
BORDER_WIDTHS, BORDER_ROOM_PX = 1.5, 3.0  # from where a profile leaves the image to its middle
OWN_EDGE_WIDTHS = 0.4  # at the clamp and the tip, where these have edges of their own


@dataclass(frozen=True, eq=False, kw_only=True)
class Outline:
    """A fitted outline, its optics with the place and direction that were found, and its end."""

    fit: OutlineFit
    optics: Optics
    located: Located
    end_px: float  # along the curve, where the strip's profile ends
    end_sigma_px: float
    leaves_image: bool  # where it ends
    goes_on: bool  # something that looks different
    ends_in_sight: bool = True  # else it goes on as far as it was looked for
    by_path: bool = False  # along a path through stated places, for edges do not show it

    @property
    def nodes_px(self) -> FloatArray:
        """(nodes, 2) its curve in the image."""
        plane = np.stack([self.fit.shape.x, self.fit.shape.y], axis=1)
        return self.optics.world_to_pixel(plane / self.optics.px_per_m)


@dataclass(frozen=True, eq=False, kw_only=True)
class _Fitter:
    """Fits curves to one strip of one image."""

    images: Sequence[GreyImage]
    optics: Optics
    width_px: float
    places: StatedPlaces
    work: OutlineWork

    def fit(
        self, shape: CurveShape, *, rounds: int = ROUNDS, whole: bool = False
    ) -> OutlineFit | None:
        """Return the curve beside a first one; `whole`: which is that from begin to end."""
        return fit_outline(
            shape,
            self.images,
            self.optics,
            width_px=self.width_px,
            prior=_coarse_prior(self.width_px),
            work=self.work,
            rounds=rounds,
            completed=self._without_ends if whole else self._completed,
            tapers=whole,
            places=self.places if whole or self.places else None,
        )

    def course(self, shape: CurveShape, taper: FloatArray | None = None) -> StripCourse:
        return course_along(shape, self.images, self.optics, self.width_px, taper=taper)

    def _completed(self, shape: CurveShape, taper: FloatArray, blocks: Blocks) -> Blocks:
        if blocks.seen.all() or self.places:
            return blocks  # places say better where a strip is whose edges are not seen
        return completed(self.course(shape, taper), blocks, shape.basis.step_px)

    def _without_ends(self, shape: CurveShape, taper: FloatArray, blocks: Blocks) -> Blocks:
        """Return what is seen of the strip between the edges of its clamp and of its tip."""
        course = course_along(
            shape, self.images, self.optics, self.width_px, taper=taper, backward=True
        )
        total = shape.basis.total_px
        own = min(OWN_EDGE_WIDTHS * self.width_px, BEGIN_SHARE * total)
        begin = max(course.begin(BEGIN_SHARE * total), own)
        if not self.places:
            blocks = completed(course, blocks, shape.basis.step_px)
        s = shape.basis.s[blocks.node]
        kept = (s >= begin) & (s <= total - own)
        return replace(blocks, seen=blocks.seen & kept, by_profile=blocks.by_profile & kept)

    def followed(self, fit: OutlineFit) -> tuple[OutlineFit, StripCourse]:
        """Return a fit that reaches beyond the strip's end or to the image's border."""
        course = self.course(fit.shape)
        farthest = 0.0
        for _ in range(FURTHER_ROUNDS):
            if course.leaves_image:
                break
            end = course.end[0] + course.hidden_beyond_px
            more = max(BEYOND_WIDTHS * self.width_px, BEYOND_MIN_PX, BEYOND_SHARE * end)
            further: CurveShape | None = fit.shape
            if fit.shape.basis.total_px > end + 0.75 * more:
                # nothing there: the strip may lead aside of where the curve does
                stuck = end < farthest + 0.5 * self.width_px  # the fit does not follow it there
                further = None if stuck else self._aside(fit.shape, end, more)
                farthest = max(farthest, end)
            if further is None:
                break
            longer = self.fit(cut(further, end + more, self.width_px), rounds=2)
            if longer is None:
                break
            fit, course = longer, self.course(longer.shape)
        return fit, course

    def through_tip(self, fit: OutlineFit) -> OutlineFit:
        """Return a fit through the middle of its tip, where that is seen."""
        shape = fit.shape
        aside = tip_middle_px(shape, self.images, self.optics, self.width_px)
        if aside is None:
            return fit
        left = np.array([-math.sin(shape.phi[-1]), math.cos(shape.phi[-1])])
        tip = np.array([shape.x[-1], shape.y[-1]]) + aside * left
        sigma = math.hypot(TIP_SEEN_SIGMA_PX, TIP_SEEN_SIGMA_WIDTHS * self.width_px)
        places = replace(self.places, tip_seen_px=tip, tip_seen_sigma_px=sigma)
        prior = _coarse_prior(self.width_px)
        return smooth_fit(fit.beside, fit.blocks, prior, fit.taper, places)

    def to_its_end(self, shape: CurveShape, course: StripCourse) -> tuple[CurveShape, float, float]:
        """Return a curve up to where a strip ends, how long it is, and the end's sigma."""
        end, sigma = course.end
        if _at_border(course, end):
            return *self.to_border(shape, end), sigma
        if course.leaves_image:
            return shape, end, sigma
        shape, longer_px = self.to_faint_tip(shape, end)
        return shape, end + longer_px, math.hypot(sigma, longer_px / math.sqrt(12))

    def to_faint_tip(self, shape: CurveShape, end: float) -> tuple[CurveShape, float]:
        """Return a curve led on along a tip that becomes thinner or fades, and how far."""
        last, more = end, max(TIP_WIDTHS * self.width_px, TIP_MIN_PX)
        for _ in range(TIP_PASSES):
            if last <= BEGIN_WIDTHS * self.width_px:
                break  # nothing of the strip lies before it
            before = cut(shape, last - BEGIN_WIDTHS * self.width_px, self.width_px)
            on = cut(before, end + more, self.width_px)
            tip = tip_beyond(on, last, self.images, self.optics, self.width_px)
            if tip is None:
                break
            last = tip.end_px
            shape = cut(before, last, self.width_px, way=tip.way)
        return shape, last - end

    def to_border(self, shape: CurveShape, end: float) -> tuple[CurveShape, float]:
        """Return a curve led on to where its middle leaves the image, and where that is.

        One of its edges leaves the image before, so that its profile is no longer seen. It stays as
        it is where its middle does not look like the strip up to the border.
        """
        on = cut(shape, end + BORDER_WIDTHS * self.width_px + BORDER_ROOM_PX, self.width_px)
        places = self.optics.world_to_pixel(np.stack([on.x, on.y], 1) / self.optics.px_per_m)
        rows, columns = self.images[0].grey.shape
        outside = ((places < 0) | (places > (columns - 1, rows - 1))).any(axis=1)
        beyond = np.flatnonzero(outside & (on.basis.s > end))
        if not len(beyond):
            return shape, end
        on = cut(on, float(on.basis.s[beyond[0] - 1]), self.width_px)
        total = on.basis.total_px
        seen = strip_shown(on, self.images, self.optics, self.width_px, last_px=total - end)
        return (on, total) if seen else (shape, end)

    def _aside(self, shape: CurveShape, end: float, more: float) -> CurveShape | None:
        """Return the curve led on along the strip's profile, where more of the strip shows so."""
        whole = cut(shape, end, self.width_px)
        on = cut(whole, end + LED_ON_RATIO * more, self.width_px)
        way = led_on_by_profile(on, end, self.images, self.optics, self.width_px)
        if way is None:
            return None
        turned = cut(whole, end + more, self.width_px, way=way)
        least = end + LED_ON_MIN_WIDTHS * self.width_px
        return turned if self.course(turned).end[0] > least else None


def fitted_outline(
    images: Sequence[GreyImage],
    optics: Optics,
    strip: StripGeometry,
    located: Located,
    work: OutlineWork,
) -> Outline | None:
    """Return the curve between the edges up to the strip's end, or to where it is stated to be."""
    plane = optics.pixel_to_world(located.path_px) * optics.px_per_m
    total = float(np.hypot(*np.diff(plane, axis=0).T).sum())
    width = located.thickness_px
    if strip.length_known:
        length = strip.length_m * optics.px_per_m
        free = strip.free_length_m * optics.px_per_m
    elif optics.tip_px is not None:
        free = length = total
    else:
        free = length = total + max(BEYOND_WIDTHS * width, BEYOND_MIN_PX, BEYOND_SHARE * total)
    there, shape = first_shape(plane, optics, width, free, length)
    places = StatedPlaces.of(optics, width)
    fitter = _Fitter(images=images, optics=there, width_px=width, places=places, work=work)
    if not strip.length_known and optics.tip_px is None:
        ahead = fitter.course(shape).end[0] + BEYOND_WIDTHS * width
        if ahead < length:  # what lies beyond the end must not draw the curve
            shape = cut(shape, max(ahead, 4 * width), width)
    fit = fitter.fit(shape)
    if fit is None:
        return None
    least, most = WIDTH_CHANGES
    width = min(max(fit.width_px, least * width), most * width)
    fitter = replace(fitter, width_px=width)
    if strip.length_known:
        outline = _to_stated_length(fit, fitter, located, strip)
        return _followed_to_stated_length(outline, shape, fitter, strip)
    if optics.tip_px is None:
        fit, course = fitter.followed(fit)
        whole, end, sigma = fitter.to_its_end(fit.shape, course)
    else:
        more = max(BEYOND_WIDTHS * width, BEYOND_MIN_PX)
        longer = cut(fit.shape, fit.shape.basis.total_px + more, width)
        course = fitter.course(longer)
        end, sigma = _near_tip(longer, course, optics.tip_px, optics)
        whole = fit.shape
    if end < 3 * width:
        return None
    # who states places on the strip has looked where it begins, too
    begin = 0.0 if places else _begin_px(fit, min(0.5 * CLAMP_REACH_PX, end / 16))
    again = fitter.fit(cut(whole, end, width, begin_px=begin), rounds=4, whole=True)
    if again is None:
        return None
    if optics.tip_px is None and not _at_border(course, end):
        again = fitter.through_tip(again)
    return _outline(_with_rivals(again, images, there), fitter, located, course, (end, sigma))


def _to_stated_length(
    fit: OutlineFit, fitter: _Fitter, located: Located, strip: StripGeometry
) -> Outline:
    """Return the curve of a strip whose length is stated, and where it is seen to end."""
    length, width = strip.length_m * fitter.optics.px_per_m, fitter.width_px
    # a strip that continues beyond its stated length is another one, or longer
    further = cut(fit.shape, length + BEYOND_WIDTHS * width + END_ROOM_RATIO * length, width)
    course = fitter.course(further)
    if strip.elongation_m == 0:
        again = fitter.fit(cut(fit.shape, length, width), rounds=4, whole=True)
        fit = fit if again is None else fitter.through_tip(again)
    fit = _with_rivals(fit, fitter.images, fitter.optics)
    return _outline(fit, fitter, located, course, course.end)


def _followed_to_stated_length(
    whole: Outline, shape: CurveShape, fitter: _Fitter, strip: StripGeometry
) -> Outline:
    """Return the curve that is followed step by step to its length, where `whole` is lost early.

    A curve that has the stated length from the begin, as `whole` has, may leave the strip.
    """
    length, width = strip.length_m * fitter.optics.px_per_m, fitter.width_px
    if whole.end_px > (1.0 - STATED_LENGTH_MAX_RATIO) * length:
        return whole
    seen = fitter.course(shape).end[0] + BEYOND_WIDTHS * width
    begun = fitter.fit(cut(shape, max(seen, 4 * width), width))
    if begun is None:
        return whole
    outline = _to_stated_length(fitter.followed(begun)[0], fitter, whole.located, strip)
    lacking = max(LENGTH_ERROR_MAX_PX, LENGTH_ERROR_MAX_RATIO * length)
    return outline if outline.end_px > length - lacking else whole


def outline_along_path(optics: Optics, likeliest: Sequence[Located]) -> Outline:
    """Return the curve along the likeliest path through stated places to a stated tip.

    Paths of other channels show how well it is known.
    """
    located, *others = likeliest
    plane = optics.pixel_to_world(located.path_px) * optics.px_per_m
    total = float(np.hypot(*np.diff(plane, axis=0).T).sum())
    width = located.thickness_px
    there, shape = first_shape(plane, optics, width, total, total)
    fit = fit_path(
        shape,
        resampled(plane, PATH_STEP_PX),
        width_px=width,
        clearness=located.clearness,
        prior=_coarse_prior(width),
        places=StatedPlaces.of(optics, width),
        others_px=[optics.pixel_to_world(each.path_px) * optics.px_per_m for each in others],
    )
    return Outline(
        fit=fit,
        optics=there,
        located=located,
        end_px=total,
        end_sigma_px=TIP_SIGMA_PX,
        goes_on=False,
        leaves_image=False,
        by_path=True,
    )


def _near_tip(
    shape: CurveShape, course: StripCourse, tip_px: tuple[float, float], optics: Optics
) -> tuple[float, float]:
    """Return where a strip ends whose tip is stated, and the standard deviation of that.

    It is the weighted mean of the stated place and of where the strip is seen to end; the stated
    place alone where it is not seen to end near there.
    """
    tip = optics.pixel_to_world([tip_px])[0] * optics.px_per_m
    nearest = int(np.hypot(shape.x - tip[0], shape.y - tip[1]).argmin())
    stated = float(shape.basis.s[nearest])
    seen, sigma = course.end
    if abs(seen - stated) <= max(2 * TIP_SIGMA_PX, TIP_ROOM_WIDTHS * course.width_px):
        weights = np.array([1 / TIP_SIGMA_PX**2, 1 / sigma**2])
        both = float(weights @ [stated, seen] / weights.sum())
        return both, float(1 / np.sqrt(weights.sum()))
    return stated, TIP_SIGMA_PX


def _outline(
    fit: OutlineFit,
    fitter: _Fitter,
    located: Located,
    course: StripCourse,
    ended: tuple[float, float],
) -> Outline:
    end, sigma = ended
    return Outline(
        fit=fit,
        optics=fitter.optics,
        located=located,
        end_px=end,
        end_sigma_px=sigma,
        goes_on=course.goes_on,
        ends_in_sight=end < course.total_px - course.block_px,
        leaves_image=_at_border(course, end),
    )


def _at_border(course: StripCourse, end_px: float) -> bool:
    """Return whether a strip ends where it leaves the image."""
    return course.leaves_image and end_px > course.total_px - 0.5 * course.width_px - 2


def _with_rivals(fit: OutlineFit, images: Sequence[GreyImage], optics: Optics) -> OutlineFit:
    rivals, near = rival_px(fit, images, optics)
    return replace(fit, rival_px=rivals, rival_near=near)


def _coarse_prior(width_px: float) -> FloatArray:
    """Return how well a located begin and its direction are known."""
    return np.array([COARSE_OFFSET_SIGMA_RATIO * width_px + 1, COARSE_ANGLE_SIGMA_RAD])


def _begin_px(fit: OutlineFit, most: float) -> float:
    """Return where along a curve both edges are first seen, if that is near its begin."""
    blocks, step = fit.blocks, fit.shape.basis.step_px
    run = np.convolve(blocks.seen, np.ones(BEGIN_BLOCKS), mode="valid")
    first = int(np.argmax(run >= BEGIN_BLOCKS)) if (run >= BEGIN_BLOCKS).any() else 0
    begin = (blocks.node[first] - blocks.node[0]) * step
    return float(begin) if begin <= most else 0.0
