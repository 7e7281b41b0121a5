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

from model.beam import Directions, Equilibria, Problems, Status, finer, solve
from model.field import Field, merged_breaks, padded
from model.free import free_shape
from model.measurements import FloatArray, ModelError
from model.observations import Observation, Observed

STEEPEST_PER_M = 90.0  # free curvature that panels are made for


@dataclass(frozen=True)
class Layout:
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
class Prediction:
    """What a parameter vector says, for all conditions of a configuration."""

    force_N: FloatArray  # (K,) NaN for a free shape
    modes_m: FloatArray  # (K, M) of the distance measured - predicted; NaN: no curve
    force_by: FloatArray  # (K, size) derivatives
    modes_by: FloatArray  # (K, M, size) of the predicted distance
    force_at: FloatArray  # (K, 4) by: relative EIBM, position, clamp tilt, load cell zero
    modes_at: FloatArray  # (K, M, 5) by: relative EIBM, position, clamp tilt, camera x, camera y


class System:
    """Predicts the data of one configuration."""

    def __init__(self, observed: Observed, rest: Field, layout: Layout, modes: int) -> None:
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

    def predict(self, theta: FloatArray) -> Prediction:
        """Predictions and derivatives at a parameter vector; an error where one has no answer."""
        K, M, size = len(self.observed.observations), self.modes, self.layout.size
        result = Prediction(
            np.full(K, np.nan), np.full((K, M), np.nan), np.zeros((K, size)),
            np.zeros((K, M, size)), np.zeros((K, 4)), np.zeros((K, M, 5)),
        )  # fmt: skip
        if self.touching:
            self._predict_touching(theta, result)
        for i in self.free:
            self._predict_free(theta, i, result)
        return result

    def solve(self, theta: FloatArray) -> Equilibria:
        """The equilibria of all conditions with the load cell."""
        sheet, moved = self.observed.sheet, self._moved.kappa[:, :-1]
        kappa = self.rest_row + np.tensordot(moved, theta[1:], axes=(1, 0))
        none = np.zeros((1, len(self.breaks) - 1, 0))
        reach = self.length + sheet.elongation_m
        batch = Problems(self.breaks, kappa, none, sheet.arc_radius_m, reach, self._angles)
        found = solve(batch, self._last)
        if np.any(found.status != Status.SOLVED):  # on the way a sheet may seem a little short
            found = solve(replace(batch, reach_m=reach + 10.0 * sheet.arc_radius_m), self._last)
        self._last = found
        return found

    def _predict_touching(self, theta: FloatArray, result: Prediction) -> None:
        B, R, size = float(np.exp(theta[0])), self.observed.sheet.arc_radius_m, self.layout.size
        found = self.solve(theta)
        if np.any(found.status != Status.SOLVED):
            bad = self.observed.observations[self.touching[int(np.argmax(found.status != 0))]]
            raise ModelError(f"condition {bad.name}: no equilibrium with these parameters")
        shapes, answers = found.answers(self._s, self._moved)
        weights, rows = self._eibm_weights(theta), np.array(self.touching)
        force = found.force(B)
        turn = B * found.nu * np.sin(found.gamma_rad)
        by = B * np.cos(found.gamma_rad)[:, None] * answers.nu - turn[:, None] * answers.phi_hat
        by[:, -1] += turn  # gamma = phi_hat - beta, and beta moves
        result.force_N[rows] = force
        result.force_by[rows, 0], result.force_by[rows, 1:] = force, by[:, : size - 1]
        eibm = np.sum(weights * by[:, : size - 1], axis=1)
        ones = np.ones(len(rows))
        result.force_at[rows] = np.stack([eibm, by[:, -1] / R, -by[:, -1], ones], axis=1)
        nx, ny = -np.sin(shapes.phi_rad), np.cos(shapes.phi_rad)
        distance = (self._x - shapes.x_m) * nx + (self._y - shapes.y_m) * ny
        sideways = answers.x * nx[:, None] + answers.y * ny[:, None]
        tilt = shapes.x_m * ny - shapes.y_m * nx - sideways[:, -1]
        columns = np.concatenate([sideways, np.stack([tilt, nx, ny, distance], axis=1)], axis=1)
        modes = self._project @ columns.transpose(0, 2, 1)  # (K, M, size + 4)
        seen = np.array([len(self._points[i][0]) > 0 for i in self.touching])
        result.modes_m[rows] = np.where(seen[:, None], modes[:, :, -1], np.nan)
        result.modes_by[rows, :, 1:] = modes[:, :, : size - 1]
        result.modes_at[rows, :, 0] = np.sum(weights[:, None] * modes[:, :, : size - 1], axis=2)
        result.modes_at[rows, :, 1] = modes[:, :, size - 1] / R
        result.modes_at[rows, :, 2:] = modes[:, :, size : size + 3]

    def _eibm_weights(self, theta: FloatArray) -> FloatArray:
        """Of the parameters after ln B in a relative change of each condition's EIBM."""
        weights = np.zeros((len(self.touching), self.layout.size - 1))
        for row, i in enumerate(self.touching):
            voltage = self.observed.observations[i].voltage_V
            if voltage != 0.0:
                where, _ = self.layout.of(voltage)
                weights[row, where.start - 1 : where.stop - 1] = theta[where]
        return weights

    def _predict_free(self, theta: FloatArray, i: int, result: Prediction) -> None:
        observation = self.observed.observations[i]
        s, x, y, project = self._points[i]
        kappa = Field(self.breaks, self.curvature_row(theta, observation.voltage_V))
        fields = [Field(self.breaks, row) for row in self._directions[i]]
        px, py, phi, answers = free_shape(kappa, s, fields)
        along_x, along_y = -np.sin(phi), np.cos(phi)
        result.modes_m[i] = project @ ((x - px) * along_x + (y - py) * along_y)
        sideways = answers[:, :, 0] * along_x + answers[:, :, 1] * along_y
        modes = project @ sideways.T
        result.modes_by[i, :, 1:] = modes
        result.modes_at[i, :, 0] = self._eibm_derivative(theta, i, modes.T)
        tilt = px * along_y - py * along_x
        result.modes_at[i, :, 2:] = project @ np.stack([tilt, along_x, along_y], axis=1)

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
