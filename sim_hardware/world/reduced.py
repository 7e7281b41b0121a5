"""A session without pixels and volts: what an experiment would have measured, in milliseconds.

For questions that take hundreds of sessions, such as whether stated intervals cover the truth. The
sheet, its scatter and the load cell are those of the world, settled at each voltage. Nothing dries,
rubs or sticks.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sim_hardware.world.chain.chain import Equilibrium
from sim_hardware.world.chain.contact import ContactState
from sim_hardware.world.curve_noise import CurveErrors
from sim_hardware.world.settings import WorldSettings
from sim_hardware.world.setup import MountedSheet, Scatter
from sim_hardware.world.signals.load_cell import SimulatedLoadCell

FloatArray = npt.NDArray[np.float64]

POSITIONS_M = (0.0, 0.005, 0.01, 0.015, 0.02, 0.025, 0.03)
VOLTAGES = (0.0, 2.0, -2.0)
_CURVE_STREAM = 0xCE120
# The paper's pulse train; a run with the move that follows it takes about a minute.
_PULSE_S, _SAMPLE_S, _DISCARDED, _RUN_S = 0.6, 0.5, 2, 60.0


@dataclass(frozen=True, kw_only=True)
class ReducedCondition:
    """One configuration, position and voltage; `true_` values cannot be measured at the rig."""

    configuration: str
    position_m: float | None  # None: the free shape
    voltage_V: float
    forces_N: FloatArray  # (readings,); none for a free shape
    s_m: FloatArray  # (points,) of the curve, from the clamp to the visible end
    x_m: FloatArray
    y_m: FloatArray
    curve_sigma_m: float
    true_force_N: float
    true_B_Nm2: float  # in this set-up
    true_mean_eibm_Nm: float  # mean over the arc length up to the contact, in this set-up
    true_l_hat_m: float  # that arc length


@dataclass(frozen=True)
class ReducedSession:
    """The conditions, and what the fits of it should find: the world's values without scatter."""

    conditions: tuple[ReducedCondition, ...]
    B_Nm2: dict[str, float]
    # mean EIBM over the arc length up to the contact, averaged over the positions
    mean_eibm_Nm: dict[tuple[str, float], float]


def reduced_session(
    settings: WorldSettings,
    seed: int | None = None,
    configurations: Sequence[str] = ("long", "short"),
    positions_m: Sequence[float | None] = POSITIONS_M,
    voltages: Sequence[float] = VOLTAGES,
    readings: int = 10,
    curve_errors: CurveErrors | None = None,
) -> ReducedSession:
    """Measure every configuration at every position and voltage.

    `seed` replaces the world's. A position that cannot be held is left out.
    """
    if seed is not None:
        settings = settings.model_copy(update={"seed": seed})
    maker = _TableMaker(settings, tuple(voltages), readings, curve_errors or CurveErrors())
    setups = [(name, position) for name in configurations for position in positions_m]
    conditions = [
        condition
        for number, (name, position) in enumerate(setups)
        for condition in maker.conditions(number, name, position)
    ]
    return ReducedSession(
        tuple(conditions),
        {name: settings.configurations[name].stiffness_Nm2 for name in configurations},
        _nominal_eibm(settings, conditions),
    )


def _nominal_eibm(
    settings: WorldSettings, conditions: Iterable[ReducedCondition]
) -> dict[tuple[str, float], float]:
    """Of a set-up without scatter, averaged over the positions at which there was a contact."""
    found: dict[tuple[str, float], list[float]] = {}
    for c in conditions:
        if c.voltage_V != 0 and c.position_m is not None:
            B = settings.configurations[c.configuration].stiffness_Nm2
            mean = B * _mean_drive_per_m(settings, c.configuration, c.true_l_hat_m)
            mean *= _settled(settings, c.voltage_V)
            found.setdefault((c.configuration, c.voltage_V), []).append(mean)
    return {key: float(np.mean(values)) for key, values in found.items()}


def _settled(settings: WorldSettings, voltage_V: float) -> float:
    """Moment at a voltage asked of the amplifier, relative to that at +2 V."""
    amplifier = settings.amplifier
    return settings.eibm.settled(voltage_V + amplifier.gain * amplifier.offset_mV * 1e-3)


def _mean_drive_per_m(settings: WorldSettings, configuration: str, length_m: float) -> float:
    """Mean of Me/B over [0, length], at +2 V."""
    points = 2000
    s_m = (np.arange(points) + 0.5) / points * length_m
    return float(np.mean(settings.eibm_per_m(configuration, s_m)))


