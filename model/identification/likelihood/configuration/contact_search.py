"""Where the sheet touches the load cell: equilibria of the conditions in contact."""

from __future__ import annotations

import numpy as np

from model.effects.interface import BeamProblem
from model.identification.data.data_vector import DataVector, Index
from model.identification.likelihood.configuration.sheet_elements import SheetElements
from model.measurements import FloatArray, ModelError
from model.mechanics.equilibrium import Equilibria, Problems, SolverStatus, solve

MOST_BESIDE, SAME_RAD = 4, 1e-6  # rounds for a contact beside the point on the arc


class ContactSearch:
    """Solves contacts, each from the last solution: `last` of all, one of each beside the arc."""

    def __init__(self, look: DataVector, elements: SheetElements) -> None:
        self._look, self._sheet, self._elements = look, look.sheet, elements
        self._stated_m = np.array([o.position_m for o in look.seen])
        # by condition: angle and solution where the contact was last beside the point on the arc
        self._beside: dict[int, tuple[float, Equilibria]] = {}
        self.last: Equilibria | None = None

    def polar_angle(self, beam: BeamProblem, rows: Index) -> FloatArray:
        """Polar angle of the point on the arc, seen along the clamp."""
        at: FloatArray = (self._stated_m[rows] + beam.shift_m[rows]) / self._sheet.arc_radius_m
        return at + self._sheet.arc_origin_rad - beam.tilt_rad[rows]

    def equilibria(self, beam: BeamProblem, rows: Index) -> list[tuple[Index, Equilibria]]:
        """Return groups of conditions with contacts at the same radius, and their equilibria."""
        R = self._sheet.arc_radius_m + beam.reach_m[rows]
        beta, offset = self.polar_angle(beam, rows), beam.offset_m[rows]
        if not np.any(offset) and np.ptp(R) == 0.0:
            start = self.last
            self.last = self._solve(beam, rows, beta, float(R[0]), start)
            return [(rows, self.last)]
        each = zip(rows.tolist(), beta.tolist(), offset.tolist(), strict=True)
        return [(np.array([row]), self._beside_arc(beam, row, b, d)) for row, b, d in each]

    def _beside_arc(self, beam: BeamProblem, row: int, beta: float, d: float) -> Equilibria:
        """One condition whose curve passes beside the point on the arc, by `d`."""

        def solved(gamma: float, start: Equilibria | None) -> Equilibria:
            tangential, radial = -d * np.cos(gamma), R + d * np.sin(gamma)
            angle = np.array([beta + np.arctan2(tangential, radial)])
            radius_m = float(np.hypot(tangential, radial))
            return self._solve(beam, np.array([row]), angle, radius_m, start)

        R = self._sheet.arc_radius_m + float(beam.reach_m[row])
        last = self._beside.get(row)
        gamma = last[0] if last else 0.0
        found = solved(gamma, last[1] if last else None)
        for _ in range(MOST_BESIDE - 1 if d else 0):
            before, gamma = gamma, float(found.phi_hat_rad[0]) - beta
            if abs(gamma - before) < SAME_RAD:
                break
            found = solved(gamma, found)
        self._beside[row] = gamma, found
        return found

    def _solve(
        self, beam: BeamProblem, rows: Index, angle: FloatArray, radius_m: float,
        start: Equilibria | None = None,
    ) -> Equilibria:  # fmt: skip
        reach = self._elements.length + self._sheet.elongation_m + 10.0 * radius_m
        on = self._elements
        made = Problems(
            breaks_m=on.breaks, kappa=on.free_curvature(beam, rows),
            softness=on.compliance(beam, rows), radius_m=radius_m, reach_m=reach, angle_rad=angle,
        )  # fmt: skip
        found = solve(made, start)
        if np.any(found.status != SolverStatus.SOLVED):
            bad = self._look.seen[int(rows[int(np.argmax(found.status != SolverStatus.SOLVED))])]
            raise ModelError(f"condition {bad.name}: no equilibrium with these parameters")
        return found
