"""The far face: a sheet is wide across the picture's plane, and its far edge looks smaller.

So beside its near edge a stripe of its face shows, towards the point where lines square to the
sheet's plane meet: its width is known along the whole sheet from two numbers. Taken for a part of
the edge the stripe would pull the curve to its side by up to half its width. Lit from the front it
is grey; in a silhouette it is as dark as the edge, and only its geometry tells the two apart.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.fit import Fit
from labrig.vision.setting import Band, Setting, measured, pixels_beside
from labrig.vision.shape import Shape

FloatArray = npt.NDArray[np.float64]

DEPTHS = (0.012, 0.025)  # to begin with: the sheet's width over the far edge's distance
SHARE = 0.5  # and the face's grey over the edge's
MOST_DEPTH, LEAST_SHARE, MOST_SHARE = 0.12, 0.02, 1.0
MOST_LIT_SHARE = 0.75  # where the edge is said to be lit
MOST_FACE_PX = 24.0
CENTRE_SIGMA = 0.06  # of the picture's width: how square the camera looks at the plane
LIKELY_GAIN = 12.0  # twice a log-likelihood: what a rough guess must explain to be refined
LEAST_GAIN = 30.0  # and the likeliest face
LEAST_COMMON_GAIN = 5.0
COMMON = 0.75  # so many of the pieces, those that gain least, must gain something together
COMMON_SHARE = 0.08
PIECE_CELLS = 24
EVALUATIONS = 130
LEAST_BLUR_PX = 0.5


@dataclass(frozen=True)
class Face:
    """How the far face shows; lengths in pixels of the sheet's plane."""

    depth: float
    share: float
    centre: tuple[float, float]
    blur: float  # of the edges, which is less when the face is not taken for blur
    elongation_half: float  # half the elongation's visible thickness, which nobody knows

    def widths(self, shape: Shape) -> FloatArray:
        """(cells,) visible width, to the side of its sign."""
        x, y = 0.5 * (shape.x[1:] + shape.x[:-1]), 0.5 * (shape.y[1:] + shape.y[:-1])
        phi = 0.5 * (shape.phi[1:] + shape.phi[:-1])
        towards = (self.centre[1] - y) * np.cos(phi) - (self.centre[0] - x) * np.sin(phi)
        return np.asarray(np.clip(self.depth * towards, -MOST_FACE_PX, MOST_FACE_PX))

    def on(self, band: Band, shape: Shape) -> Band:
        """A band with this face."""
        looking = band.retuned(self.blur, self.elongation_half)
        return replace(looking, face=self.widths(shape), face_share=self.share)


def find_face(fit: Fit, setting: Setting, known: Face | None = None) -> Face | None:
    """The far face beside a fitted curve; None where a band alone explains as much.

    `known`: a face from which to start, of the curve before it was fitted again.
    """
    search = _Search(fit, setting)
    guess = search.first() if known is None else known
    if guess is None:
        return None
    face, gains = search.refined(guess)
    enough = _enough(gains) if known is None else float(gains.sum()) > LIKELY_GAIN
    return face if enough else None


