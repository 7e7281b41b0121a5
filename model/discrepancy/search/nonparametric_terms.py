"""Candidates that are any smooth function, one for each location of discrepancy.

The columns of such a candidate are basis shapes that share one scale; they bend to whatever is
there and pay for it in the evidence. Where a location explains the data and no effect of the
catalogue does, something is not in the model that the catalogue does not know.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain

import numpy as np

from model.discrepancy.search.evidence import Candidate
from model.discrepancy.thresholds import (
    MANY_NAMES,
    MISSED_BY_FORM_SHARE,
    NONPARAMETRIC_MARGIN_LN,
    SHARE_OF_MANY,
)
from model.identification.foreign_parts import answers_of
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.locations import location, locations, origins
from model.locations.basis import bending_per_m
from model.locations.contract import Basis, BasisTerm, Function, Linearised
from model.measurements import FloatArray

AMPLITUDES = (0.01, 0.03, 0.1, 0.3, 1.0)  # of the basis shapes, to begin with
LEAST_RANGE_N = 1e-6


@dataclass(frozen=True, kw_only=True)
class BasisShape:
    """One basis shape of a location in all data."""

    rows: FloatArray  # (N,)
    configuration: str
    part: str  # see `Basis`
    along: str
    function: Function | None
    unit: str
    span: tuple[float, float, str]
    alone: bool = False  # see `Basis`
    shows: str = ""  # see `Basis`
    points_m: FloatArray | None = None  # (K, S) where the camera moves points along the normal
    # by configuration, as a model file has it; none: no prediction of means could show it
    terms: Mapping[str, BasisTerm] = field(default_factory=dict)

    @property
    def under(self) -> str:
        """At which voltages it acts, and which way: see `BasisTerm`."""
        return next((term.under for term in self.terms.values()), "")

    @property
    def adds(self) -> str:
        """To what it is added: see `BasisTerm`."""
        return next((term.adds for term in self.terms.values()), "")


def shapes(fitted: MixedModelFit, name: str, part: str = "") -> list[BasisShape]:
    """Return the basis shapes of a location as a whole, each once, or those of a part."""
    every = all_shapes(fitted, name)
    return [shape for shape in every if (shape.part == part if part else not shape.alone)]


def all_shapes(fitted: MixedModelFit, name: str) -> list[BasisShape]:
    """Return the basis shapes of all parts of a location, each once."""
    forward, result = fitted.problem.forward, dict[tuple[str, int, str], BasisShape]()
    for c, state in enumerate(fitted.linear.states):
        configuration, counts = forward.names[c], dict[str, int]()
        at = linearised(fitted, c)
        patterns = (one.bases(at) for one in forward.patterns if one.location == name)
        bases = [*_bases(name, at), *chain.from_iterable(patterns)]
        if not bases:
            continue
        every = forward.rows_of_each(c, state, [basis.step for basis in bases])
        for basis, rows in zip(bases, every, strict=True):
            number = counts[basis.part] = counts.get(basis.part, 0) + 1
            key = (basis.part, number, "" if basis.shared else configuration)
            one = _shape(configuration, basis, rows)
            result[key] = _with(result[key], one) if key in result else one
    return [shape for shape in result.values() if np.any(shape.rows)]


def _bases(name: str, at: Linearised) -> list[Basis]:
    """Return the basis shapes of a location; none, after a warning, where somebody else's fails."""
    ask, foreign = partial(location(name).bases, at), origins()
    if name not in foreign:
        return list(ask())
    whose = f"the location of discrepancy '{name}' of {foreign[name]}"
    return answers_of(whose, Basis, ask, "the search goes on") or []


def _shape(configuration: str, basis: Basis, rows: FloatArray) -> BasisShape:
    """Return a basis shape of one configuration."""
    return BasisShape(
        rows=rows, configuration=configuration, part=basis.part, along=basis.along,
        function=basis.function, unit=basis.unit, span=basis.span,
        points_m=basis.step.points_m if np.any(basis.step.points_m) else None,
        terms={} if basis.term is None else {configuration: basis.term}, alone=basis.alone,
        shows=basis.shows,
    )  # fmt: skip


def _with(shape: BasisShape, other: BasisShape) -> BasisShape:
    """Return the shape that acts in another configuration, too.

    It is told of the first one in which it moves a curve: a camera may be knocked amid the second.
    """
    seen = other if shape.points_m is None and other.points_m is not None else shape
    return replace(seen, rows=shape.rows + other.rows, terms={**shape.terms, **other.terms})


