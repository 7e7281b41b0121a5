"""B and EIBM of each set-up, beside the common ones of its configuration.

A set-up's share in them is a random effect of the joint fit; what the data most likely say of it,
and how unsure that is together with the common parameters, are Henderson's mixed model equations
(Henderson 1975) at the scatter that was estimated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.identification.joint import Joint
from model.identification.likelihood.random_effects import own_slots
from model.measurements import FloatArray
from model.parameter import Parameter


@dataclass(frozen=True, kw_only=True)
class MountingParameters:
    """One run: the conditions that were measured without anything being set anew."""

    configuration: str
    position_m: float | None  # None: a free shape
    mounting: int
    run: int
    B: Parameter
    eibm: dict[float, Parameter]  # (9) by the voltages of this run


def by_run(joint: Joint) -> tuple[MountingParameters, ...]:
    """All set-ups, configuration by configuration, along the arc, in the order of mounting."""
    fitted, names = joint.fitted, joint.forward.names
    added = np.concatenate(list(fitted.added().values()), axis=1)  # (R, Q)
    runs = [(r, _conditions(joint, r)) for r in range(len(added))]
    found = [_SetUp(joint, r, own, added[r]).result() for r, own in runs if own]
    return tuple(sorted(found, key=lambda one: (names.index(one.configuration), *_order(one))))


def _conditions(joint: Joint, r: int) -> list[int]:
    """Return the conditions of a run, except those that read the load cell alone."""
    key = joint.forward.row_index.runs[r]
    seen = joint.forward.data_vectors[joint.forward.names.index(key[0])].seen
    return [k for k, one in enumerate(seen) if one.run == key and not one.zero]


def _order(one: MountingParameters) -> tuple[float, int, int]:
    place = np.inf if one.position_m is None else one.position_m
    return place, one.mounting, one.run


class _SetUp:
    """One run while its values are put together."""

    def __init__(self, joint: Joint, r: int, conditions: list[int], added: FloatArray) -> None:
        self.joint, self.conditions, self.added = joint, conditions, added
        self.key = joint.forward.row_index.runs[r]
        self.n = joint.forward.names.index(self.key[0])
        data, solution = joint.fitted.linear.data, joint.fitted.solution
        widths = [group.shape[2] for group in data.groups]
        names = joint.fitted.problem.noise.random_effects
        self.first = dict(zip(names, np.cumsum([0, *widths[:-1]]).tolist(), strict=True))
        sigma = np.exp(solution.log_sigma[: len(widths)])
        G = np.repeat(sigma**2, widths)
        Z = np.concatenate([group[r] for group in data.groups], axis=1)
        X, W, self.C = data.X[r], solution.weights[r], solution.covariance
        between = X.T @ W @ (Z * G)  # (p, Q)
        self.mixed = -self.C @ between  # of what is estimated wrong in beta and in u
        own = (Z * G).T @ W @ (Z * G)
        self.of_u = np.diag(G) - own + between.T @ self.C @ between

    def result(self) -> MountingParameters:
        n, directions = self.n, self.joint.directions(self.n)
        seen, slots = self.joint.forward.data_vectors[n].seen, own_slots(self.joint.forward)[n]
        eibm = {}
        for k in self.conditions:
            volts = seen[k].voltage_V
            if volts:
                scatter, _, place = slots[k]
                columns = [self.first["eibm"], self.first[scatter] + place]
                common = self.joint.constant_eibm(n, volts)
                eibm[volts] = self._here(common, directions[f"EIBM at {volts:+g} V"], columns)
        B = self._here(self.joint.stiffness(n), directions["B"], [self.first["stiffness"]])
        configuration, position_m, mounting, run, _ = self.key
        return MountingParameters(
            configuration=configuration, mounting=mounting, run=run, B=B, eibm=eibm,
            position_m=position_m if np.isfinite(position_m) else None,
        )  # fmt: skip

    def _here(self, common: Parameter, direction: FloatArray, columns: list[int]) -> Parameter:
        """Return a common value times (1 + this set-up's shares), with the uncertainty of both."""
        share = 1.0 + float(np.sum(self.added[columns]))
        row, of = share * direction, np.zeros(len(self.added))
        of[columns] = common.value
        variance = row @ self.C @ row + 2.0 * row @ self.mixed @ of + of @ self.of_u @ of
        # what makes the common value doubtful in a systematic way is no less so here
        doubt = max(0.0, common.sigma**2 - float(direction @ self.C @ direction))
        sigma = float(np.sqrt(max(0.0, float(variance)) + doubt * share**2))
        return Parameter(value=common.value * share, sigma=sigma, unit=common.unit)
