"""The models that a result shows, each with models one standard deviation away from it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from model import Along, ConfiguredSheet, Fit, Parameter, SheetModel
from model.identification.fit import NODES
from model.identification.joint import Joint
from model.identification.set_up_scatter import ConditionScatter, Place, scatter_of
from model.measurements import FloatArray
from model.sheet.beam_problem import ActiveEffect

SMALLEST_SHARE = 1e-8  # of the largest variance; directions with less are rounding


@dataclass(frozen=True, kw_only=True)
class CandidateModel:
    """A model, and how far its parameters may be from what they are stated to be."""

    id: str
    name: str
    model: SheetModel
    # By configuration, models one standard deviation away in independent directions: by how much
    # their predictions differ from this model's is to be added in squares.
    displaced: Mapping[str, Sequence[SheetModel]]
    # By configuration and place: how a new measurement would scatter about the model
    scatter: Mapping[str, Mapping[Place, ConditionScatter]] = field(default_factory=dict)
    # By configuration and voltage; of an EIBM that varies along the sheet its mean over [0, l]
    eibm: Mapping[str, Mapping[float, Parameter]] = field(default_factory=dict)
    why: str = ""  # what a reader must know of it


def models_of(fitted: Fit | None, with_effects: SheetModel | None) -> list[CandidateModel]:
    """Return both models of a fit, and the one with effects where there is one."""
    if fitted is None:
        return []
    found = [_constant(fitted), _along(fitted)]
    if with_effects is not None:
        found.append(_with_effects(fitted, with_effects))
    names = fitted.joint.forward.names
    scatter = {name: scatter_of(fitted.joint, n) for n, name in enumerate(names)}
    return [replace(one, scatter=scatter) for one in found]


# -- constant EIBM


def _constant(fitted: Fit) -> CandidateModel:
    return CandidateModel(
        id="constant",
        name="constant EIBM",
        model=fitted.model,
        # A constant EIBM is a simplification: by how much it misses the model along the sheet
        # counts like an uncertainty, or measurements would not lie in the band.
        displaced={
            name: [
                *(_moved(fitted.model, name, step) for step in _steps(fitted, name, sheet)),
                fitted.varying_model,
            ]
            for name, sheet in fitted.model.sheets.items()
        },
        eibm={name: one.eibm for name, one in fitted.configurations.items()},
    )


def _steps(fitted: Fit, name: str, sheet: ConfiguredSheet) -> Iterator[FloatArray]:
    """Return independent steps of B and the EIBMs, by the sheet's sigmas and the fit's correlation.

    B and EIBM are strongly correlated: shapes fix their ratio.
    """
    n = fitted.joint.forward.names.index(name)
    rows = fitted.joint.directions(n)
    D = np.array([rows["B"], *(rows[f"EIBM at {v:+g} V"] for v in sheet.eibm)])
    covariance = D @ fitted.joint.fitted.covariance @ D.T
    sigma = np.sqrt(np.diag(covariance))
    stated = np.array([sheet.B.sigma, *(along.sigma[0] for along in sheet.eibm.values())])
    yield from _independent(covariance * np.outer(stated / sigma, stated / sigma))


def _independent(covariance: FloatArray) -> Iterator[FloatArray]:
    """Return the principal directions of a covariance, each one standard deviation long."""
    scale = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    variances, directions = np.linalg.eigh(covariance / np.outer(scale, scale))
    for variance, direction in zip(variances, directions.T, strict=True):
        if variance > SMALLEST_SHARE * variances[-1]:
            yield scale * direction * np.sqrt(variance)


def _moved(model: SheetModel, name: str, step: FloatArray) -> SheetModel:
    sheet = model.sheets[name]
    moved = replace(
        sheet,
        B=_changed(sheet.B, float(step[0])),
        eibm={
            voltage: replace(along, values=along.values + one)
            for (voltage, along), one in zip(sheet.eibm.items(), step[1:], strict=True)
        },
    )
    return replace(model, sheets={**model.sheets, name: moved})


def _changed(parameter: Parameter, by: float) -> Parameter:
    """Return the parameter at another value; a positive one stays positive."""
    value = parameter.value
    if parameter.positive and value > 0.0:
        return replace(parameter, value=float(value * np.exp(by / value)))
    return replace(parameter, value=value + by)


# -- EIBM along the sheet


def _along(fitted: Fit) -> CandidateModel:
    model = fitted.varying_model
    return CandidateModel(
        id="along",
        name="EIBM along the sheet",
        model=model,
        displaced={
            name: [
                replace(model, sheets={**model.sheets, name: _at(joint, n, model.sheets[name])})
                for joint in _displaced(fitted.joint, n)
            ]
            for n, name in enumerate(fitted.joint.forward.names)
        },
        eibm={name: one.eibm_mean for name, one in fitted.configurations.items()},
    )


def _displaced(joint: Joint, n: int) -> Iterator[Joint]:
    """Return fits with the parameters of one configuration moved along independent directions."""
    own = joint.own_parameters(n)
    theta = joint.fitted.theta
    for step in _independent(joint.fitted.covariance[np.ix_(own, own)]):
        moved = theta.copy()
        moved[own] += step
        yield replace(joint, fitted=replace(joint.fitted, theta=moved))


def _at(joint: Joint, n: int, sheet: ConfiguredSheet) -> ConfiguredSheet:
    """Return one configuration as displaced parameters have it."""
    s_m = np.linspace(0.0, sheet.sheet.free_length_m, NODES)
    rest = sheet.rest
    if not joint.rest_known[n]:
        rest = Along(s_m, joint.rest(n)(s_m), np.zeros(NODES), "1/m")
    eibm = {
        voltage: Along(s_m, joint.along(n, voltage, s_m)[0], np.zeros(NODES), "N m")
        for voltage in sheet.eibm
    }
    return replace(sheet, B=joint.stiffness(n), rest=rest, eibm=eibm)


# -- effects


def _with_effects(fitted: Fit, model: SheetModel) -> CandidateModel:
    known = [name for name in model.sheets if name in fitted.model.sheets]
    return CandidateModel(
        id="effects",
        name="effects found",
        model=replace(model, sheets={name: model.sheets[name] for name in known}),
        displaced={
            name: [
                *(_moved(model, name, step) for step in _steps(fitted, name, model.sheets[name])),
                *_with_other_effects(model, name),
            ]
            for name in known
        },
        eibm={name: _means(model.sheets[name]) for name in known},
        why=f"Effects: {', '.join(effect.name for effect in model.effects)}. The band leaves out "
        "how B and EIBM depend on the effects' parameters.",
    )


def _means(sheet: ConfiguredSheet) -> dict[float, Parameter]:
    """Return the constant EIBMs that a model states; a mean along the sheet has no sigma there."""
    return {
        voltage: Parameter(
            value=float(along.values[0]),
            sigma=float(along.sigma[0]),
            unit=along.unit,
            freedom=sheet.B.freedom,
        )
        for voltage, along in sheet.eibm.items()
        if len(along.values) == 1
    }


def _with_other_effects(model: SheetModel, name: str) -> Iterator[SheetModel]:
    """Return models with one effect's parameter one standard deviation away."""
    for i, effect in enumerate(model.effects):
        own = name in effect.by_configuration
        parameters = effect.by_configuration[name] if own else effect.parameters
        for key, parameter in parameters.items():
            if parameter.sigma > 0.0:
                changed = {**parameters, key: _changed(parameter, parameter.sigma)}
                moved = _replaced(effect, name if own else None, changed)
                yield model.with_effects(*model.effects[:i], moved, *model.effects[i + 1 :])


def _replaced(
    effect: ActiveEffect, name: str | None, parameters: Mapping[str, Parameter]
) -> ActiveEffect:
    if name is None:
        return replace(effect, parameters=parameters)
    return replace(effect, by_configuration={**effect.by_configuration, name: parameters})