def is_nonparametric(name: str) -> bool:
    """Return whether a candidate of this name is a nonparametric term."""
    return name.startswith("unknown:")


def nonparametric_replaces_names(free: float, explained: float, names: int, single: float) -> bool:
    """Return whether the evidence of one free form is more than that of so many names together.

    A single name may be of another form, and lose some of what a free form explains. Three or more
    names bend to much: they have to explain more than a free form by a good part of what the best
    name, which explains `single` by itself, leaves to the others.
    """
    if not names:
        return False
    form = MISSED_BY_FORM_SHARE if names == 1 else 0.0
    if names >= MANY_NAMES:
        explained = min(single + SHARE_OF_MANY * max(explained - single, 0.0), explained)
    return free * (1.0 - form) > explained + NONPARAMETRIC_MARGIN_LN


def unknowns(fitted: MixedModelFit) -> list[Candidate]:
    """Return for each location all of its shapes, and each part that has a profile alone.

    They are computed once at the same states.
    """
    kept = fitted.linear.at_states
    key = ("unknowns", id(fitted.problem.forward), tuple(locations()))
    if key not in kept:
        kept[key] = _unknowns(fitted)
    return list(kept[key])


def _unknowns(fitted: MixedModelFit) -> list[Candidate]:
    result = []
    for name in locations():
        every = all_shapes(fitted, name)
        whole = [s for s in every if not s.alone]
        several = len({s.part for s in whole}) > 1
        parts = dict.fromkeys(s.part for s in every if s.alone or (several and s.function))
        pool = {"": whole} | {part: [s for s in every if s.part == part] for part in parts}
        for part, found in pool.items():
            if found:
                columns = np.stack([s.rows for s in found], axis=1)
                result.append(
                    Candidate(
                        name=f"unknown:{name}",
                        values={},
                        columns=columns,
                        sizes=AMPLITUDES,
                        effect=None,
                        location=name,
                        part=part,
                    )
                )
    return result


def linearised(fitted: MixedModelFit, c: int) -> Linearised:
    """Return a configuration as the locations see it."""
    forward, state = fitted.problem.forward, fitted.linear.states[c]
    configuration_model, block = forward.configuration_models[c], forward.row_block(c)
    return Linearised(
        beam=state.beam, contact=state.solved.contact, weighed=state.weighed,
        points=forward.points(c, state.beam, state.solved), clock=block.clock,
        position_m=configuration_model.stated_m[block.reading_of], reading_of=block.reading_of,
        initial_curvature_per_m=configuration_model.rest(configuration_model.s_m),
        force_at_0V_N=np.nan_to_num(state.solved.force_N) - state.by_eibm,
        measured_at=_measured_at(forward, c), has_curve=configuration_model.has_curve,
        positions_m=_ends(np.concatenate([one.stated_m for one in forward.configuration_models])),
        pictured=tuple(_pictured(forward, each) for each in range(len(forward.names))),
        forces_N=_force_range_N(forward),
        bent_per_m=_most_bent_per_m(fitted), scale=forward.scale,
        bin_clock=block.bin_clock, bin_sample=block.bin_sample,
        bin_mean=block.bin_mean, configuration=forward.names[c],
        nothing=lambda: forward.blank_step(c),
        change=lambda other: configuration_model.change(state.beam, other, state.solved.contact),
    )  # fmt: skip


def _measured_at(forward: ForwardModel, c: int) -> FloatArray:
    """Return when each condition was measured, 0 .. 1 over the session: (K,)."""
    configuration_model, block = forward.configuration_models[c], forward.row_block(c)
    result = block.mean(block.clock.session)
    result[configuration_model.unread] = configuration_model.unread_clock.session
    return result


def _pictured(forward: ForwardModel, c: int) -> tuple[float, float]:
    """Return when the first and the last curve of a configuration were measured."""
    return _ends(_measured_at(forward, c)[forward.configuration_models[c].has_curve])


def _ends(values: FloatArray) -> tuple[float, float]:
    """Return the smallest and the largest finite value; 0 where there is none."""
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)


def _most_bent_per_m(fitted: MixedModelFit) -> float:
    return max(float(np.max(bending_per_m(s.solved.contact))) for s in fitted.linear.states)


def _force_range_N(forward: ForwardModel) -> tuple[float, float]:
    low, high = _ends(np.concatenate([block.measured_N for block in forward.row_index.blocks]))
    return low, max(high, low + LEAST_RANGE_N * forward.scale.force)
