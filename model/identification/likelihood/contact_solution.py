"""Solution of the conditions of one configuration, with sensitivities of forces and curves.

Quantities along the sheet are values at Gauss-Legendre nodes; a change of any of them, of
stiffness, contact or clamp becomes a change of forces and curve modes through one matrix, so that
the signatures of all effects cost next to nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from model.effects.interface import AcquisitionTimes, BeamProblem, ContactSolution
from model.identification.data.data_vector import DataVector, Index, shares
from model.identification.likelihood.configuration.contact_search import (
    ContactSearch,
    extrapolated,
)
from model.identification.likelihood.configuration.sheet_elements import SheetElements, is_long
from model.identification.likelihood.configuration.stacked_curves import StackedCurves
from model.measurements import FloatArray
from model.mechanics.equilibrium import Directions, Equilibria
from model.mechanics.field import Field

MODES_LONG, MODES_SHORT = 10, 5


@dataclass(frozen=True)
class Sensitivities:
    """Derivatives of force (K, Q) and modes (K, M, Q), by the `ConfigurationModel.columns`."""

    force: FloatArray
    modes: FloatArray


@dataclass(frozen=True, kw_only=True)
class SolvedConditions:
    """The solution of a `BeamProblem`."""

    contact: ContactSolution
    force_N: FloatArray  # (K,) NaN: free
    modes_m: FloatArray  # (K, M) of the distance measured - predicted; NaN: no curve
    s_m: FloatArray  # (K, S) place along the sheet that each measured point is compared with
    x_m: FloatArray  # (K, S) predicted points there, in the frame of the picture
    y_m: FloatArray
    nx: FloatArray  # (K, S) normal there
    ny: FloatArray


class ConfigurationModel:
    """One configuration's geometry, and the conditions it was measured in."""

    def __init__(self, data_vector: DataVector, rest: Field) -> None:
        self.data_vector, self.sheet, self.rest = data_vector, data_vector.sheet, rest
        self.length = data_vector.sheet.free_length_m
        self._elements = elements = SheetElements(data_vector.sheet, rest)
        self.count, self.s_m, self.weights = elements.count, elements.s_m, elements.weights
        self.at_rest = elements.at_rest  # k0 at the nodes
        self.modes = MODES_LONG if is_long(data_vector.sheet) else MODES_SHORT
        seen = data_vector.seen
        self.clock = AcquisitionTimes.joined([o.clock for o in seen if len(o.force_N)])
        self.reading_of = np.array(
            [k for k, o in enumerate(seen) for _ in o.force_N], dtype=np.int64
        )
        self.share = np.concatenate([np.zeros(0), *(shares(o) for o in seen)])
        self.K = len(seen)
        self.voltage_V = np.array([o.voltage_V for o in seen])
        self.stated_m = np.array([o.position_m for o in seen])
        self.up = np.array([o.up for o in seen])
        self.upright = np.array([np.cos(o.tilt_rad) for o in seen])
        self.session_number = np.array([float(o.session) for o in seen])
        self.touching = np.flatnonzero(~np.isnan(self.stated_m))
        # not those in which the load cell alone is read
        self.free = np.flatnonzero([o.free and not o.zero for o in seen])
        # those whose shape alone was recorded, free or held
        self.unread = np.flatnonzero([not len(o.force_N) for o in seen])
        self.unread_clock = AcquisitionTimes.joined([seen[k].clock for k in self.unread])
        # times whose mean a condition is, of which condition each is, and its share
        self.mean_times = (
            AcquisitionTimes.joined([self.clock, self.unread_clock]),
            np.concatenate([self.reading_of, self.unread]),
            np.concatenate([self.share, np.ones(len(self.unread))]),
        )
        end_m = self.length + self.sheet.elongation_m
        curves = StackedCurves([o.curve for o in seen], end_m, self.modes)
        self.has_curve, self.points, self.project = curves.given, curves.points, curves.project
        self.curve_s, self.curve_x, self.curve_y = curves.s_m, curves.x_m, curves.y_m
        self._grid_s = np.broadcast_to(self.s_m, (self.K, self.count))
        self._contacts = ContactSearch(data_vector, elements)
        self._found: list[tuple[Index, Equilibria]] = []  # of the last solution

    def measured(self, k: int) -> tuple[FloatArray, FloatArray, FloatArray]:
        """s, x and y of a condition's curve as far as the sheet goes, m; empty: none."""
        n = int(self.points[k])
        return self.curve_s[k, :n], self.curve_x[k, :n], self.curve_y[k, :n]

    def along(self, k: int, modes: FloatArray) -> FloatArray:
        """Distance at each point of the padded curve (S,) that has these modes (M,), m."""
        result: FloatArray = np.linalg.pinv(self.project[k]) @ modes
        return result

    def beam(
        self,
        stiffness: float,
        eibm: Mapping[float, FloatArray | float],
        rest: FloatArray | None = None,
    ) -> BeamProblem:
        """Return the base model: B, and Me/B (G,) for each driving voltage; `rest` (G,) adds to k0.

        An Me/B that is one number is the same everywhere.
        """
        K, G = self.K, self.count
        bent = np.zeros((K, G))
        for k, voltage in enumerate(self.voltage_V):
            bent[k] = eibm.get(voltage, 0.0)
        none = np.zeros(K)
        change = np.zeros((K, G)) if rest is None else np.broadcast_to(rest, (K, G)).copy()
        return BeamProblem(
            sheet=self.sheet, s_m=self.s_m, voltage_V=self.voltage_V, stated_m=self.stated_m,
            up=self.up, stiffness=np.full(K, stiffness), rest=change, eibm=bent,
            bend=np.zeros((K, G)), soft=np.ones((K, G)), elongation_soft=none,
            shift_m=none.copy(), tilt_rad=none.copy(), offset_m=none.copy(),
            reach_m=none.copy(), piece_m=self._elements.piece_m,
            clock=self.clock, reading_of=self.reading_of, share=self.share, upright=self.upright,
            session_number=self.session_number,
        )  # fmt: skip

    # -- solving

    def solve(self, beam: BeamProblem) -> SolvedConditions:
        """All conditions; a `ModelError` names one that has no equilibrium."""
        K, G, S = self.K, self.count, self.curve_s.shape[1]
        contact = replace(_nothing_held(K, G), at_rest=self.at_rest)
        x, y, phi = np.zeros((K, S)), np.zeros((K, S)), np.zeros((K, S))
        self._found = self._contacts.equilibria(beam, self.touching) if len(self.touching) else []
        for rows, found in self._found:
            at = [self._grid_s[rows], self.curve_s[rows], np.full((len(rows), 1), self.length)]
            shapes = found.shapes(np.concatenate(at, axis=1))
            contact.x_m[rows], contact.y_m[rows] = shapes.x_m[:, :G], shapes.y_m[:, :G]
            contact.phi_rad[rows] = shapes.phi_rad[:, :G]
            contact.curvature[rows] = shapes.curvature_per_m[:, :G]
            contact.end_phi_rad[rows] = shapes.phi_rad[:, -1]
            x[rows], y[rows] = shapes.x_m[:, G:-1], shapes.y_m[:, G:-1]
            phi[rows] = shapes.phi_rad[:, G:-1]
            self._hold(beam, rows, found, contact)
        for k in self.free.tolist():
            x[k], y[k], phi[k] = self._hang(beam, k, contact)
        return self._compared(beam, contact, self.curve_s, (x, y, phi))

    def at(self, beam: BeamProblem, solved: SolvedConditions, s_m: FloatArray) -> SolvedConditions:
        """Return the last solution with its curves at other places along the sheet (K, S)."""
        x, y, phi = (np.zeros(s_m.shape) for _ in range(3))
        for rows, found in self._found:
            shapes = found.shapes(s_m[rows])
            x[rows], y[rows], phi[rows] = shapes.x_m, shapes.y_m, shapes.phi_rad
        for k in self.free.tolist():
            kappa = self._elements.free_curvature(beam, np.array([k]))[0]
            places, back = np.unique(s_m[k], return_inverse=True)
            x[k], y[k], phi[k] = (a[back] for a in self._elements.free_shapes(places).shape(kappa))
        return self._compared(beam, solved.contact, s_m, (x, y, phi))

    def _compared(
        self, beam: BeamProblem, contact: ContactSolution, s_m: FloatArray,
        curves: tuple[FloatArray, FloatArray, FloatArray],
    ) -> SolvedConditions:  # fmt: skip
        """Return a solution with its curves (x, y, phi) compared with the measured ones."""
        x, y, phi = curves
        tilt = beam.tilt_rad[:, None]
        cos, sin = np.cos(tilt), np.sin(tilt)
        px, py = cos * x - sin * y, sin * x + cos * y
        nx, ny = -np.sin(phi + tilt), np.cos(phi + tilt)
        off = (self.curve_x - px) * nx + (self.curve_y - py) * ny
        modes = np.einsum("kms,ks->km", self.project, off)
        modes[~self.has_curve] = np.nan
        return SolvedConditions(
            contact=contact, force_N=contact.force_N.copy(), modes_m=modes, s_m=s_m,
            x_m=px, y_m=py, nx=nx, ny=ny,
        )  # fmt: skip

    def forces(self, beam: BeamProblem, some: Index | None = None) -> FloatArray:
        """Return forces alone (K,), of some touching conditions (None: all); others are NaN.

        The solution kept for derivatives is not changed.
        """
        with self._contacts_of(some) as asked:
            return self._forces(beam, asked)

    def forces_at_sizes(
        self, beam: BeamProblem, sizes: Sequence[float], some: Index | None = None
    ) -> list[FloatArray]:
        """Return the same with an EIBM of other sizes, 1 being the size that was solved last.

        Each begins where those before it lead, so neighbours come one after the other.
        """
        results, contacts = list[FloatArray](), self._contacts
        with self._contacts_of(some) as asked:
            known = [(1.0, contacts.last)]
            for size in sizes:
                contacts.last = extrapolated(known, size)
                results.append(self._forces(replace(beam, eibm=beam.eibm * size), asked))
                known.append((size, contacts.last))
        return results

    @contextmanager
    def _contacts_of(self, some: Index | None) -> Iterator[Index]:
        """Have solutions begin at the last one's rows, and put it back in the end."""
        contacts = self._contacts
        last, beside = contacts.last, contacts.last_beside
        if last is not None and some is not None:
            contacts.last = last.of(np.searchsorted(self.touching, some))
        try:
            yield self.touching if some is None else some
        finally:
            contacts.last, contacts.last_beside = last, beside

    def _forces(self, beam: BeamProblem, asked: Index) -> FloatArray:
        result = np.full(self.K, np.nan)
        for rows, found in self._contacts.equilibria(beam, asked) if len(asked) else []:
            gamma = found.phi_hat_rad - self._contacts.polar_angle(beam, rows)
            result[rows] = beam.stiffness[rows] * found.nu * np.cos(gamma)
        return result

    def modes_of(self, beam: BeamProblem, s_m: FloatArray | None = None) -> FloatArray:
        """Modes of the distances measured - predicted alone (K, M), likewise; at s (K, S)."""
        last, beside, kept = self._contacts.last, self._contacts.last_beside, self._found
        found = self.solve(beam)
        if s_m is not None and s_m is not self.curve_s:
            found = self.at(beam, found, s_m)
        result = found.modes_m
        self._contacts.last, self._contacts.last_beside, self._found = last, beside, kept
        return result

    def _hold(
        self, beam: BeamProblem, rows: Index, found: Equilibria, contact: ContactSolution
    ) -> None:
        R = self.sheet.arc_radius_m + beam.reach_m[rows]
        beta, B = self._contacts.polar_angle(beam, rows), beam.stiffness[rows]
        phi, offset = found.phi_hat_rad, beam.offset_m[rows]
        contact.normal_N[rows], contact.gamma_rad[rows] = B * found.nu, phi - beta
        contact.force_N[rows] = B * found.nu * np.cos(phi - beta)
        contact.s_hat_m[rows] = found.s_hat_m
        dx = (R * np.cos(beta) + offset * np.sin(phi))[:, None] - contact.x_m[rows]
        dy = (R * np.sin(beta) - offset * np.cos(phi))[:, None] - contact.y_m[rows]
        cos, sin = np.cos(phi)[:, None], np.sin(phi)[:, None]
        before = self._grid_s[rows] <= found.s_hat_m[:, None]
        contact.lever[rows] = np.where(before, dx * cos + dy * sin, 0.0)
        contact.offset[rows] = np.where(before, dy * cos - dx * sin, 0.0)

    def _hang(
        self, beam: BeamProblem, k: int, contact: ContactSolution
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the free shape of condition k, which has no force and needs no solver."""
        G = self.count
        kappa = self._elements.free_curvature(beam, np.array([k]))[0]
        at = np.concatenate([self.s_m, self.curve_s[k], [self.length]])
        places, back = np.unique(at, return_inverse=True)
        x, y, phi = (a[back] for a in self._elements.free_shapes(places).shape(kappa))
        contact.x_m[k], contact.y_m[k], contact.phi_rad[k] = x[:G], y[:G], phi[:G]
        contact.curvature[k], contact.end_phi_rad[k] = (
            Field(self._elements.breaks, kappa)(self.s_m),
            phi[-1],
        )
        return x[G:-1], y[G:-1], phi[G:-1]

    # -- derivatives

    @property
    def columns(self) -> int:
        """Numbers in a step.

        k* at the nodes (G), c at the nodes (G), elongation, the contact's polar angle and radius,
        the arc's direction, ln B at the same k*, tilt of the picture.
        """
        return 2 * self.count + 6

    def answers(self, beam: BeamProblem, solved: SolvedConditions) -> Sensitivities:
        """How force and modes answer to a change of a `BeamProblem`, at a solution of it."""
        K, G, M, Q = self.K, self.count, self.modes, self.columns
        force, modes = np.zeros((K, Q)), np.zeros((K, M, Q))
        kappa = np.concatenate(
            [self._elements.rows, np.zeros((G + 3, *self._elements.rows.shape[1:]))]
        )
        none = np.zeros_like(self._elements.rows)
        soft = np.concatenate(
            [none, self._elements.rows, self._elements.stiff_end[None], none[:1], none[:1]]
        )
        one = np.zeros((1, 2 * G + 3))
        angle, radius = one.copy(), one.copy()
        angle[0, -2], radius[0, -1] = 1.0, 1.0
        to = Directions.of(kappa[None], soft[None], angle, radius)
        for rows, equilibria in self._found:
            B, gamma = beam.stiffness[rows], solved.contact.gamma_rad[rows]
            _, found = equilibria.answers(solved.s_m[rows], to)
            turn = solved.contact.normal_N[rows] * np.sin(gamma)
            n = 2 * G + 3
            force[rows, :n] = (B * np.cos(gamma))[:, None] * found.nu
            force[rows, :n] -= turn[:, None] * found.phi_hat
            force[rows, n] = turn  # gamma = phi_hat - beta
            force[rows, n + 1] = solved.contact.force_N[rows]
            cos, sin = (f(beam.tilt_rad[rows])[:, None, None] for f in (np.cos, np.sin))
            dx, dy = cos * found.x - sin * found.y, sin * found.x + cos * found.y
            sideways = dx * solved.nx[rows][:, None] + dy * solved.ny[rows][:, None]
            modes[rows, :, :n] = np.einsum("kms,kqs->kmq", self.project[rows], sideways)
        for k in self.free.tolist():
            modes[k, :, :G] = self._free_answers(beam, k, solved)
        turned = solved.x_m * solved.ny - solved.y_m * solved.nx
        modes[:, :, -1] = np.einsum("kms,ks->km", self.project, turned)
        return Sensitivities(force, modes)

    def _free_answers(self, beam: BeamProblem, k: int, solved: SolvedConditions) -> FloatArray:
        kappa = self._elements.free_curvature(beam, np.array([k]))[0]
        x, y = self._elements.free_shapes(solved.s_m[k]).answers(kappa, self._elements.rows)
        cos, sin = np.cos(beam.tilt_rad[k]), np.sin(beam.tilt_rad[k])
        sideways = (cos * x - sin * y) * solved.nx[k] + (sin * x + cos * y) * solved.ny[k]
        result: FloatArray = self.project[k] @ sideways.T
        return result

    def change(self, base: BeamProblem, other: BeamProblem, contact: ContactSolution) -> FloatArray:
        """Return the step (K, Q) in `columns` from one `BeamProblem` to another, to first order."""
        G, K, R = self.count, self.K, self.sheet.arc_radius_m
        step = np.zeros((K, self.columns))
        step[:, :G] = (other.rest - base.rest) + (
            (other.eibm + other.bend) * other.soft - (base.eibm + base.bend) * base.soft
        )
        step[:, G : 2 * G] = other.soft - base.soft
        step[:, 2 * G] = other.elongation_soft - base.elongation_soft
        tilt, shift = other.tilt_rad - base.tilt_rad, other.shift_m - base.shift_m
        offset = other.offset_m - base.offset_m
        gamma = np.nan_to_num(contact.gamma_rad)
        step[:, 2 * G + 1] = shift / R - tilt - offset * np.cos(gamma) / R
        step[:, 2 * G + 2] = other.reach_m - base.reach_m + offset * np.sin(gamma)
        step[:, 2 * G + 3] = shift / R - tilt
        step[:, -2] = other.stiffness / base.stiffness - 1.0
        step[:, -1] = tilt
        return step

    def along_arc_m(self, step: FloatArray) -> FloatArray:
        """Return how far such a step moves the contacts along the arc, (K,)."""
        return np.asarray(self.sheet.arc_radius_m * step[:, 2 * self.count + 1])


def _nothing_held(K: int, G: int) -> ContactSolution:
    by_condition = ("force_N", "normal_N", "gamma_rad", "s_hat_m")
    along = ("lever", "offset", "x_m", "y_m", "phi_rad", "curvature")
    return ContactSolution(
        **{name: np.full(K, np.nan) for name in by_condition},
        **{name: np.zeros((K, G)) for name in along},
        end_phi_rad=np.zeros(K),
    )