class _Search:
    """What a face would explain of the picture, the curve's own displacement taken off."""

    def __init__(self, fit: Fit, setting: Setting) -> None:
        self.fit, self.setting = fit, setting
        rows, columns = setting.picture.grey.shape
        optics = setting.optics
        away = optics.vanishing_px((columns, rows))
        self.centre = optics.undistorted_to_world([away])[0] * optics.px_per_m
        self.spread = CENTRE_SIGMA * columns
        self.silhouette = optics.look == "silhouette"
        self.most_share = MOST_LIT_SHARE if optics.look == "lit_edge" else MOST_SHARE
        self.plain = replace(fit.band, face=np.zeros(len(fit.used)), face_share=0.0)
        self.pixels = pixels_beside(fit.shape, setting, self.plain.reach + 6.0)
        self.nothing = self._misfits(self.plain)

    def first(self) -> Face | None:
        """The best of a few guesses, if it explains enough."""
        share = 1.0 if self.silhouette else SHARE
        centre = (float(self.centre[0]), float(self.centre[1]))
        half = float(self.plain.half_width[-1])
        guesses = [self._sharper(Face(depth, share, centre, 1.0, half)) for depth in DEPTHS]
        best = min(guesses, key=self._total)
        return best if float((self.nothing - self.costs(best)).sum()) > LIKELY_GAIN else None

    def _sharper(self, face: Face) -> Face:
        """The same with the blur that is left when the face explains a part of it."""
        band = self.plain
        thick, wide = 2 * band.half_width, np.abs(face.widths(self.fit.shape))
        grey = face.share * wide
        # second moment of band and face together, less the band's own
        spread = grey * wide**2 / 12 + thick * grey / (thick + grey) * ((thick + wide) / 2) ** 2
        more = float(np.mean(spread / (thick + grey)))
        return replace(face, blur=float(np.sqrt(max(band.blur**2 - more, LEAST_BLUR_PX**2))))

    def refined(self, face: Face) -> tuple[Face, FloatArray]:
        """The likeliest face, from a guess, and what it explains in each piece."""
        self._settle()
        start = np.array(
            [np.log(face.depth), face.share, 0, 0, np.log(face.blur), face.elongation_half]
        )
        start[2:4] = (np.array(face.centre) - self.centre) / self.spread
        steps = np.array([0.3, -0.15, 0.4, 0.4, 0.15, 0.2])
        used = slice(0, 6 if self.plain.elongation.any() else 5)
        found = self._face(_lowest(self._unlikely, start, steps, used, EVALUATIONS))
        return found, self.nothing - self.costs(found)

    def _settle(self) -> None:
        """Give the band alone its best chance: an elongation may be thick, a lens may blur."""

        def band(p: FloatArray) -> Band:
            return self.plain.retuned(
                max(float(np.exp(p[0])), LEAST_BLUR_PX), max(float(p[1]), 0.5)
            )

        start = np.array([np.log(self.plain.blur), float(self.plain.half_width[-1])])
        used = slice(0, 2 if self.plain.elongation.any() else 1)
        steps = np.array([0.15, 0.3])
        best = _lowest(lambda p: float(self._misfits(band(p)).sum()), start, steps, used, 40)
        self.plain = band(best)
        self.nothing = self._misfits(self.plain)

    def _face(self, p: FloatArray) -> Face:
        x, y = self.centre + self.spread * p[2:4]
        blur = float(np.clip(np.exp(p[4]), LEAST_BLUR_PX, 6.0))
        share = 1.0 if self.silhouette else float(np.clip(p[1], LEAST_SHARE, self.most_share))
        depth = float(np.clip(np.exp(p[0]), 1e-4, MOST_DEPTH))
        return Face(depth, share, (float(x), float(y)), blur, max(float(p[5]), 0.5))

    def _unlikely(self, p: FloatArray) -> float:
        """What a face leaves unexplained, and how odd it is; outside of the bounds ever more."""
        outside = max(0.0, p[1] - self.most_share) + max(0.0, LEAST_SHARE - p[1])
        return self._total(self._face(p)) + float(p[2:4] @ p[2:4]) + 100.0 * float(outside)

    def _total(self, face: Face) -> float:
        return float(self.costs(face).sum())

    def costs(self, face: Face) -> FloatArray:
        """(pieces,) what a face leaves unexplained."""
        return self._misfits(face.on(self.plain, self.fit.shape))

    def _misfits(self, band: Band) -> FloatArray:
        """(pieces,) squared residuals over the noise's, each piece displaced as it likes."""
        fit = self.fit
        # weights that forgive little would count a missing face as an outlier
        cells = measured(self.pixels, band, 3 * fit.noise, fit.used)
        cells = np.where(fit.used[:, None], cells, 0.0)
        pieces = np.arange(0, len(cells), PIECE_CELLS)
        information, pull, misfit = (
            np.add.reduceat(cells[:, column], pieces) for column in (3, 4, 5)
        )
        left = misfit - pull**2 / np.maximum(information, 1e-9)
        return np.asarray(np.maximum(left, 0.0) / fit.noise**2)


def _enough(gains: FloatArray) -> bool:
    """Whether a face explains enough, and nearly everywhere: a wire lies beside a part only."""
    total = float(gains.sum())
    common = float(np.sort(gains)[: round(COMMON * len(gains))].sum())
    return total > LEAST_GAIN and common > max(LEAST_COMMON_GAIN, COMMON_SHARE * total)


def _lowest(
    cost: Callable[[FloatArray], float],
    start: FloatArray,
    steps: FloatArray,
    used: slice,
    evaluations: int,
) -> FloatArray:
    """The parameters of least cost by a simplex from `start`; only those `used` are moved."""
    from scipy import optimize

    def whole(part: FloatArray) -> FloatArray:
        out = start.copy()
        out[used] = part
        return out

    first = start[used]
    simplex = first + np.vstack([np.zeros(len(first)), np.diag(steps[used])])
    options: Any = {"initial_simplex": simplex, "maxfev": evaluations}
    minimize: Any = optimize.minimize
    best = minimize(lambda part: cost(whole(part)), first, method="Nelder-Mead", options=options)
    return whole(np.asarray(best.x, dtype=np.float64))
