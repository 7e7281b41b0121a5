"""What is in no catalogue, as an effect: nonparametric terms act where their location says."""

# ruff: noqa: ARG002 - it has no parameters; its terms say everything

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.effects.interface import (
    AcquisitionTimes,
    BeamProblem,
    ContactSolution,
    Effect,
    ImagePoints,
    LoadCellInput,
    Values,
)
from model.locations import Location
from model.measurements import FloatArray
from model.sheet.beam_problem import UNKNOWN, Profile
from model.sheet.effect_hooks import Acting
from model.sheet.form import Form


@dataclass(frozen=True, kw_only=True)
class FreeEffect(Effect):
    """Terms of one location in one configuration."""

    where: Location
    terms: tuple[Profile, ...] = ()

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        for term in self.terms:
            beam = self.where.bent(beam, contact, term)
        return beam

    def course(self, clock: AcquisitionTimes, p: Values) -> tuple[FloatArray, FloatArray] | None:
        """See `Effect.course`."""
        found = [self.where.course(clock, term) for term in self.terms]
        return _sum([both for both in found if both is not None])

    def force(self, weighed: LoadCellInput, p: Values) -> FloatArray | None:
        """See `Effect.force`."""
        found = [self.where.force(weighed, term) for term in self.terms]
        added = [one for one in found if one is not None]
        return np.asarray(np.sum(added, axis=0)) if added else None

    def curve(self, points: ImagePoints, p: Values) -> tuple[FloatArray, FloatArray] | None:
        """See `Effect.curve`."""
        found = [self.where.curve(points, term) for term in self.terms]
        return _sum([both for both in found if both is not None])

    def in_image(self, clock: AcquisitionTimes, p: Values) -> FloatArray | None:
        """See `Effect.in_image`."""
        position_m = np.broadcast_to(clock.position_m, clock.voltage_V.shape)
        found = [self.where.in_image(clock, position_m, term) for term in self.terms]
        seen = [one for one in found if one is not None]
        return np.asarray(np.sum(seen, axis=0)) if seen else None


def _sum(found: Sequence[tuple[FloatArray, FloatArray]]) -> tuple[FloatArray, FloatArray] | None:
    if not found:
        return None
    first, second = (np.sum([both[i] for both in found], axis=0) for i in (0, 1))
    return np.asarray(first), np.asarray(second)


def free_effect(where: Location) -> FreeEffect:
    """Return the effect of a location, without terms as yet."""
    return FreeEffect(
        name=f"{UNKNOWN}:{where.name}", meaning=where.meaning, form="", location=where.name,
        signature=where.depends, isolates="", source="", parameters=(), form_error_along=(),
        of_the_rig=True, where=where,
    )  # fmt: skip


def acting_with(effect: Effect, values: Values, form: Form | None) -> Acting:
    """Return an effect with numbers and form; the form of what is in no catalogue is its terms."""
    if isinstance(effect, FreeEffect):
        return Acting(replace(effect, terms=() if form is None else form.terms), values)
    return Acting(effect, values, form)
