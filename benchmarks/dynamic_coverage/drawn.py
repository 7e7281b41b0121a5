"""A session drawn at random: the sheet, the rig around it, what is measured.

All follows from the seed. Ranges are those of wet Nafion with platinum, about the shipped world's
values. What a person states about the rig is known exactly: lengths, initial curvature, rolls,
the load cell's resonance, fluid, source, and how strong each kind of noise is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from model.dynamics import (
    ContactSetup,
    DynamicBeam,
    ElectrodeLine,
    FluidLoad,
    HeldVoltage,
    Viscoelasticity,
)
from model.dynamics.fluid import VACUUM, fluid_load
from model.dynamics.identification import ChannelNoise, RecordingNoise, RunPlan
from model.mechanics.field import Field
from sim_hardware.world import WorldSettings, load_world
from sim_hardware.world.setup import MountedSheet, Scatter

SHARES = {"both": 0.55, "no release": 0.15, "no current": 0.15, "no force": 0.15}
RATE_HZ, FRAMES_HZ = 500.0, 25.0
PUSH_S, RELEASE_S = 1.5, 1.5
POINTS = (0.3, 0.65, 1.0)  # of the length: where a curve is compared
CURVE_M = 30e-6  # standard deviation of a point of a frame's curve
AIR = (1.2, 1.82e-5)  # kg/m^3, Pa s, as in the world
AIR_HZ = 3.3


@dataclass(frozen=True, kw_only=True)
class Disturbances:
    """What is added to the true signals, SI."""

    force_white_N: float
    zero_N: float  # standard deviation of the load cell's zero at the begin of a run
    drift_N: float  # of the slow wander of the zero, periods 1.5 to 120 s
    force_hum_N: float  # amplitude
    current_white_A: float
    current_zero_A: float
    current_hum_A: float
    mains_hz: float  # not exactly 50


@dataclass(frozen=True, kw_only=True)
class DrawnSession:
    """One session before it is measured."""

    seed: int
    kind: str
    settings: WorldSettings
    disturbances: Disturbances
    position_m: float
    volts: float

    @cached_property
    def truth(self) -> DynamicBeam:
        """The world's sheet in the model's words."""
        s, sheet = self.settings, self.settings.configurations["long"]
        B, per_V = sheet.stiffness_Nm2, s.electrodes.curvature_per_V_per_m
        return DynamicBeam(
            length_m=sheet.free_length_m,
            mass_per_length_kg_per_m=s.mass.density_kg_per_m3
            * sheet.width_mm
            * sheet.thickness_mm
            * 1e-6,
            material=Viscoelasticity(
                B_Nm2=B,
                shares=tuple(s.loss.shares),
                times_s=tuple(s.loss.times_s),
                viscous_time_s=s.loss.viscous_ms * 1e-3,
            ),
            rest=Field.smooth(sheet.rest_curvature, sheet.free_length_m),
            fluid=self._fluid,
            electrodes=_line(s),
            moment_per_volt_Nm=(B * per_V, B * per_V * s.eibm.negative_ratio),
        )

    @cached_property
    def start(self) -> DynamicBeam:
        """What is known or assumed before: geometry and rig as they are, all else nominal."""
        nominal = replace(nominal_session(), settings=_nominal(self.settings)).truth
        return replace(nominal, rest=self.truth.rest, fluid=self._fluid)

    @property
    def _fluid(self) -> FluidLoad:
        if self.settings.water.fluid == "none":
            return VACUUM
        width_m = self.settings.configurations["long"].width_mm * 1e-3
        return fluid_load(width_m, *AIR, AIR_HZ, drag_coefficient=2.0)

    @cached_property
    def noise(self) -> RecordingNoise:
        """The disturbances as a person would state them."""
        d = self.disturbances
        return RecordingNoise(
            force=ChannelNoise(
                white=d.force_white_N,
                zero=math.hypot(d.zero_N, d.drift_N),
                drift_per_sqrt_s=d.drift_N * _change_in_a_second(),
                hum=d.force_hum_N / math.sqrt(2.0),
            ),
            current=ChannelNoise(
                white=d.current_white_A,
                zero=d.current_zero_A,
                hum=d.current_hum_A / math.sqrt(2.0),
            ),
            curve_m=CURVE_M,
        )

    @cached_property
    def plans(self) -> tuple[RunPlan, ...]:
        """What is driven and measured."""
        push = RunPlan(
            drive=HeldVoltage(
                np.array([0.1, 0.5, 0.9, 1.2]), self.volts * np.array([1.0, -1.0, 1.0, 0.0])
            ),
            time_s=_times(PUSH_S, RATE_HZ),
            setup=self.rolls,
            force=self.kind != "no force",
            current=self.kind != "no current",
            name="position",
        )
        release = RunPlan(
            drive=HeldVoltage(np.array([0.1, 0.6]), self.volts * np.array([1.0, 0.0])),
            time_s=_times(RELEASE_S, RATE_HZ),
            force=False,
            current=self.kind != "no current",
            frame_s=_times(RELEASE_S, FRAMES_HZ) + self.settings.camera.exposure_s,
            points_m=np.array(POINTS) * self.truth.length_m,
            name="release",
        )
        return {"no release": (push,), "no force": (release,)}.get(self.kind, (push, release))

    @property
    def rolls(self) -> ContactSetup:
        cell = self.settings.load_cell
        return ContactSetup(
            radius_m=self.settings.arc.radius_mm * 1e-3,
            position_m=self.position_m,
            resonance_hz=cell.resonance_hz,
            damping=cell.damping,
        )

    def mounted(self, plan: RunPlan) -> MountedSheet:
        """The world's set-up of a run, without scatter between set-ups."""
        return MountedSheet(
            settings=self.settings,
            configuration="long",
            position_m=self.position_m if plan.setup else None,
            scatter=Scatter(),
        )


