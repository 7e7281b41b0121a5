"""The contract of a published model: parameters in, force, current and shape in time out.

A model overrides `simulate`. It is called often, must not block, keeps no state and changes none of
its arguments. It raises `ModelError` for a sheet that it cannot describe, such as a contact out of
reach. A quantity that it does not predict stays None; one that it predicts only with or without a
contact is None in the other case.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite

import numpy as np
import numpy.typing as npt

from model.measurements import FloatArray, ModelError, SheetGeometry
from model.mechanics.field import Field

QUANTITIES = ("force", "current", "tip", "curve")
PLACES = 41  # of a curve
NO_FRAMES: npt.NDArray[np.int64] = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, kw_only=True)
class ModelParameter:
    """A number that a fit finds; one with a positive lower bound is fitted as its logarithm."""

    name: str
    meaning: str
    unit: str
    start: float
    low: float
    high: float
    prior_scale: float = 2.0  # standard deviation of ln(value/start), or of value - start

    @property
    def positive(self) -> bool:
        """Return whether it is fitted as its logarithm."""
        return self.low > 0.0


@dataclass(frozen=True, kw_only=True)
class DrivenSheet:
    """A sheet, free or in contact, and the voltage that drives it from rest.

    It is discharged at the first time and rests at 0 s; times before that matter for its charge.
    """

    sheet: SheetGeometry
    position_m: float | None  # of the load cell along the arc; None: free
    time_s: FloatArray  # (n,) ascending
    drive_V: FloatArray  # (n,) each held from its time to the next
    frames: npt.NDArray[np.int64] = field(default_factory=lambda: NO_FRAMES)  # samples with a curve
    wanted: frozenset[str] = frozenset(QUANTITIES)  # a model may leave out the others

    def __post_init__(self) -> None:
        """Refuse what is no drive."""
        t, V = self.time_s, self.drive_V
        if t.ndim != 1 or len(t) < 2 or t.shape != V.shape:
            raise ModelError("a drive needs as many voltages as times, and at least two")
        if not (np.all(np.isfinite(t)) and np.all(np.isfinite(V))):
            raise ModelError("times and voltages of a drive must be finite numbers")
        if np.any(np.diff(t) <= 0.0):
            raise ModelError("the times of a drive must ascend")
        if not isfinite(0.0 if self.position_m is None else self.position_m):
            raise ModelError("the position of the load cell must be a finite number")
        if len(self.frames) and not 0 <= min(self.frames) <= max(self.frames) < len(t):
            raise ModelError("a curve is wanted at a sample that the drive does not have")

    @property
    def free(self) -> bool:
        """Return whether no load cell touches the sheet."""
        return self.position_m is None

    @cached_property
    def rest(self) -> Field:
        """Return k0; a sheet without a stated k0 is straight."""
        sheet = self.sheet
        if sheet.initial_curvature is None:
            return Field.constant(0.0, sheet.free_length_m)
        return Field.linear(*sheet.initial_curvature, sheet.free_length_m)

    @property
    def angle_rad(self) -> float:
        """Return the polar angle beta of the contact."""
        if self.position_m is None:
            raise ModelError("a free sheet has no contact")
        return self.sheet.arc_origin_rad + self.position_m / self.sheet.arc_radius_m


@dataclass(frozen=True, kw_only=True)
class Response:
    """What a model predicts at the drive's times; None: it does not predict this."""

    force_N: FloatArray | None = None  # (n,) that the load cell reads, along the arc
    current_A: FloatArray | None = None  # (n,)
    tip_m: FloatArray | None = None  # (n,) distance of the sheet's end from the clamp's tangent
    # (frames, points) from the clamp to the sheet's end
    curves_m: tuple[FloatArray, FloatArray] | None = None


@dataclass(frozen=True, kw_only=True)
class PublishedModel:
    """A model from the literature."""

    name: str
    title: str  # "after ..." unless its equations are from the source itself
    from_source: bool
    source: str
    equations: str  # one sentence or formula each
    own_reading: str  # what the source leaves open, or what we could not look up; may be empty
    states: tuple[str, ...]  # with units; a static model has none
    parameters: tuple[ModelParameter, ...]
    predicts_in_contact: frozenset[str]  # of QUANTITIES
    predicts_free: frozenset[str]

    def simulate(self, p: Mapping[str, float], run: DrivenSheet) -> Response:
        """Return the response to a drive, with values of all parameters."""
        raise NotImplementedError

    def predicts(self, run: DrivenSheet) -> frozenset[str]:
        """Return the quantities it predicts for this run: those it can be fitted to."""
        return self.predicts_free if run.free else self.predicts_in_contact

    def start(self) -> dict[str, float]:
        """Return the parameters' starting values."""
        return {one.name: one.start for one in self.parameters}
