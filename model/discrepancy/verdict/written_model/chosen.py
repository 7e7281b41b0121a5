"""Choose the model that a file has: with what was found, if it predicts no worse than without.

Where the data do not tell several names apart it may have another one than is named first.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from model.discrepancy.answers.reported_set import of_name
from model.discrepancy.prepare import DiagnoseOptions
from model.discrepancy.search.forward_selection import SearchResult
from model.discrepancy.thresholds import LENGTH_ERROR_SHARE
from model.discrepancy.verdict.decision import Decision
from model.discrepancy.verdict.inferred_form import foretells
from model.discrepancy.verdict.posterior import choice, with_shapes
from model.discrepancy.verdict.stated_errors import with_stated_errors
from model.discrepancy.verdict.written_model.curve_lengths import length_error
from model.discrepancy.verdict.written_model.fitted_model import base_parameters, sheet_model
from model.discrepancy.verdict.written_model.left_out_gain import (
    means_ask_for,
    predicts_better,
)
from model.discrepancy.verdict.written_model.means_of_fit import theta_of, with_means_of
from model.discrepancy.verdict.written_model.solvable import unsolved_at
from model.discrepancy.verdict.written_model.written_form import written
from model.identification.fit import fit
from model.identification.fit_result import ConfigurationFit, Fit
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.identification.options import FitOptions
from model.measurements import Measurements, ModelError
from model.parameter import Parameter
from model.sheet.beam_problem import UNKNOWN
from model.sheet.sheet_model import SheetModel


@dataclass(frozen=True, kw_only=True)
class WrittenModel:
    """What is written of a decision."""

    reported: MixedModelFit  # with what was found, solved with the inferred forms in the model
    # what the file predicts with: `reported`, what it has `instead`, or the base model
    predicting: MixedModelFit
    model: SheetModel  # as a file has it
    # where the model with an inferred form that is left out has no solution; empty: none is
    unsolved: str = ""
    plain: Fit | None = None  # what `model` is of, where it is the base model as `fit` writes it
    instead: str = ""  # the effect that the file has in place of one that is named
    replaced: str = ""  # that one
    not_told_apart: tuple[str, ...] = ()  # names among which the lengths of curves decided

    @property
    def base(self) -> dict[str, dict[str, Parameter]]:
        """B and EIBM of each configuration as the file has them; their ratio without forces."""
        found = base_parameters(self.predicting)
        if self.plain is None:
            return found
        return {
            name: _as_fitted(self.plain.configurations[name], own) for name, own in found.items()
        }

    @property
    def has_unknown(self) -> bool:
        """Whether the file has something unknown."""
        return any(one.name == UNKNOWN for one in self.model.effects)

    @property
    def without(self) -> bool:
        """Whether the file has the base model, without what was found."""
        return self.predicting is not self.reported and not self.instead


@dataclass(frozen=True, kw_only=True)
class Writer:
    """Writes models of a finished search."""

    outcome: SearchResult
    measurements: Measurements
    options: DiagnoseOptions

    def written(self, decision: Decision) -> WrittenModel:
        """Return what is written of a decision; it takes fits, so it is made of the last one.

        The fit knows curves across themselves. Where some of the names that it does not tell apart
        move points along the sheet, it is the one whose curves are as long as measured.
        """
        best = own = self._written(decision)
        others = [] if own.without else list(_others(decision))
        least = self._length_error(own.model) if others else None
        if least is None:
            return own
        for other in others:
            rival = self._written(other)
            error = self._length_error(rival.model)
            if not rival.without and error is not None and error < LENGTH_ERROR_SHARE * least:
                best, least = rival, error
                first, name = (one.named[-1].effect.name for one in (decision, other))
                alike = (first, *of_name(first, decision).confusable_with)
                best = replace(
                    best, reported=own.reported, replaced=first, instead=name, not_told_apart=alike
                )
        return best

    def _length_error(self, model: SheetModel) -> float | None:
        """Return the relative error of predicted lengths; None where no curve shows it."""
        try:
            error = length_error(model, self.outcome.base.problem.forward)
        except ModelError:
            return np.inf
        return None if np.isnan(error) else error

    def _as_long_as_measured(self, model: SheetModel, reported: MixedModelFit) -> SheetModel:
        """Return a model whose camera moves points along the curves only where their lengths do."""
        moving = [one.effect.moves_along_sheet for one in reported.found]
        if not any(moving):
            return model
        effects = [
            replace(one, across_curve=moves)
            for one, moves in zip(model.effects, moving, strict=True)
        ]
        across = replace(model, effects=tuple(effects))
        moved, unmoved = self._length_error(model), self._length_error(across)
        if moved is None or unmoved is None:
            return model
        return across if unmoved <= LENGTH_ERROR_SHARE * moved else model

    def _written(self, decision: Decision) -> WrittenModel:
        """Return what is written of its names; the first fit with an answer everywhere decides."""
        base, reported, unsolved = self.outcome.base, decision.known, ""
        final, free = decision.final, decision.free
        if free is not None and not foretells(decision.known, free):
            final, free = decision.known, None
        for reported in written(decision.known, final, free):
            model = sheet_model(reported, self.measurements, self.options)
            where = "" if reported is base else unsolved_at(model, base.problem.forward)
            if where:
                unsolved = unsolved or where
                continue
            if reported is base or not predicts_better(base, reported):
                break
            if not means_ask_for(base, reported):
                same = self._with_means_of_fit(reported, model)
                if same is None:
                    break
                reported, model = same
            if any(one.ways for one in reported.found):
                unsolved = ""  # begun elsewhere the form has a solution everywhere, and is written
            return WrittenModel(
                reported=reported,
                predicting=reported,
                model=self._with_errors(self._as_long_as_measured(model, reported)),
                unsolved=unsolved,
            )
        found = reported is not base or decision.free is not None
        plain = self._plain if found else None
        model = (
            self._with_errors(sheet_model(base, self.measurements, self.options))
            if plain is None
            else plain.model
        )
        return WrittenModel(
            reported=reported, predicting=base, model=model, unsolved=unsolved, plain=plain
        )

    def _with_means_of_fit(
        self, reported: MixedModelFit, model: SheetModel
    ) -> tuple[MixedModelFit, SheetModel] | None:
        """Return fit and model with mean forces and curves as `fit` has them; None: it cannot be.

        The means do not ask for what was found; so it has no say in them. Both stay as they are
        where there is no such fit.
        """
        plain = self._plain
        with suppress(ModelError, np.linalg.LinAlgError):
            if plain is not None:
                other = with_means_of(plain.model, model, reported)
                if other is None:
                    return None
                if not unsolved_at(other, reported.problem.forward):
                    return replace(reported, theta=theta_of(other, reported)), other
        return reported, model

    @cached_property
    def _plain(self) -> Fit | None:
        """The base model as `fit` writes it; None where that would be another one.

        The search's own is fitted to more than means, and predicts these a little otherwise.
        """
        asked = self.options
        if asked.model is not None or asked.hold_out or self.outcome.outliers:
            return None
        with suppress(ModelError):
            options = FitOptions(symmetric=asked.symmetric, stiffness_Nm2=asked.stiffness_Nm2)
            return fit(self.measurements, options)
        return None

    def _with_errors(self, model: SheetModel) -> SheetModel:
        """Return a model with its errors, where it predicts all that was measured."""
        with suppress(ModelError):
            return with_stated_errors(
                model, self.outcome.base.problem.forward, self.outcome.outliers
            )
        return model


def _as_fitted(one: ConfigurationFit, found: Mapping[str, Parameter]) -> dict[str, Parameter]:
    """Return what `fit` says of the same parameters, by the same names."""
    eibm = {f"EIBM {volts:+g} V": value for volts, value in one.eibm.items()}
    own = {"B_Nm2": one.B, **eibm}
    return {name: own.get(name, value) for name, value in found.items()}


def _others(decision: Decision) -> Iterator[Decision]:
    """Yield decisions for the names that the last one cannot be told from, the likeliest first.

    Where that one or those move points along the sheet.
    """
    if not decision.named or decision.free is not None:
        return
    *earlier, one = decision.named
    ranked = {c.name: c for c in one.ranking if c.known}
    for name in of_name(one.effect.name, decision).confusable_with:
        rival = ranked.get(name)
        if rival is None or rival.fitted is None:
            continue
        instead = choice(rival, one.ranking, one.before)
        if one.effect.moves_along_sheet or instead.effect.moves_along_sheet:
            named = [*earlier, instead]
            known = with_shapes(rival.fitted, named)
            yield replace(decision, named=named, known=known, final=known)
