"""Where the sheet touches the load cell: equilibria of the conditions in contact."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from model.effects.interface import BeamProblem
from model.identification.data.data_vector import DataVector, Index
from model.identification.likelihood.configuration.sheet_elements import SheetElements
from model.measurements import FloatArray, ModelError
from model.mechanics.equilibrium import Equilibria, Problems, SolverStatus, solve

MOST_BESIDE, SAME_RAD = 4, 1e-6  # rounds for a contact beside the point on the arc
BEYOND_RADII = 10.0  # of the arc: how far the piece beyond the sheet's end reaches
LAST_POINTS = 3  # solutions through which a start is extrapolated


def extrapolated(known: Sequence[tuple[float, Equilibria | None]], to: float) -> Equilibria | None:
    """Return a start at `to` by a polynomial (Lagrange's) through the last of some solutions."""
    last = known[-1][1]
    if last is None:
        return None
    alike = [(at, one) for at, one in known if one is not None and one.psi.shape == last.psi.shape][
        -LAST_POINTS:
    ]
    weights = [
        float(np.prod([(to - other) / (at - other) for other, _ in alike if other != at]))
        for at, _ in alike
    ]

    def extrapolate(values: Iterable[FloatArray]) -> FloatArray:
        return np.asarray(sum(w * v for w, v in zip(weights, values, strict=True)))

    every = [one for _, one in alike]
    return replace(
        last,
        nu=extrapolate(one.nu for one in every),
        s_hat_m=extrapolate(one.s_hat_m for one in every),
        phi_hat_rad=extrapolate(one.phi_hat_rad for one in every),
        psi=extrapolate(one.psi for one in every),
    )


def beyond_end(found: Equilibria) -> Equilibria:
    """Return the solutions; those that left the sheet touch a straight piece beyond its end.

    A fit may come by there. It is no part of what is solved at first: a sheet that is bent to a
    ring has another equilibrium with such a piece.
    """
    off = np.flatnonzero(found.status != SolverStatus.SOLVED)
    if not len(off):
        return found
    made = found.problems  # all of them: fewer might be solved with fewer nodes
    beyond_m = made.reach_m + BEYOND_RADII * made.radius_m
    longer = solve(replace(made, reach_m=beyond_m), found)
    result = replace(
        found, status=found.status.copy(), nu=found.nu.copy(), s_hat_m=found.s_hat_m.copy(),
        phi_hat_rad=found.phi_hat_rad.copy(), psi=found.psi.copy(),
    )  # fmt: skip
    for name in ("status", "nu", "s_hat_m", "phi_hat_rad", "psi"):
        getattr(result, name)[off] = getattr(longer, name)[off]
    return result


class ContactSearch:
    """Solves contacts, each from the last solution: `last` of all, another one beside the arc."""

    def __init__(self, data_vector: DataVector, elements: SheetElements) -> None:
        self._look, self._sheet, self._elements = data_vector, data_vector.sheet, elements
        self._stated_m = np.array([o.position_m for o in data_vector.seen])
        self.last: Equilibria | None = None
        # conditions, angles and solution where contacts were last beside the point on the arc
        self.last_beside: tuple[Index, FloatArray, Equilibria] | None = None

    def polar_angle(self, beam: BeamProblem, rows: Index) -> FloatArray:
        """Polar angle of the point on the arc, seen along the clamp."""
        at: FloatArray = (self._stated_m[rows] + beam.shift_m[rows]) / self._sheet.arc_radius_m
        return at + self._sheet.arc_origin_rad - beam.tilt_rad[rows]

    def equilibria(self, beam: BeamProblem, rows: Index) -> list[tuple[Index, Equilibria]]:
        """Return groups of conditions that are solved together, and their equilibria."""
        R = self._sheet.arc_radius_m + beam.reach_m[rows]
        beta, offset = self.polar_angle(beam, rows), beam.offset_m[rows]
        if not np.any(offset) and np.ptp(R) == 0.0:
            start = self.last
            self.last = self._solved(self._problems(beam, rows, beta, float(R[0])), rows, start)
            return [(rows, self.last)]
        return [(rows, self._beside_arc(beam, rows, beta, R))]

    def _beside_arc(
        self, beam: BeamProblem, rows: Index, beta: FloatArray, R: FloatArray
    ) -> Equilibria:
        """Conditions whose curves pass beside their points on the arc, or that have radii apart."""
        made, d = self._problems(beam, rows, beta, float(np.min(R))), beam.offset_m[rows]
        gamma, found = self._begun_beside(rows)
        for _ in range(MOST_BESIDE if np.any(d) else 1):
            tangential, radial = -d * np.cos(gamma), R + d * np.sin(gamma)
            radii = np.hypot(tangential, radial)
            made = replace(
                made, angle_rad=beta + np.arctan2(tangential, radial), radii_m=radii,
                radius_m=float(np.min(radii)),
            )  # fmt: skip
            found = self._solved(made, rows, found)
            before, gamma = gamma, found.phi_hat_rad - beta
            if np.max(np.abs(gamma - before)) < SAME_RAD:
                break
        assert found is not None  # noqa: S101 - there is a round
        self.last_beside = rows, gamma, found
        return found

    def _begun_beside(self, rows: Index) -> tuple[FloatArray, Equilibria | None]:
        """Return angles and solution to begin with beside the arc; none where they are not known.

        The conditions are in ascending order.
        """
        if self.last_beside is None or not np.all(np.isin(rows, self.last_beside[0])):
            return np.zeros(len(rows)), None
        known, gamma, last = self.last_beside
        if len(known) == len(rows):
            return gamma, last
        places = np.searchsorted(known, rows)
        return gamma[places], last.of(places)

    def _problems(
        self, beam: BeamProblem, rows: Index, angle: FloatArray, radius_m: float
    ) -> Problems:
        on = self._elements
        return Problems(
            breaks_m=on.breaks, kappa=on.free_curvature(beam, rows),
            softness=on.compliance(beam, rows), radius_m=radius_m,
            reach_m=on.length + self._sheet.elongation_m, angle_rad=angle,
        )  # fmt: skip

    def _solved(self, made: Problems, rows: Index, start: Equilibria | None) -> Equilibria:
        found = beyond_end(solve(made, start))
        if np.any(found.status != SolverStatus.SOLVED):
            bad = self._look.seen[int(rows[int(np.argmax(found.status != SolverStatus.SOLVED))])]
            raise ModelError(
                f"condition {bad.name}: no equilibrium with these parameters; if the sheet had left"
                " the rolls there, mark its readings invalid or leave the position out (--hold-out)"
            )
        return found
