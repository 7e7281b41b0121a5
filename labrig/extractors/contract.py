"""What a curve extractor is: from one image to the neutral curve of the sheet in it.

A module of this folder is an extractor's when it has an `EXTRACTOR`. Another distribution adds one
by an entry point of the group `labrig.extractors` that leads to such an object; the entry point's
name is what `labrig curves --extractor NAME` and `labrig analyze --extractor NAME` ask for.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy.typing as npt

from labrig.vision import NeutralCurve, Optics, StripGeometry


class CurveExtractor(Protocol):
    """An extractor: stateless, so that one object serves all images of a process.

    `labrig curves` calls it in the main thread; `labrig analyze` in several processes at a time,
    one thread each. A process is given the extractor's name and imports it by itself, so the object
    need not be picklable, and nothing that it keeps in memory reaches another process.
    """

    @property
    def summary(self) -> str:
        """One sentence, with its full stop: how the curve is found."""
        ...

    def curve(
        self,
        image: npt.NDArray[Any],
        optics: Optics,
        strip: StripGeometry,
        *,
        start: NeutralCurve | None = None,
    ) -> NeutralCurve:
        """Return the neutral curve of the sheet in `image`, or the reason why there is none.

        Called once for each image; it may block for seconds. It must not change `image` and must
        give the same answer to the same arguments.

        `image`: (rows, columns), or (rows, columns, 3) in OpenCV's order; uint8 or uint16. An
        integer coordinate is a pixel's centre. `optics` turns pixels into the sheet's plane and
        back. `strip` holds the lengths in m. `start`: a curve that this extractor found shortly
        before in the same view; following it is optional.

        What cannot be measured is returned, never raised: `NeutralCurve(ok=False, why=...)` with
        one sentence. A curve has `ok` True and, from the clamp to the visible end, n >= 2 points:

        - `s_m`, `x_m`, `y_m` (n,): arc length, and the place in the sheet's plane, m; `s_m` begins
          at 0, increases, and agrees with the places;
        - `sigma_m` (n,): standard deviation of the distance along the normal, m, above 0;
        - `curvature_per_m`, `curvature_sigma_per_m` (n,): positive where the sheet bends to +y;
        - `points_px` (n, 2): the same points as raw (distorted) pixels, column before row;
        - `seen` (n,): whether the sheet is seen there; `covered`: that as a share;
        - `thickness_m`, `free_length_m`: as used; `contrast`: grey levels without a sign.

        Anything it raises is turned into a reason that names the extractor.
        """
        ...
