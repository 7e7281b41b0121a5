"""How much of the strip's profile shows on a way that leads on from a curve's end.

The profile across, in all channels, is learned on the last part of the curve. From the end, and
from places shortly before, it is looked for along straight and bent ways in all directions, also
sharply back; what lies beside the curve itself is left out. Straight beyond the end it is looked
for at half its width, too: tips taper. Where the strip ends, only its ground shows there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from labrig.vision.image.image import GreyImage
from labrig.vision.thresholds import STRIP_GOES_ON_GROUND_RATIO

FloatArray = npt.NDArray[np.float64]

# All lengths are in widths of the strip.
LEARNED, LAST = 8.0, 0.5  # from the end: where the profile is learned
ALONG, ACROSS = 0.15, 0.08  # steps
HALF = 0.9  # of the profile
ASIDE = 0.4  # by which the strip may lie beside a way
BLUR, BLUR_MIN_PX = 0.06, 0.6
SCATTER_MIN = 1e-3  # grey levels, of drawings without noise
ROOM = 5.0  # beside the last part: more than is looked at
TURNS_RAD = np.radians(np.arange(-165, 166, 15))  # from the curve's end to a way
BENDS = (-0.3, 0.0, 0.3)  # of a way, in radians a width
STEP = 0.2  # along a way
CLEAR = 1.2  # from the curve: nearer shows its own strip
CLEAR_AT_END = 0.7  # of the distance from the end, which is nearer at first
PLACES_MIN = 3  # of a way beside the curve
SHOWN_QUANTILE = 0.2  # of the places of a way: what nearly all show
LEARNED_MIN = 8  # places
GROUND_ASIDE = (-2.6, -2.0, 2.0, 2.6)
GROUND_CLEAR, GROUND_MIN = 1.5, 8  # from the curve; places
GROUND_QUANTILE = 0.8  # of what the ground shows of the strip, by noise and texture


@dataclass(frozen=True, kw_only=True)
class _Look:
    """Ways that begin somewhere before the end."""

    before: float
    near: float  # from where, and to where, it is looked along a way
    far: float
    share: float = 1.0  # of the strip's width, at which it is looked for


# a hook is cut short: before the curve's end
LOOKS = (
    *(_Look(before=before, near=0.7, far=2.3) for before in (0.0, 0.75, 1.5)),
    _Look(before=0.0, near=0.4, far=1.4, share=0.5),
)

FARTHEST = max(look.far for look in LOOKS)  # from the end


@dataclass(frozen=True, eq=False, kw_only=True)
class _StripEnd:
    """A strip's last part: what it looks like, and how to find as much of that elsewhere."""

    images: Sequence[FloatArray]  # blurred
    path_px: FloatArray  # (places, 2)
    width_px: float
    weights: FloatArray  # (channels, across); their product with the strip's own profile is 1


def shown_beyond(images: Sequence[GreyImage], path_px: FloatArray, width_px: float) -> float:
    """Return how much of the strip the likeliest way on from its end shows: 0 none, 1 all."""
    strip = _learned(images, path_px, width_px)
    return 0.0 if strip is None else max(_shown_beyond(strip, look) for look in LOOKS)


def _learned(images: Sequence[GreyImage], path_px: FloatArray, width_px: float) -> _StripEnd | None:
    """Return what a strip's last part looks like; None where it is too short, or hidden."""
    greys, path_px = _around_end(images, path_px, width_px)
    path = _at(path_px, np.arange(0.0, _lengths(path_px)[-1], ALONG * width_px))
    last = path[-round(LEARNED / ALONG) : -round(LAST / ALONG)]
    if len(last) < LEARNED_MIN:
        return None
    across = width_px * _across(HALF)[:, None] * _left(np.gradient(last, axis=0))[:, None]
    beside = _sampled(greys, last[:, None] + across)
    beside = beside[:, np.isfinite(beside).all(axis=(0, 2))]
    if beside.shape[1] < LEARNED_MIN:
        return None
    usual = np.median(beside, axis=1)
    scatter = 1.48 * np.median(np.abs(beside - usual[:, None]), axis=(1, 2))
    usual -= usual.mean(axis=1, keepdims=True)
    weights = usual / np.maximum(scatter, SCATTER_MIN)[:, None] ** 2
    size = float((weights * usual).sum())
    if size <= 0:
        return None
    return _StripEnd(images=greys, path_px=path_px, width_px=width_px, weights=weights / size)


def _around_end(
    images: Sequence[GreyImage], path_px: FloatArray, width_px: float
) -> tuple[list[FloatArray], FloatArray]:
    """Return the part of the image that is looked at, blurred, and the path in it."""
    import cv2

    total = _lengths(path_px)[-1]
    last = _at(path_px, np.linspace(max(0.0, total - LEARNED * width_px), total, 50))
    rows, columns = images[0].grey.shape
    room = ROOM * width_px
    u0, v0 = np.clip(np.floor(last.min(axis=0) - room), 0, None).astype(int)
    u1, v1 = np.minimum(np.ceil(last.max(axis=0) + room), (columns, rows)).astype(int)
    blur = max(BLUR_MIN_PX, BLUR * width_px)
    parts = [np.ascontiguousarray(each.grey[v0:v1, u0:u1]) for each in images]
    return [np.asarray(cv2.GaussianBlur(part, (0, 0), blur)) for part in parts], path_px - (u0, v0)