def drawn_session(seed: int, links: int = 64, step_ms: float = 0.5) -> DrawnSession:
    """Draw a session; `links` and `step_ms` are those of the world's chain."""
    random = np.random.default_rng((seed, 0xD1CE))

    def around(value: float, factor: float) -> float:
        return float(value * factor ** random.uniform(-1.0, 1.0))

    tables = {
        "configurations": {
            "long": {
                "youngs_modulus_MPa": around(150.0, 1.4),
                "rest_curvature_per_m": float(random.uniform(16.0, 30.0)),
                "rest_curvature_decay_mm": float(random.uniform(30.0, 60.0)),
            }
        },
        "mass": {"density_kg_per_m3": around(2500.0, 1.25)},
        "loss": {
            "viscous_ms": around(0.3, 3.0),
            "shares": [around(0.13, 2.0), around(0.12, 2.0)],
            "times_s": [around(0.018, 2.0), around(0.3, 2.0)],
        },
        "electrodes": {
            "ohm_per_m": around(4000.0, 2.0),
            "capacitance_F_per_m": around(0.3, 2.0),
            "bulk_ohm_m": around(0.5, 1.7),
            "leak_S_per_m": around(0.1, 3.0),
            "curvature_per_V_per_m": around(25.0, 1.5),
        },
        "eibm": {"negative_ratio": float(random.uniform(0.7, 1.1)), "saturation_V": 1e6},
        "load_cell": {
            "resonance_hz": float(random.uniform(60.0, 160.0)),
            "damping": float(random.uniform(0.01, 0.05)),
            "hysteresis_mN": 0.0,
            "nonlinearity": 0.0,
        },
        "water": {
            "fluid": str(random.choice(["none", "air"])),
            "first_pulse_deficit": 0.0,
            "stiffening_per_min": 0.0,
            "weakening_per_min": 0.0,
        },
        "amplifier": {"offset_mV": 0.0, "lag_ms": 1e-3},
        "chain": {"moving_links": links, "moving_step_ms": step_ms},
    }
    kind = str(random.choice(list(SHARES), p=list(SHARES.values())))
    milli = 1e-3
    disturbances = Disturbances(
        force_white_N=around(0.1 * milli, 1.5),
        zero_N=around(0.05 * milli, 2.0),
        drift_N=around(0.05 * milli, 2.0),
        force_hum_N=around(0.05 * milli, 3.0),
        current_white_A=around(0.05 * milli, 1.5),
        current_zero_A=around(0.01 * milli, 2.0),
        current_hum_A=around(0.03 * milli, 3.0),
        mains_hz=50.0 + 0.03 * float(random.standard_normal()),
    )
    return DrawnSession(
        seed=seed,
        kind=kind,
        settings=_world(tables),
        disturbances=disturbances,
        position_m=float(random.uniform(0.0, 0.02)),
        volts=float(random.uniform(1.0, 2.0)),
    )


def nominal_session() -> DrawnSession:
    """A session about the shipped world's sheet; only its truth is of use."""
    return drawn_session(0)


def _nominal(settings: WorldSettings) -> WorldSettings:
    """The same world with the sheet that a person expects."""
    shipped = load_world()
    sheet = settings.configurations["long"].model_copy(
        update={"youngs_modulus_MPa": shipped.configurations["long"].youngs_modulus_MPa}
    )
    return settings.model_copy(
        update={
            "configurations": {"long": sheet},
            "mass": shipped.mass,
            "loss": shipped.loss,
            "electrodes": shipped.electrodes,
            "eibm": settings.eibm.model_copy(update={"negative_ratio": 1.0}),
        }
    )


def _world(tables: dict[str, dict[str, object]]) -> WorldSettings:
    """The shipped world with these settings in place of its own."""
    content = load_world().model_dump()
    for name, table in tables.items():
        if name == "configurations":
            content[name] = {"long": content[name]["long"] | table["long"]}
        else:
            content[name] |= table
    return WorldSettings.model_validate(content | {"moving": True})


def _line(settings: WorldSettings) -> ElectrodeLine:
    e = settings.electrodes
    return ElectrodeLine(
        electrode_ohm_per_m=e.ohm_per_m,
        capacitance_F_per_m=e.capacitance_F_per_m,
        bulk_ohm_m=e.bulk_ohm_m,
        leak_S_per_m=e.leak_S_per_m,
        source_ohm=e.source_ohm,
    )


def _times(end_s: float, rate_hz: float) -> np.ndarray:
    return np.arange(round(end_s * rate_hz)) / rate_hz


def _change_in_a_second() -> float:
    """Standard deviation of the wander's change in a second, over its own.

    A wave of period T changes by 2 (1 - cos 2 pi/T) of its variance; the periods are evenly spread
    in logarithm. At the rig it is read off a recording at rest.
    """
    periods = np.exp(np.linspace(math.log(1.5), math.log(120.0), 2001))
    return math.sqrt(float(np.mean(2.0 * (1.0 - np.cos(2.0 * np.pi / periods)))))
