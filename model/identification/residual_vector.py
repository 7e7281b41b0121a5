"""One configuration as a least-squares problem: parameters in, predicted data and derivatives out.

Parameters of a configuration: ln B; for each driving voltage the coefficients of m(s) = Me(s)/B in
Legendre polynomials along the sheet; and the coefficients of a change of the rest curvature k0(s).
Data of a condition: the force, and the distance between measured and predicted curve along the
normal, as coefficients of Legendre polynomials ("modes") along the measured curve: hundreds of
points whose errors are correlated would otherwise outweigh the forces.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import legendre

from model.identification.observations import Observation, Observed
from model.measurements import FloatArray, ModelError
from model.mechanics.equilibrium import Directions, Equilibria, Problems, SolverStatus, finer, solve
from model.mechanics.field import Field, merged_breaks, padded
from model.mechanics.free_shape import free_shape

STEEPEST_PER_M = 90.0  # free curvature that panels are made for


@dataclass(frozen=True)
class ParameterLayout:
    """Where a configuration's parameters stand in its vector."""

    voltages_V: tuple[float, ...]  # driving voltages, ascending
    eibm: int  # coefficients of m(s) for each
    rest: int  # coefficients of the change of k0
    symmetric: bool  # +V and -V share their coefficients, with opposite sign

    @property
    def groups(self) -> list[float]:
        """Voltages with coefficients of their own."""
        own = {abs(v) for v in self.voltages_V} if self.symmetric else set(self.voltages_V)
        return sorted(own)

    @property
    def size(self) -> int:
        """Number of parameters."""
        return 1 + self.eibm * len(self.groups) + self.rest

    def of(self, voltage_V: float) -> tuple[slice, float]:
        """A voltage's coefficients, and the sign they count with."""
        key = abs(voltage_V) if self.symmetric else voltage_V
        start = 1 + self.eibm * self.groups.index(key)
        sign = -1.0 if self.symmetric and voltage_V < 0.0 else 1.0
        return slice(start, start + self.eibm), sign

    @property
    def rest_slice(self) -> slice:
        """The change of k0."""
        return slice(self.size - self.rest, self.size)


@dataclass
class Shift:
    """How the set-up of each condition differs from the nominal one, arrays (K,)."""

    stiffness: FloatArray  # relative, of B
    eibm: FloatArray  # relative, of Me
    position_m: FloatArray
    tilt_rad: FloatArray  # of the clamp
    x_m: FloatArray  # registration of the camera
    y_m: FloatArray
    force_N: FloatArray  # zero of the load cell

    @staticmethod
    def none(count: int) -> Shift:
        """Nominal set-ups."""
        return Shift(*(np.zeros(count) for _ in range(7)))

    def bending(self) -> FloatArray:
        """Factor on Me/B."""
        return (1.0 + self.eibm) / (1.0 + self.stiffness)


@dataclass
class Predicted:
    """What a parameter vector says, for all conditions of a configuration."""

    force_N: FloatArray  # (K,) NaN for a free shape
    modes_m: FloatArray  # (K, M) of the distance measured - predicted; NaN: no curve
    force_by: FloatArray  # (K, size) derivatives
    modes_by: FloatArray  # (K, M, size) of the predicted distance
    # by relative stiffness, relative EIBM, position, clamp tilt, load cell's zero
    force_at: FloatArray  # (K, 5)
    # by relative stiffness, relative EIBM, position, clamp tilt, camera x, camera y
    modes_at: FloatArray  # (K, M, 6)


