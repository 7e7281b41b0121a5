"""The strip's geometry (input) and the neutral curve (result) of the extraction."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from labrig.errors import BadInputError
from labrig.vision.calibration.optics import Optics
from labrig.vision.curve.background_lines import BackgroundLine
from model.measurements import Curve, Displayed, Summary, dataframe, is_number
from model.measurements.known_arguments import known_arguments

if TYPE_CHECKING:
    import pandas as pd

FloatArray = npt.NDArray[np.float64]


USUAL_LENGTHS_M = (0.04, 0.06)  # length of a strip
USUAL_THICKNESS_M = 0.21e-3
_UNSTATED = float("nan")  # this one object alone; another NaN is a wrong value


def smallness(length_m: float) -> float:
    """Return how many times smaller than a usual strip it is, and so bends the more; 1: none.

    From near it looks alike, and so does a larger one from afar.
    """
    return float(np.clip(length_m, *USUAL_LENGTHS_M)) / length_m


@known_arguments
@dataclass(frozen=True, kw_only=True)
class StripGeometry:
    """The sheet's lengths, known before the image is read.

    A thickness that is not stated is measured in the image. Raises BadInputError for lengths that
    no sheet has.
    """

    free_length_m: float
    elongation_m: float = 0.0  # beyond the free length
    # else it may bend; one that bends is looked for, too, where no straight one fits the image
    elongation_straight: bool = True
    thickness_m: float = _UNSTATED
    thickness_known: bool = True  # else `thickness_m` is a guess, and the image is measured
    length_known: bool = True  # else `free_length_m` is a guess, and it is followed to its end

    def __post_init__(self) -> None:
        for name in ("free_length_m", "elongation_m", "thickness_m"):
            if not is_number(value := getattr(self, name)):
                raise BadInputError(f"{name} {value!r}: a number is needed.")
        if self.thickness_m is _UNSTATED:
            guess_m = min(USUAL_THICKNESS_M, 0.1 * self.free_length_m)
            object.__setattr__(self, "thickness_m", guess_m)
            object.__setattr__(self, "thickness_known", False)
        if not 0 < self.free_length_m < 10:
            raise BadInputError(
                f"the sheet's free length is {self.free_length_m * 1000:g} mm; "
                "it must be above 0 and below 10 m."
            )
        if not 0 <= self.elongation_m < 10:
            raise BadInputError(
                f"the sheet's elongation is {self.elongation_m * 1000:g} mm; "
                "it must be 0 (none) or positive and below 10 m."
            )
        if not 0 < self.thickness_m < self.free_length_m:
            raise BadInputError(
                f"the sheet's thickness is {self.thickness_m * 1000:g} mm; "
                "it must be above 0 and below the free length."
            )

    @property
    def length_m(self) -> float:
        """Visible length from the clamp to the end."""
        return self.free_length_m + self.elongation_m


def _nothing() -> FloatArray:
    return np.empty(0)


@dataclass(frozen=True, kw_only=True, repr=False)
class NeutralCurve(Displayed):
    """The neutral curve found in one image; arrays run from the clamp to the visible end.

    `sigma_m` is one standard deviation of the distance along the normal, from noise and from the
    calibration together. With `ok` False the arrays are empty, `why` is a sentence, and
    `refused_at_px` is where that shows, if it is somewhere in particular.
    """

    ok: bool
    why: str = ""
    refused_at_px: tuple[float, float] | None = None  # column and row, raw pixels
    warnings: tuple[str, ...] = ()
    s_m: FloatArray = field(default_factory=_nothing)  # (points,)
    x_m: FloatArray = field(default_factory=_nothing)
    y_m: FloatArray = field(default_factory=_nothing)
    curvature_per_m: FloatArray = field(default_factory=_nothing)
    sigma_m: FloatArray = field(default_factory=_nothing)
    curvature_sigma_per_m: FloatArray = field(default_factory=_nothing)
    curvature_resolution_m: float = 0.0  # features of k(s) shorter than this are not resolved
    points_px: FloatArray = field(default_factory=lambda: np.empty((0, 2)))  # raw pixels
    covered: float = 0.0  # share of the length on which the sheet was really seen
    seen: npt.NDArray[np.bool_] = field(default_factory=lambda: np.empty(0, dtype=bool))
    end_sigma_m: float = 0.0  # of where the strip ends, along it; 0 where the length was stated
    residual_px: float = 0.0  # RMS distance of the locally measured sheet from the curve
    contrast: float = 0.0  # of the sheet over the background, grey levels without a sign
    snr: float = 0.0  # contrast over the noise of one pixel
    # [offset along the normal at the clamp (m), angle there (rad), curvature coefficients (1/m)]
    parameters: FloatArray = field(default_factory=_nothing)
    covariance: FloatArray = field(default_factory=lambda: np.empty((0, 0)))  # of the parameters
    # (points, parameters): displacement along the normal for each parameter; with it the
    # covariance of the whole curve is modes @ covariance @ modes.T, plus the scale's part
    normal_modes: FloatArray = field(default_factory=lambda: np.empty((0, 0)))
    polarity: str = ""  # bright or dark, as found
    blur_px: float = 0.0  # standard deviation of the edge's blur, as found
    free_length_m: float = 0.0  # of the strip, as stated
    thickness_m: float = 0.0
    elongation_width_px: float = 0.0  # visible thickness of the elongation, as found
    elongation_straight: bool = True  # whether a straight one fits the image
    excess_px: FloatArray = field(default_factory=_nothing)  # visible width beyond the thickness
    # how far what touches the sheet on one side may have biased the curve, by point
    lateral_bias_px: FloatArray = field(default_factory=_nothing)
    side_face_px: FloatArray = field(
        default_factory=_nothing
    )  # the side face's visible width, by point
    side_face_share: float = 0.0  # its grey over the edge's
    wires: tuple[BackgroundLine, ...] = ()  # that hide parts of the sheet
    doubt: str = ""  # why it is refused unless another look confirms it; a user's curve has none

    def confirmed(self) -> NeutralCurve:
        """Return it, or the refusal where there is a doubt."""
        return NeutralCurve(ok=False, why=self.doubt) if self.doubt else self

    def summary(self) -> Summary:
        """Return length, tip, how much was seen, and the warnings; or why there is no curve."""
        if not self.ok:
            return Summary(f"NeutralCurve: no curve: {self.why}")
        rows = [
            ("length", f"{1e3 * self.s_m[-1]:.2f}", "mm"),
            ("tip x", f"{1e3 * self.x_m[-1]:+.3f}", "mm"),
            ("tip y", f"{1e3 * self.y_m[-1]:+.3f}", "mm"),
            ("uncertainty of the tip along the normal", f"{1e3 * self.sigma_m[-1]:.4f}", "mm"),
            *(
                [("uncertainty of the end along the curve", f"{1e3 * self.end_sigma_m:.2f}", "mm")]
                if self.end_sigma_m
                else []
            ),
            ("share of the length that was seen", f"{100 * self.covered:.0f}", "%"),
            ("residual", f"{self.residual_px:.3f}", "px"),
        ]
        title = f"NeutralCurve: {len(self.s_m)} points"
        return Summary(title, ("quantity", "value", "unit"), rows, self.warnings)

    def to_dataframe(self) -> pd.DataFrame:
        """Return the points as a pandas data frame, in SI units; no row without a curve."""
        return dataframe(self.as_curve().columns())

    def as_curve(self) -> Curve:
        """Return the same as the model takes it."""
        return Curve(
            s_m=self.s_m,
            x_m=self.x_m,
            y_m=self.y_m,
            curvature_per_m=self.curvature_per_m,
            sigma_m=self.sigma_m,
            curvature_sigma_per_m=self.curvature_sigma_per_m,
        )


class FindCurve(Protocol):
    """A way from an image to its curve, such as `neutral_curve` or another extractor's."""

    def __call__(
        self,
        image: npt.NDArray[Any],
        optics: Optics,
        strip: StripGeometry,
        *,
        start: NeutralCurve | None = None,
    ) -> NeutralCurve:
        """Return the curve; `start` is that of an image shortly before."""
        ...
