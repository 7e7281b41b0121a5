"""Sessions of a rig that nobody who fits the model has written: a shooting method and own forms.

The sheet is integrated from the clamp (Runge-Kutta, 40 steps); force and length at the contact are
found by Newton's method, all conditions at once. Nothing of `model` is used but its table of
measurements, nothing of `sim_hardware`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from model.measurements import Condition, Curve, FloatArray, Measurements, Reading, SheetGeometry

RADIUS_M, STEPS, EVERY = 0.040, 40, 2  # of these steps a curve has every third
WIRE_M = 2e-3  # length of sheet that the wire holds
POSITIONS_M = np.arange(7) * 5e-3
LENGTHS_M = {"long": 0.050, "short": 0.0045}
ELONGATION_M = {"long": 0.0, "short": 0.040}
STIFFNESS_NM2 = {"long": 1.25e-6, "short": 0.85e-6}
EIBM_PER_M = {"long": 29.0, "short": 78.0}
REST_PER_M = {"long": 15.0, "short": 28.0}
NEGATIVE = 0.8  # |EIBM| at -2 V over that at +2 V
READING_N, ZERO_N, POINT_M = 2e-5, 1e-5, 3e-5
PULSE_S, SAMPLE_S, FIRST, PULSES = 0.6, 0.5, 2, 22
WET_FOR_S = 60.0  # between the wetting of a sheet and the first pulse
RUN_S = WET_FOR_S + PULSES * 2 * PULSE_S

# angle of the sheet, voltage, place along the sheet -> factor, or moment over B in 1/m
AtPlace = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]


def _one(curvature: FloatArray, voltage_V: FloatArray, s_m: FloatArray) -> FloatArray:
    del voltage_V, s_m
    return np.ones_like(curvature)


@dataclass(frozen=True, kw_only=True)
class Foreign:
    """What is different from the base model; by default nothing."""

    stiffness: AtPlace = _one  # factor of B at a curvature above rest in 1/m, V and s in m
    eibm: AtPlace = _one
    wire_Nm_per_rad: float = 0.0  # a torsion spring between frame and sheet
    wire_at_m: float = 0.002
    # added to the force in N: (force in N, position in m, voltage in V, gamma in rad, name)
    force_N: Callable[[FloatArray, FloatArray, FloatArray, FloatArray, str], FloatArray] = field(
        default=lambda force, *_: np.zeros_like(force)
    )


@dataclass(frozen=True)
class _Sheet:
    """The sheet in K conditions of a configuration."""

    name: str
    foreign: Foreign
    stiffness: FloatArray  # (K,)
    eibm_per_m: FloatArray  # (K,) Me/B
    voltage_V: FloatArray
    position_m: FloatArray

    @property
    def target_m(self) -> FloatArray:
        """Of the contact, (2, K)."""
        beta = self.position_m / RADIUS_M
        return RADIUS_M * np.array([np.cos(beta), np.sin(beta)])

    def curve(self, force_N: FloatArray, end_m: FloatArray, turn: FloatArray) -> FloatArray:
        """Return x, y, phi from the clamp to `end_m` (K,), the last one there: (STEPS + 2, 3, K).

        `force_N` (2, K) acts on the sheet at the contact; `turn` (K,) is phi at the wire.
        """
        at = np.zeros((STEPS + 2, 3, len(end_m)))
        bent_m = np.minimum(end_m, LENGTHS_M[self.name])
        h = bent_m / STEPS
        for i in range(STEPS):
            y = at[i]
            k1 = self._slope(i * h, y, force_N, turn)
            k2 = self._slope((i + 0.5) * h, y + 0.5 * h * k1, force_N, turn)
            k3 = self._slope((i + 0.5) * h, y + 0.5 * h * k2, force_N, turn)
            k4 = self._slope((i + 1.0) * h, y + h * k3, force_N, turn)
            at[i + 1] = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        phi, straight_m = at[-2, 2], end_m - bent_m
        at[-1] = at[-2] + np.array([straight_m * np.cos(phi), straight_m * np.sin(phi), 0.0 * phi])
        return at

    def _slope(
        self, s_m: FloatArray, y: FloatArray, force_N: FloatArray, turn: FloatArray
    ) -> FloatArray:
        x_m, y_m, phi = y
        lever = self.target_m - np.array([x_m, y_m])
        moment = lever[0] * force_N[1] - lever[1] * force_N[0]
        held = np.clip((self.foreign.wire_at_m - s_m) / WIRE_M + 0.5, 0.0, 1.0)
        moment = moment - self.foreign.wire_Nm_per_rad * turn * held
        bent = REST_PER_M[self.name] + self._bent(s_m, moment / self.stiffness)
        return np.array([np.cos(phi), np.sin(phi), bent])

    def _bent(self, s_m: FloatArray, loaded: FloatArray) -> FloatArray:
        """Curvature above rest, 1/m, by iteration where the forms ask for it."""
        bent = loaded + self.eibm_per_m
        if self.foreign.stiffness is _one and self.foreign.eibm is _one:
            return bent
        for _ in range(5):
            soft = self.foreign.stiffness(bent, self.voltage_V, s_m)
            own = self.foreign.eibm(bent, self.voltage_V, s_m) * self.eibm_per_m
            bent = 0.3 * bent + 0.7 * (loaded + own) / soft
        return bent


def _force_N(sheet: _Sheet, z: FloatArray) -> FloatArray:
    """On the sheet at the contact, along its normal there, by x and y: (2, K)."""
    return z[0] * sheet.stiffness / RADIUS_M**2 * np.array([np.sin(z[2]), -np.cos(z[2])])


def _residual(sheet: _Sheet, z: FloatArray) -> FloatArray:
    """z: force over B/R^2, length over R, angle at the contact and at the wire in rad: (4, K)."""
    end_m = z[1] * RADIUS_M
    at = sheet.curve(_force_N(sheet, z), end_m, z[3])
    gap = (at[-1, :2] - sheet.target_m) / RADIUS_M
    place = sheet.foreign.wire_at_m / np.minimum(end_m, LENGTHS_M[sheet.name]) * STEPS
    low, k = place.astype(int), np.arange(len(end_m))
    turned = at[low, 2, k] + (place - low) * (at[low + 1, 2, k] - at[low, 2, k])
    return np.array([*gap, at[-1, 2] - z[2], turned - z[3]])


def _newton(sheet: _Sheet, z: FloatArray) -> FloatArray:
    """With numerical derivatives, all conditions at once."""
    for _ in range(20):
        r = _residual(sheet, z)
        J = np.zeros((z.shape[1], 4, 4))
        for j, step in enumerate(1e-6 * np.eye(4)):
            J[:, :, j] = ((_residual(sheet, z + step[:, None]) - r) / 1e-6).T
        move = np.linalg.solve(J, -r.T[:, :, None])[:, :, 0].T
        z = z + np.clip(move, -0.5, 0.5)
        if np.max(np.abs(move)) < 1e-8:
            return z
    raise ValueError("a condition has no solution")


def _solved(sheet: _Sheet) -> FloatArray:
    """From where the free sheet crosses the arc, in steps to where the contact is."""
    K = len(sheet.position_m)
    far, none = np.full(K, 1.3 * RADIUS_M), np.zeros((2, K))
    turn = np.zeros(K)
    for _ in range(30):  # the wire turns the free sheet, too
        free = sheet.curve(none, np.minimum(far, LENGTHS_M[sheet.name]), turn)
        place = sheet.foreign.wire_at_m / LENGTHS_M[sheet.name] * STEPS
        turn = 0.5 * turn + 0.5 * np.array(
            [np.interp(place, np.arange(STEPS + 2), f) for f in free[:, 2].T]
        )
    length = np.empty(K)
    low, high = np.full(K, 0.5 * RADIUS_M), np.full(K, 1.6 * RADIUS_M)
    for _ in range(40):
        length = 0.5 * (low + high)
        ends = sheet.curve(none, length, turn)[-1]
        inside = np.hypot(ends[0], ends[1]) < RADIUS_M
        low, high = np.where(inside, length, low), np.where(inside, high, length)
    z = np.array([np.zeros(K), length / RADIUS_M, ends[2], turn])
    begin_m = RADIUS_M * np.arctan2(ends[1], ends[0])
    for share in np.linspace(0.0, 1.0, 7)[1:]:
        there = begin_m + share * (sheet.position_m - begin_m)
        z = _newton(replace(sheet, position_m=there), z)
    return z


def foreign_session(
    foreign: Foreign, seed: int, lengths: tuple[str, ...] = ("long", "short")
) -> Measurements:
    """Measure seven positions of each configuration at 0 V and twenty pulses of +-2 V."""
    random = np.random.default_rng(seed)
    sheets = {name: _geometry(name) for name in lengths}
    conditions, clock_s = list[Condition](), 0.0
    for name in lengths:
        B = STIFFNESS_NM2[name] * np.exp(0.05 * random.standard_normal())
        me = EIBM_PER_M[name] * np.exp(0.05 * random.standard_normal())
        n = len(POSITIONS_M)
        b, e = 1.0 + 0.008 * random.standard_normal((2, n))
        at_m = POSITIONS_M + 4e-5 * random.standard_normal(n)
        volts = np.tile([0.0, 2.0, -2.0], n)
        per_m = me * np.select([volts > 0.0, volts < 0.0], [1.0, -NEGATIVE], 0.0)
        own = _Sheet(
            name, foreign, B * np.repeat(b, 3), per_m * np.repeat(e, 3), volts, np.repeat(at_m, 3)
        )
        conditions += _measured(own, clock_s, random)
        clock_s += n * RUN_S
    return Measurements(sheets=sheets, conditions=tuple(conditions), source="foreign.csv")


def _measured(sheet: _Sheet, begun_s: float, random: np.random.Generator) -> list[Condition]:
    z = _solved(sheet)
    force = _force_N(sheet, z)
    at = sheet.curve(force, z[1] * RADIUS_M, z[3])
    beta = sheet.position_m / RADIUS_M
    F = force[0] * np.sin(beta) - force[1] * np.cos(beta)
    F = F + sheet.foreign.force_N(
        F, sheet.position_m, sheet.voltage_V, at[-1, 2] - beta, sheet.name
    )
    F = F + ZERO_N * np.repeat(random.standard_normal(len(POSITIONS_M)), 3)
    bent_m = np.minimum(z[1] * RADIUS_M, LENGTHS_M[sheet.name])
    result = []
    for k, voltage_V in enumerate(sheet.voltage_V.tolist()):
        s, xy = np.linspace(0.0, bent_m[k], STEPS + 1)[::EVERY], at[:-1:EVERY, :, k]
        off = POINT_M * random.standard_normal(len(s))
        normal = np.array([-np.sin(xy[:, 2]), np.cos(xy[:, 2])])
        curve = Curve(
            s_m=s, x_m=xy[:, 0] + off * normal[0], y_m=xy[:, 1] + off * normal[1],
            sigma_m=np.full(len(s), POINT_M),
        )  # fmt: skip
        readings = _readings(voltage_V, F[k], begun_s + k // 3 * RUN_S, random)
        result.append(
            Condition(
                configuration=sheet.name, position_m=float(POSITIONS_M[k // 3]),
                voltage_V=voltage_V, readings=tuple(readings), curve=curve,
            )
        )  # fmt: skip
    return result


def _readings(
    voltage_V: float, force_N: float, begun_s: float, random: np.random.Generator
) -> list[Reading]:
    """Ten at 0 V before the pulses; under voltage one a pulse, the first two discarded."""
    if voltage_V == 0.0:
        times, kinds = 0.3 * np.arange(10), ["zero"] * 10
    else:
        turn = 0 if voltage_V > 0.0 else 1
        times = 5.0 + SAMPLE_S + PULSE_S * (2 * np.arange(PULSES // 2) + turn)
        kinds = ["discarded"] * (FIRST // 2) + ["kept"] * (PULSES // 2 - FIRST // 2)
    values = force_N + READING_N * random.standard_normal(len(times))
    return [
        Reading(
            index=i, kind=kind, force_N=float(value), time_s=float(t),
            session_s=begun_s + WET_FOR_S + float(t), wetted_s=WET_FOR_S + float(t),
        )
        for i, (t, kind, value) in enumerate(zip(times, kinds, values, strict=True))
    ]  # fmt: skip


def _geometry(name: str) -> SheetGeometry:
    length = LENGTHS_M[name]
    return SheetGeometry(
        configuration=name, free_length_m=length, width_m=0.01, thickness_m=2e-4,
        elongation_m=ELONGATION_M[name], arc_radius_m=RADIUS_M, arc_origin_rad=0.0,
        initial_curvature=(np.array([0.0, length]), np.full(2, REST_PER_M[name])),
        rise_time_s=0.03,
    )  # fmt: skip