def _shown_beyond(strip: _StripEnd, look: _Look) -> float:
    """Return how much the likeliest way shows; 0 where the ground shows nearly as much."""
    width = strip.width_px
    end = _lengths(strip.path_px)[-1] - look.before * width
    behind, begin = _at(strip.path_px, np.array([max(0.0, end - width), end]))
    ahead = (begin - behind) / max(float(np.hypot(*(begin - behind))), 1e-9)
    away = np.arange(look.near, look.far + STEP / 2, STEP)
    offset, heading = _ways(away)
    frame = np.stack([ahead, [-ahead[1], ahead[0]]])
    places = begin + width * offset @ frame
    shown = _shown(strip, places, heading @ frame, look.share)
    gap = _from_curve(strip, places)
    if look.before == 0:
        counts = np.ones_like(gap, dtype=bool)
        usable = (gap >= np.minimum(CLEAR, CLEAR_AT_END * away)).all(axis=1)
    else:
        counts = gap >= CLEAR
        usable = counts[:, -1] & (counts.sum(axis=1) >= PLACES_MIN)
    usable &= np.isfinite(np.where(counts, shown, 0.0)).all(axis=1)
    most = max(
        (
            float(np.quantile(shown[way, counts[way]], SHOWN_QUANTILE))
            for way in np.flatnonzero(usable)
        ),
        default=0.0,
    )
    return most if most > STRIP_GOES_ON_GROUND_RATIO * _shown_by_ground(strip, look.share) else 0.0


def _shown_by_ground(strip: _StripEnd, share: float) -> float:
    """Return how much of the strip its ground shows to both sides of it."""
    total = _lengths(strip.path_px)[-1] / strip.width_px
    along = np.arange(max(0.0, total - LEARNED), total, 2 * ALONG) * strip.width_px
    path = _at(strip.path_px, along)
    heading = np.gradient(path, axis=0)
    aside = np.array(GROUND_ASIDE)[:, None, None] * strip.width_px
    places = path + aside * _left(heading)
    shown = _shown(strip, places, np.broadcast_to(heading, places.shape), share)
    ground = shown[(_from_curve(strip, places) > GROUND_CLEAR) & np.isfinite(shown)]
    return float(np.quantile(ground, GROUND_QUANTILE)) if len(ground) >= GROUND_MIN else 0.0


def _ways(away: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (ways, places, 2) places at so many widths along each way, and the headings there."""
    turn, bend = (each.reshape(-1, 1) for each in np.meshgrid(TURNS_RAD, BENDS))
    steps = np.linspace(0, away, 21, axis=-1)  # (places, steps)
    angle = turn[..., None] + bend[..., None] * steps
    offset = np.stack([np.cos(angle).mean(axis=2), np.sin(angle).mean(axis=2)], axis=2)
    angle = angle[..., -1]
    return offset * away[:, None], np.stack([np.cos(angle), np.sin(angle)], axis=2)


def _from_curve(strip: _StripEnd, places: FloatArray) -> FloatArray:
    """Return (ways, places) the distance to the curve."""
    apart = np.hypot(*np.moveaxis(places[:, :, None] - strip.path_px, 3, 0))
    return np.asarray(apart.min(axis=2) / strip.width_px)


def _shown(strip: _StripEnd, places: FloatArray, heading: FloatArray, share: float) -> FloatArray:
    """Return (ways, places) how much of the strip each place shows; NaN outside of the image.

    `share`: of the strip's width, at which it is looked for.
    """
    across = _across(HALF + ASIDE) * strip.width_px * share
    at = places[:, :, None] + across[:, None] * _left(heading)[:, :, None]
    many = strip.weights.shape[1]
    windows = np.lib.stride_tricks.sliding_window_view(_sampled(strip.images, at), many, axis=3)
    return np.asarray(np.einsum("cwpsk,ck->wps", windows, strip.weights).max(axis=2))


def _across(reach: float) -> FloatArray:
    many = int(reach / ACROSS)
    return np.asarray(np.arange(-many, many + 1) * ACROSS)


def _left(heading: FloatArray) -> FloatArray:
    """Return (..., 2) unit vectors across directions."""
    across = np.stack([-heading[..., 1], heading[..., 0]], axis=-1)
    length = np.hypot(across[..., 0], across[..., 1])[..., None]
    return np.asarray(across / np.maximum(length, 1e-9))


def _lengths(path: FloatArray) -> FloatArray:
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])


def _at(path: FloatArray, along: FloatArray) -> FloatArray:
    lengths = _lengths(path)
    return np.stack([np.interp(along, lengths, path[:, axis]) for axis in (0, 1)], axis=1)


def _sampled(images: Sequence[FloatArray], at: FloatArray) -> FloatArray:
    """Return (channels, ...) the images at places (..., 2); NaN outside."""
    import cv2

    flat = np.ascontiguousarray(at.reshape(len(at), -1, 2), dtype=np.float32)
    return np.stack(
        [
            cv2.remap(
                each,
                flat,
                None,
                cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_CONSTANT,
                borderValue=float("nan"),
            ).reshape(at.shape[:-1])
            for each in images
        ]
    ).astype(np.float64)