class System:
    """Predicts the data of one configuration."""

    def __init__(
        self, observed: Observed, rest: Field, layout: ParameterLayout, modes: int
    ) -> None:
        self.observed, self.layout, self.modes, self.rest = observed, layout, modes, rest
        sheet = observed.sheet
        self.length = sheet.free_length_m
        self.breaks = finer(merged_breaks([rest.breaks_m]), STEEPEST_PER_M, sheet.arc_radius_m)
        count = max(layout.eibm, layout.rest, 1)
        degree = max(count, rest.coefficients.shape[1])
        self.basis = [legendre_field(i, self.length).on(self.breaks) for i in range(count)]
        self.rows = np.stack([padded(f.coefficients, degree) for f in self.basis])
        self.rest_row = padded(rest.on(self.breaks).coefficients, degree)
        self.touching = [i for i, o in enumerate(observed.observations) if o.position_m is not None]
        self.free = [i for i, o in enumerate(observed.observations) if o.position_m is None]
        self._angles = np.array([self._angle(i) for i in self.touching])
        self._projections: dict[bytes, FloatArray] = {}
        self._points = [self._curve(o) for o in observed.observations]
        self._directions = {i: self._change(o) for i, o in enumerate(observed.observations)}
        self._last: Equilibria | None = None
        self._stack_curves()
        self._moved = self._all_directions()

    def _stack_curves(self) -> None:
        """The curves of all touching conditions as arrays, filled up where one is shorter."""
        longest = max(1, *(len(s) for s, *_ in self._points))
        shape = (len(self.touching), longest)
        self._s, self._x, self._y = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        self._project = np.zeros((shape[0], self.modes, longest))
        for row, i in enumerate(self.touching):
            s, x, y, project = self._points[i]
            self._s[row, len(s) :] = s[-1] if len(s) else 0.0
            for whole, part in ((self._s, s), (self._x, x), (self._y, y)):
                whole[row, : len(part)] = part
            self._project[row, :, : len(s)] = project

    def curvature_row(self, theta: FloatArray, voltage_V: float) -> FloatArray:
        """k* as panel coefficients (P, D)."""
        row = self.rest_row.copy()
        for coefficient, basis in zip(theta[self.layout.rest_slice], self.rows, strict=False):
            row += coefficient * basis
        if voltage_V != 0.0:
            where, sign = self.layout.of(voltage_V)
            for coefficient, basis in zip(theta[where], self.rows, strict=False):
                row += sign * coefficient * basis
        return row

    def predict(self, theta: FloatArray, shift: Shift | None = None) -> Predicted:
        """Predictions and derivatives; an error where a condition has no answer."""
        K, M, size = len(self.observed.observations), self.modes, self.layout.size
        shift = shift or Shift.none(K)
        result = Predicted(
            np.full(K, np.nan), np.full((K, M), np.nan), np.zeros((K, size)),
            np.zeros((K, M, size)), np.zeros((K, 5)), np.zeros((K, M, 6)),
        )  # fmt: skip
        if self.touching:
            self._predict_touching(theta, shift, result)
        for i in self.free:
            self._predict_free(theta, shift, i, result)
        return result

    def solve(self, theta: FloatArray, shift: Shift | None = None) -> Equilibria:
        """The equilibria of all conditions with the load cell."""
        sheet, moved = self.observed.sheet, self._moved.kappa[:, :-1]
        shift = shift or Shift.none(len(self.observed.observations))
        own = theta[1:] * self._scales(shift)
        kappa = self.rest_row + (own[:, None] @ moved.reshape(*moved.shape[:2], -1)).reshape(
            len(moved), *self.rest_row.shape
        )
        none = np.zeros((1, len(self.breaks) - 1, 0))
        reach = self.length + sheet.elongation_m
        rows = np.array(self.touching)
        angles = self._angles + shift.position_m[rows] / sheet.arc_radius_m - shift.tilt_rad[rows]
        batch = Problems(
            breaks_m=self.breaks,
            kappa=kappa,
            softness=none,
            radius_m=sheet.arc_radius_m,
            reach_m=reach,
            angle_rad=angles,
        )
        found = solve(batch, self._last)
        if np.any(
            found.status != SolverStatus.SOLVED
        ):  # on the way a sheet may seem a little short
            found = solve(replace(batch, reach_m=reach + 10.0 * sheet.arc_radius_m), self._last)
        self._last = found
        return found

    def _predict_touching(self, theta: FloatArray, shift: Shift, result: Predicted) -> None:
        R, size, rows = self.observed.sheet.arc_radius_m, self.layout.size, np.array(self.touching)
        found = self.solve(theta, shift)
        if np.any(found.status != SolverStatus.SOLVED):
            bad = self.observed.observations[self.touching[int(np.argmax(found.status != 0))]]
            raise ModelError(f"condition {bad.name}: no equilibrium with these parameters")
        shapes, answers = found.answers(self._s, self._moved)
        weights = self._eibm_weights(theta) * self._scales(shift)
        stiff, active = 1.0 + shift.stiffness[rows], 1.0 + shift.eibm[rows]
        B = float(np.exp(theta[0])) * stiff
        force = found.force(B)
        turn = B * found.nu * np.sin(found.gamma_rad)
        by = (B * np.cos(found.gamma_rad))[:, None] * answers.nu - turn[:, None] * answers.phi_hat
        by[:, -1] += turn  # gamma = phi_hat - beta, and beta moves
        result.force_N[rows] = force + shift.force_N[rows]
        # a set-up's share multiplies parameters: derivatives by these are those of the mean set-up,
        # or set-ups in which the EIBM happens to be large would count for more
        result.force_by[rows, 0] = force / stiff
        result.force_by[rows, 1:] = by[:, : size - 1]
        eibm = np.sum(weights * by[:, : size - 1], axis=1)  # by ln(Me/B)
        at = [(force - eibm) / stiff, eibm / active, by[:, -1] / R, -by[:, -1], np.ones(len(rows))]
        result.force_at[rows] = np.stack(at, axis=1)
        x, y, turned = self._in_clamp_frame(shift, rows)
        nx, ny = -np.sin(shapes.phi_rad), np.cos(shapes.phi_rad)
        distance = (x - shapes.x_m) * nx + (y - shapes.y_m) * ny
        sideways = answers.x * nx[:, None] + answers.y * ny[:, None]
        tilt = shapes.x_m * ny - shapes.y_m * nx - sideways[:, -1]
        wx, wy = turned[0] * nx - turned[1] * ny, turned[1] * nx + turned[0] * ny
        columns = np.concatenate([sideways, np.stack([tilt, wx, wy, distance], axis=1)], axis=1)
        modes = self._project @ columns.transpose(0, 2, 1)  # (K, M, size + 4)
        seen = np.array([len(self._points[i][0]) > 0 for i in self.touching])
        result.modes_m[rows] = np.where(seen[:, None], modes[:, :, -1], np.nan)
        result.modes_by[rows, :, 1:] = modes[:, :, : size - 1]
        eibm = np.sum(weights[:, None] * modes[:, :, : size - 1], axis=2)
        result.modes_at[rows, :, 0] = -eibm / stiff[:, None]
        result.modes_at[rows, :, 1] = eibm / active[:, None]
        result.modes_at[rows, :, 2] = modes[:, :, size - 1] / R
        result.modes_at[rows, :, 3:] = modes[:, :, size : size + 3]

    def _in_clamp_frame(
        self, shift: Shift, rows: FloatArray
    ) -> tuple[FloatArray, FloatArray, tuple[FloatArray, FloatArray]]:
        """Measured points as seen from the clamp of their set-up; cos and sin of its tilt."""
        cos, sin = (f(shift.tilt_rad[rows])[:, None] for f in (np.cos, np.sin))
        x, y = self._x - shift.x_m[rows, None], self._y - shift.y_m[rows, None]
        return cos * x + sin * y, cos * y - sin * x, (cos, sin)

    def _scales(self, shift: Shift) -> FloatArray:
        """Factors (touching, size - 1) of the parameters after ln B in each set-up."""
        scales = np.ones((len(self.touching), self.layout.size - 1))
        stop = self.layout.rest_slice.start - 1
        scales[:, :stop] = shift.bending()[np.array(self.touching)][:, None]
        return scales

    def _eibm_weights(self, theta: FloatArray) -> FloatArray:
        """Of the parameters after ln B in a relative change of each condition's EIBM."""
        weights = np.zeros((len(self.touching), self.layout.size - 1))
        for row, i in enumerate(self.touching):
            voltage = self.observed.observations[i].voltage_V
            if voltage != 0.0:
                where, _ = self.layout.of(voltage)
                weights[row, where.start - 1 : where.stop - 1] = theta[where]
        return weights

    def _predict_free(self, theta: FloatArray, shift: Shift, i: int, result: Predicted) -> None:
        observation, tilt = self.observed.observations[i], shift.tilt_rad[i]
        s, x, y, project = self._points[i]
        bend = float(shift.bending()[i])
        own = theta.copy()
        own[1 : self.layout.rest_slice.start] *= bend
        kappa = Field(self.breaks, self.curvature_row(own, observation.voltage_V))
        fields = [Field(self.breaks, row) for row in self._directions[i]]
        px, py, phi, answers = free_shape(kappa, s, fields)
        cos, sin = np.cos(tilt), np.sin(tilt)
        dx, dy = x - shift.x_m[i], y - shift.y_m[i]
        nx, ny = -np.sin(phi), np.cos(phi)
        off = (cos * dx + sin * dy - px) * nx + (cos * dy - sin * dx - py) * ny
        result.modes_m[i] = project @ off
        modes = project @ (answers[:, :, 0] * nx + answers[:, :, 1] * ny).T
        eibm = self._eibm_derivative(own, i, modes.T)
        result.modes_by[i, :, 1:] = modes
        result.modes_at[i, :, 0] = -eibm / (1.0 + shift.stiffness[i])
        result.modes_at[i, :, 1] = eibm / (1.0 + shift.eibm[i])
        others = np.stack([px * ny - py * nx, cos * nx - sin * ny, sin * nx + cos * ny], axis=1)
        result.modes_at[i, :, 3:] = project @ others

    def _eibm_derivative(self, theta: FloatArray, i: int, by: FloatArray) -> FloatArray:
        """By a relative change of the EIBM; `by` leads with the parameters after ln B."""
        voltage = self.observed.observations[i].voltage_V
        if voltage == 0.0:
            return np.zeros(by.shape[1:])
        where, _ = self.layout.of(voltage)
        return np.tensordot(theta[where], by[where.start - 1 : where.stop - 1], axes=(0, 0))

    def _angle(self, i: int) -> float:
        sheet, position = self.observed.sheet, self.observed.observations[i].position_m
        return sheet.arc_origin_rad + (position or 0.0) / sheet.arc_radius_m

    def _curve(self, o: Observation) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """s, x, y of the points that count, and the matrix from distances to modes."""
        if o.curve is None:
            return np.zeros(0), np.zeros(0), np.zeros(0), np.zeros((self.modes, 0))
        end = self.length + self.observed.sheet.elongation_m
        use = o.curve.s_m <= end * 1.001
        s = np.minimum(o.curve.s_m[use], end)
        key = s.tobytes()
        if key not in self._projections:
            t = 2.0 * s / s[-1] - 1.0
            count = min(self.modes, len(s))
            V = legendre.legvander(t, count - 1) * np.sqrt(2.0 * np.arange(count) + 1.0)
            self._projections[key] = np.zeros((self.modes, len(s)))
            self._projections[key][:count] = np.linalg.pinv(V)
        return s, o.curve.x_m[use], o.curve.y_m[use], self._projections[key]

    def _change(self, o: Observation) -> FloatArray:
        """What the parameters after ln B do to k* of a condition: (size - 1, P, D)."""
        rows = np.zeros((self.layout.size - 1, *self.rest_row.shape))
        if o.voltage_V != 0.0:
            where, sign = self.layout.of(o.voltage_V)
            rows[where.start - 1 : where.stop - 1] = sign * self.rows[: self.layout.eibm]
        rest = self.layout.rest_slice
        rows[rest.start - 1 : rest.stop - 1] = self.rows[: self.layout.rest]
        return rows

    def _all_directions(self) -> Directions:
        """Directions of all touching conditions: the parameters after ln B, then the position."""
        if not self.touching:
            return Directions.of(np.zeros((1, 0, *self.rest_row.shape)))
        rows = np.stack([self._directions[i] for i in self.touching])
        kappa = np.concatenate([rows, np.zeros_like(rows[:, :1])], axis=1)
        angle = np.zeros(kappa.shape[:2])
        angle[:, -1] = 1.0
        return Directions.of(kappa, angle=angle)


def legendre_field(degree: int, length_m: float) -> Field:
    """A Legendre polynomial over the sheet; its mean is 0 but for degree 0."""
    powers = legendre.leg2poly(np.eye(degree + 1)[degree])
    return Field(np.array([0.0, length_m]), np.asarray(powers, dtype=float)[None, :])
