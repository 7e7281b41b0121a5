"""What can be compared: published models, and the full model of the moving sheet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from model.dynamics.beam import DynamicBeam
from model.dynamics.comparison.compared_run import MeasuredRun
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.predicted_run import predict
from model.dynamics.models import ModelParameter, PublishedModel, Response
from model.dynamics.motion import Resolution

PLACES = 41  # of a curve
WIDEST = 30.0  # bound of a logarithm


class Contender(Protocol):
    """A model with parameters to be fitted."""

    @property
    def name(self) -> str:
        """Return its key."""

    @property
    def title(self) -> str:
        """Return what people call it."""

    @property
    def parameters(self) -> tuple[ModelParameter, ...]:
        """Return what a fit finds."""

    def respond(self, values: Mapping[str, float], run: MeasuredRun) -> Response:
        """Return the response at the run's samples and frames. Raises ModelError."""


@dataclass(frozen=True)
class PublishedContender:
    """A model from the literature."""

    model: PublishedModel

    @property
    def name(self) -> str:
        """Return its key."""
        return self.model.name

    @property
    def title(self) -> str:
        """Return what people call it."""
        return self.model.title

    @property
    def parameters(self) -> tuple[ModelParameter, ...]:
        """Return what a fit finds."""
        return self.model.parameters

    def respond(self, values: Mapping[str, float], run: MeasuredRun) -> Response:
        """Return the response at the run's samples and frames. Raises ModelError."""
        return run.sampled(self.model.simulate(values, run.driven))


@dataclass(frozen=True)
class FullContender:
    """The moving sheet: `start` has its starting values, the centres of the priors."""

    start: DynamicBeam
    resolution: Resolution

    @property
    def name(self) -> str:
        """Return its key."""
        return "full"

    @property
    def title(self) -> str:
        """Return what people call it."""
        return "moving sheet of large deflections (labrig)"

    @cached_property
    def parameters(self) -> tuple[ModelParameter, ...]:
        """Return those of `identify`, with its priors; signs are kept apart."""
        return tuple(
            ModelParameter(
                name=one.name, meaning=one.name.replace("_", " "), unit=one.unit,
                start=abs(one.value), low=abs(one.value) * np.exp(-WIDEST),
                high=abs(one.value) * np.exp(WIDEST), prior_scale=one.prior_sigma,
            )
            for one in self._logarithms.quantities
        )  # fmt: skip

    @cached_property
    def _logarithms(self) -> LogParameters:
        return LogParameters(self.start)

    def respond(self, values: Mapping[str, float], run: MeasuredRun) -> Response:
        """Return the response at the run's samples and frames. Raises ModelError."""
        theta = np.log([values[one.name] for one in self.parameters])
        plan, length = run.plan, self.start.length_m
        if len(plan.frame_s):
            plan = replace(plan, points_m=np.linspace(0.0, length, PLACES))
        said = predict(self._logarithms.beam(theta), plan, self.resolution)
        seen = len(plan.frame_s) > 0
        return Response(
            force_N=said.force_N if plan.force else None,
            current_A=said.current_A if plan.current else None,
            curves_m=(said.x_m, said.y_m) if seen else None,
        )
