"""The sheet as collocation elements, and how a beam problem looks on them."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre

from model.effects.interface import BeamProblem
from model.identification.data.data_vector import Index
from model.identification.likelihood.configuration.few_elements import APART_M, on_few_elements
from model.measurements import FloatArray, SheetGeometry, length_scale
from model.mechanics.collocation import rule
from model.mechanics.equilibrium import finer
from model.mechanics.field import Field, legendre_field, merged_breaks, padded
from model.mechanics.free_shape import SharedFreeShapes

STEEPEST_PER_M = 90.0  # free curvature that the elements are made for
NODES_LONG, NODES_SHORT = 14, 6
LONG = 0.4  # of the arc's radius: a sheet longer than that needs the many nodes
MOST_KEPT = 64  # places along free shapes whose integrals are kept


def is_long(sheet: SheetGeometry) -> bool:
    """Whether the sheet is long enough to bend far around the arc."""
    return sheet.free_length_m > LONG * sheet.arc_radius_m


class SheetElements:
    """Nodes along the sheet (G), elements (P), and the way from values at nodes to polynomials.

    A quantity along the sheet is given by its values at the Gauss-Legendre nodes. On each element
    it is a polynomial of `degree` coefficients (P, D); the elongation is a last element that does
    not bend.
    """

    def __init__(self, sheet: SheetGeometry, rest: Field) -> None:
        self.length = sheet.free_length_m
        self.count = G = NODES_LONG if is_long(sheet) else NODES_SHORT
        nodes = rule(G)
        self.s_m = self.length * np.asarray(nodes.c)
        self.weights = np.asarray(nodes.b)  # of a mean over the free length
        self.piece_m = self.length * self.weights
        self.at_rest = rest(self.s_m)  # k0 at the nodes
        degree = max(G, rest.coefficients.shape[1])
        breaks, initial = self._of_rest(rest, degree, sheet)
        basis = [legendre_field(i, self.length).on(breaks) for i in range(G)]
        rows = np.stack([padded(f.coefficients, degree) for f in basis])
        P = len(breaks) - 1
        rigid = sheet.elongation_m > 0.0
        if rigid:
            breaks = np.append(breaks, self.length + sheet.elongation_m)
            rows = np.concatenate([rows, np.zeros((G, 1, degree))], axis=1)
            initial = np.concatenate([initial, np.zeros((1, degree))])
        self.breaks, self._initial = breaks, initial
        t = 2.0 * self.s_m / self.length - 1.0
        to_legendre = np.linalg.inv(legendre.legvander(t, G - 1))  # values at nodes -> coefficients
        self.rows = np.einsum("ig,ipd->gpd", to_legendre, rows)  # (G, P, D)
        self._ones = np.zeros((len(breaks) - 1, degree))
        self._ones[:P, 0] = 1.0
        self.stiff_end = np.zeros_like(self._ones)
        if rigid:
            self.stiff_end[-1, 0] = 1.0
        self._free: dict[bytes, SharedFreeShapes] = {}

    def _of_rest(
        self, rest: Field, degree: int, sheet: SheetGeometry
    ) -> tuple[FloatArray, FloatArray]:
        """Return the elements, and k0 on them (P, D): few where k0 is smooth, else its own."""
        steepest_per_m, radius_m = STEEPEST_PER_M / length_scale(sheet), sheet.arc_radius_m
        whole = finer(np.array([0.0, self.length]), steepest_per_m, radius_m)
        own = finer(merged_breaks([rest.breaks_m]), steepest_per_m, radius_m)
        few = on_few_elements(rest, whole, degree, APART_M * length_scale(sheet))
        on = few if len(few.breaks_m) < len(own) else rest.on(own)
        return on.breaks_m, padded(on.coefficients, degree)

    def free_curvature(self, beam: BeamProblem, k: Index) -> FloatArray:
        """k* = k0 + rest + soft (eibm + bend), without the contact: (len(k), P, D)."""
        values = beam.rest[k] + (beam.eibm[k] + beam.bend[k]) * beam.soft[k]
        rows: FloatArray = self._initial + np.tensordot(values, self.rows, axes=(1, 0))
        return rows

    def compliance(self, beam: BeamProblem, k: Index) -> FloatArray:
        """B/B(s), the elongation's too: (len(k), P, D)."""
        rows: FloatArray = self._ones + np.tensordot(beam.soft[k] - 1.0, self.rows, axes=(1, 0))
        return rows + beam.elongation_soft[k][:, None, None] * self.stiff_end

    def free_shapes(self, s_m: FloatArray) -> SharedFreeShapes:
        """Return free shapes at these places, ascending."""
        key = s_m.tobytes()
        if key not in self._free:
            if len(self._free) >= MOST_KEPT:  # a camera that distorts asks at other s each time
                self._free.clear()
            self._free[key] = SharedFreeShapes(self.breaks, self.rows.shape[2], s_m)
        return self._free[key]
