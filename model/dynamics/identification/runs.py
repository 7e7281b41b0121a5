"""What is recorded of a moving sheet: one run, planned or done. It begins discharged and at rest.

Independent of any session file: who reads one, makes these.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from model.dynamics.beam import ContactSetup, HeldVoltage
from model.measurements import FloatArray, ModelError

NONE = np.zeros(0)


@dataclass(frozen=True, kw_only=True)
class RunPlan:
    """What is driven, and what is measured when."""

    drive: HeldVoltage  # as written
    time_s: FloatArray  # (n,) of the samples of force and current
    setup: ContactSetup | None = None  # where the rolls are; None: the load cell is away
    force: bool = True  # is it measured?
    current: bool = True
    frame_s: FloatArray = field(default_factory=lambda: NONE)  # (m,) middle of the exposures
    points_m: FloatArray = field(default_factory=lambda: NONE)  # (p,) of a frame's curve, along s
    configuration: str = "long"
    name: str = "the run"

    def __post_init__(self) -> None:
        """Refuse what cannot be recorded, in a sentence."""
        for what, times in (("samples", self.time_s), ("frames", self.frame_s)):
            if not np.all(np.isfinite(times)) or np.any(np.diff(times) <= 0.0):
                raise ModelError(f"{self.name}: the times of its {what} must be finite and ascend")
            if len(times) and times[0] < 0.0:
                raise ModelError(f"{self.name}: its {what} begin before the run, at time 0")
        if self.force and self.setup is None:
            raise ModelError(f"{self.name}: there is no force where the load cell is away")
        if (self.force or self.current) and not len(self.time_s):
            raise ModelError(f"{self.name}: force and current need the times of their samples")
        if (len(self.frame_s) > 0) != (len(self.points_m) > 0):
            raise ModelError(f"{self.name}: frames need points along the sheet, and these frames")
        if not (self.force or self.current or len(self.frame_s)):
            raise ModelError(f"{self.name}: nothing is measured in it")


@dataclass(frozen=True, kw_only=True)
class RecordedRun:
    """A run with what was measured in it."""

    plan: RunPlan
    force_N: FloatArray | None = None  # (n,)
    current_A: FloatArray | None = None  # (n,)
    x_m: FloatArray | None = None  # (m, p) points of the curves; NaN: not seen
    y_m: FloatArray | None = None

    def __post_init__(self) -> None:
        """Refuse data that are not those of the plan."""
        plan, frames = self.plan, (len(self.plan.frame_s), len(self.plan.points_m))
        seen = len(plan.frame_s) > 0
        for what, data, wanted, shape in (
            ("force", self.force_N, plan.force, plan.time_s.shape),
            ("current", self.current_A, plan.current, plan.time_s.shape),
            ("x of the curves", self.x_m, seen, frames),
            ("y of the curves", self.y_m, seen, frames),
        ):
            if (data is not None) != wanted:
                raise ModelError(
                    f"{plan.name}: {what} is " + ("missing" if wanted else "not part of the run")
                )
            if data is not None and data.shape != shape:
                raise ModelError(f"{plan.name}: {what} has {data.shape} values, not {shape}")
        for what, data in (("force", self.force_N), ("current", self.current_A)):
            if data is not None and not np.all(np.isfinite(data)):
                raise ModelError(f"{plan.name}: {what} must be finite numbers")

    def current_alone(self) -> RecordedRun:
        """Return the run without what the sheet's motion is needed for."""
        plan = replace(self.plan, force=False, frame_s=NONE, points_m=NONE)
        return RecordedRun(plan=plan, current_A=self.current_A)

    def until(self, end_s: float) -> RecordedRun:
        """Return the run's begin; all of it where nothing was measured so soon."""
        plan = self.plan
        samples, frames = (int(np.sum(t <= end_s)) for t in (plan.time_s, plan.frame_s))
        if (samples == 0) != (len(plan.time_s) == 0) or (frames == 0) != (len(plan.frame_s) == 0):
            return self
        return RecordedRun(
            plan=replace(plan, time_s=plan.time_s[:samples], frame_s=plan.frame_s[:frames]),
            force_N=None if self.force_N is None else self.force_N[:samples],
            current_A=None if self.current_A is None else self.current_A[:samples],
            x_m=None if self.x_m is None else self.x_m[:frames],
            y_m=None if self.y_m is None else self.y_m[:frames],
        )