class _TableMaker:
    """Makes the conditions of one set-up after the other."""

    def __init__(
        self,
        settings: WorldSettings,
        voltages: tuple[float, ...],
        readings: int,
        errors: CurveErrors,
    ) -> None:
        self._settings = settings
        self._voltages = voltages
        self._readings = readings
        self._errors = errors
        self._cell = SimulatedLoadCell(settings.load_cell, settings.seed)
        self._factors: dict[int, FloatArray] = {}

    def conditions(
        self, number: int, configuration: str, position_m: float | None
    ) -> list[ReducedCondition]:
        """Of one set-up; those in which the sheet slips out are left out."""
        scatter = Scatter.draw(self._settings, number)
        setup = MountedSheet(
            settings=self._settings,
            configuration=configuration,
            position_m=position_m,
            scatter=scatter,
        )
        times = self._times(number)
        result = []
        for k, voltage in enumerate(self._voltages):
            drive = setup.drive_share * _settled(self._settings, voltage)
            state = _state(setup, drive)
            if state is not None:
                random = np.random.default_rng((self._settings.seed, _CURVE_STREAM, number, k))
                result.append(self._condition(setup, state, voltage, times[voltage], random))
        return result

    def _times(self, number: int) -> dict[float, FloatArray]:
        """Return the times of the readings at each voltage: those at 0 V first, then in turns."""
        driven = [v for v in self._voltages if v != 0]
        start = number * _RUN_S + _SAMPLE_S
        turns = np.arange(self._readings, dtype=np.float64)
        pulses = self._readings * (len(driven) < len(self._voltages)) + _DISCARDED
        times = {
            v: start + _PULSE_S * (pulses + turns * len(driven) + k) for k, v in enumerate(driven)
        }
        times[0.0] = start + _PULSE_S * turns
        return times

    def _condition(
        self,
        setup: MountedSheet,
        state: Equilibrium,
        voltage_V: float,
        times: FloatArray,
        random: np.random.Generator,
    ) -> ReducedCondition:
        sheet = setup.chain.sheet
        B = setup.stiffness_Nm2
        forces = np.array([[state.along_per_m2], [state.outward_per_m2]])
        force_N = B * float(setup.along_axis(forces)[0])
        if state.touched:
            share = self._settings.configurations[setup.configuration].meniscus_share
            force_N += self._settings.rolls.meniscus_mN * 1e-3 * share
        l_hat_m = min(sheet.free_length_m, state.s_m if state.touched else math.inf)
        mean_eibm = (
            B * state.drive * _mean_drive_per_m(self._settings, setup.configuration, l_hat_m)
        )
        s_m, x_m, y_m = self._curve(setup, state, random)
        readings_N = np.empty(0)
        if setup.position_m is not None:
            readings_N = self._cell.filtered_N(force_N, times, random)
            readings_N += self._cell.stray_N(setup.position_m, np.array(voltage_V))
        return ReducedCondition(
            configuration=setup.configuration,
            position_m=setup.position_m,
            voltage_V=voltage_V,
            forces_N=readings_N,
            s_m=s_m,
            x_m=x_m,
            y_m=y_m,
            curve_sigma_m=self._errors.sigma_m,
            true_force_N=force_N,
            true_B_Nm2=B,
            true_mean_eibm_Nm=mean_eibm,
            true_l_hat_m=l_hat_m,
        )

    def _curve(
        self, setup: MountedSheet, state: Equilibrium, random: np.random.Generator
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        length_m = setup.chain.sheet.visible_m
        s_m = self._errors.places(length_m)
        points = s_m.size
        curve = setup.chain.curve(state.phi_rad, s_m)
        angle = np.interp(s_m, np.arange(setup.chain.links) * setup.chain.h_m, state.phi_rad)
        off = self._errors.white_m * random.standard_normal(points)
        off += self._smooth_factor(s_m) @ random.standard_normal(points)
        dx, dy = setup.scatter.registration_m
        return s_m, curve[:, 0] + dx - off * np.sin(angle), curve[:, 1] + dy + off * np.cos(angle)

    def _smooth_factor(self, s_m: FloatArray) -> FloatArray:
        """Matrix that makes correlated errors of independent ones."""
        if s_m.size not in self._factors:
            self._factors[s_m.size] = self._errors.smooth_factor(s_m)
        return self._factors[s_m.size]


def _state(setup: MountedSheet, drive: float) -> Equilibrium | None:
    """At rest at a drive, reached as on the rig: placed at 0 V, then driven."""
    if setup.position_m is None:
        return setup.chain.free(drive)
    contact = ContactState(setup.chain, setup.arc)
    start = contact.place(0.0, setup.arc_rad)
    if start is None:
        return None
    state, whole = contact.drive_to(start, drive, setup.arc_rad)
    return contact.yielded(state, setup.arc_rad) if whole else None
