"""A session of this world: what its instruments show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.contract import Design, HiddenKind
from benchmarks.worlds.generators._elements_effects import Acting
from benchmarks.worlds.generators._elements_further import FURTHER
from benchmarks.worlds.generators._elements_known import KNOWN
from benchmarks.worlds.generators._elements_noise import POINT_M, WAVE_M, RunNoise
from benchmarks.worlds.generators._elements_protocol import (
    FRAME,
    READING,
    SERIES,
    Run,
    runs_of,
    slots_of,
)
from benchmarks.worlds.generators._elements_specimen import geometry, specimens
from benchmarks.worlds.generators._elements_truth import FINER, Taken, taken_of
from model.measurements import Condition, Curve, Measurements, Reading, TimeSeries

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
ACTS = {**KNOWN, **FURTHER}


@dataclass(frozen=True)
class ElementsWorld:
    """The generator."""

    name: str = "elements"
    numerics: str = (
        "geometrically exact finite elements, quadratic in the direction, on a mesh that stretches"
        " to the contact; Newton's iteration with a Lagrange multiplier"
    )
    noise: str = (
        "Student's t of 4 degrees, 0.03 mN a reading, each correlated by 0.4 with the one before;"
        " mains hum of 0.01 mN; set-ups of 6 degrees; images of 0.04 mm a point, neighbours alike"
    )
    kinds: Mapping[str, HiddenKind] = field(
        default_factory=lambda: {name: one.kind for name, one in ACTS.items()}
    )

    def parameters(self, kind: str, size: float) -> Mapping[str, float]:
        """Return the catalogue's parameters where the form is its own."""
        self._checked({kind: size})
        find = ACTS[kind].parameters
        return find(size) if find else {}

    def measure(
        self, design: Design, hidden: Mapping[str, float], seed: int, *, exact: bool = False
    ) -> Measurements:
        """Return a session; see the contract."""
        acts = self._checked(hidden)
        runs = runs_of(design, seed, exact)
        sheets = specimens(seed)
        unknown = sorted(set(design.positions_m) - set(sheets))
        if unknown:
            raise ValueError(f"there is no configuration '{unknown[0]}': long and short are")
        conditions: list[Condition] = []
        series: list[TimeSeries] = []
        for name in design.positions_m:
            own = [run for run in runs if run.configuration == name]
            if not own:
                continue
            taken = taken_of(sheets[name], own, design, acts)
            for run in own:
                count = sum(
                    other.number < run.number
                    and (other.position_m, other.mounting) == (run.position_m, run.mounting)
                    for other in own
                )
                shown = _Shown(run, design, taken, RunNoise(seed, run, exact), count)
                conditions += shown.conditions()
                series += shown.series()
        return Measurements(
            sheets={name: geometry(name, sheets[name]) for name in design.positions_m},
            conditions=tuple(conditions), series=tuple(series), source=f"{self.name}.csv",
        )  # fmt: skip

    def _checked(self, hidden: Mapping[str, float]) -> list[tuple[Acting, float]]:
        for name, size in hidden.items():
            if name not in ACTS:
                raise ValueError(f"the world '{self.name}' cannot hide '{name}'")
            most = ACTS[name].kind.largest
            if not abs(size) <= most:
                raise ValueError(f"'{name}' is at most {most:g}, not {size:g}")
        return [(one, hidden[name]) for name, one in ACTS.items() if hidden.get(name)]


WORLD = ElementsWorld()


class _Shown:
    """What is shown of one run."""

    def __init__(self, run: Run, design: Design, taken: Taken, noise: RunNoise, count: int) -> None:
        self.run, self.design, self.taken, self.count = run, design, taken, count
        own, at = taken.at.run == run.number, taken.at
        self.rows = {role: np.flatnonzero(own & (at.role == role)) for role in range(3)}
        frames = np.flatnonzero(own[at.role == FRAME])
        image = taken.image
        self.s_m = image.s_m[frames][:, ::FINER]
        shape = np.stack([image.x_m[frames], image.y_m[frames]])[:, :, ::FINER]
        phi = image.phi_rad[frames][:, ::FINER]
        self.normal = np.stack([-np.sin(phi), np.cos(phi)])
        self.shape = shape + np.array(run.registration_m)[:, None, None]
        self.aside = noise.images(*phi.shape)
        self.noise = noise
        self.force_N = taken.load.force_N[self.rows[READING]]
        self.force_N = self.force_N + noise.readings(at.time_s[self.rows[READING]])

    def conditions(self) -> list[Condition]:
        """One for each voltage: 0 V first."""
        drive = slots_of(self.design)
        return [self._condition(v, drive == v) for v in (0.0, *self.design.voltages_V)]

    def _condition(self, volts: float, slots: npt.NDArray[np.bool_]) -> Condition:
        own = np.flatnonzero(slots)
        kept = own[own >= self.design.readings + self.design.discarded] if volts else own
        wave = self.noise.wave(self.s_m[0])
        held = self.taken.held[self.rows[READING]]
        curve = None
        if np.all(held[own]):
            mean = np.mean(self.aside[kept], axis=0) + wave
            x, y = np.mean(self.shape[:, kept] + mean * self.normal[:, kept], axis=1)
            sigma = float(np.hypot(POINT_M / np.sqrt(len(kept)), WAVE_M))
            curve = _curve(np.mean(self.s_m[kept], axis=0), x, y, sigma)
        return Condition(
            configuration=self.run.configuration, position_m=self.run.position_m,
            voltage_V=volts, readings=tuple(self._reading(k, bool(held[k]), wave) for k in own),
            curve=curve, mounting=self.run.mounting, run=self.count,
        )  # fmt: skip

    def _reading(self, slot: int, held: bool, wave: Array) -> Reading:
        row, at = self.rows[READING][slot], self.taken.at
        curve = None
        if held and self.design.series:
            aside = self.aside[slot] + wave
            x, y = self.shape[:, slot] + aside * self.normal[:, slot]
            curve = _curve(self.s_m[slot], x, y, float(np.hypot(POINT_M, WAVE_M)))
        if slot < self.design.readings:
            kind = "zero"
        else:
            kind = "kept" if slot >= self.design.readings + self.design.discarded else "discarded"
        return Reading(
            index=int(slot), kind=kind, force_N=float(self.force_N[slot]),
            time_s=float(at.time_s[row]), session_s=float(at.session_s[row]),
            wetted_s=float(at.wetted_s[row]), valid=held,
            why="" if held else "not reachable: the sheet slips out of the rolls", curve=curve,
        )  # fmt: skip

    def series(self) -> list[TimeSeries]:
        """The force over time, where it is asked for."""
        rows, at = self.rows[SERIES], self.taken.at
        if not len(rows):
            return []
        force = self.taken.load.force_N[rows] + self.noise.series(at.time_s[rows])
        return [
            TimeSeries(
                configuration=self.run.configuration, position_m=self.run.position_m,
                time_s=at.time_s[rows], drive_V=at.drive_V[rows],
                force_N=None if self.run.position_m is None else force,
                mounting=self.run.mounting, run=self.count,
            )
        ]  # fmt: skip


def _curve(s: Array, x: Array, y: Array, sigma: float) -> Curve:
    return Curve(s_m=s, x_m=x, y_m=y, sigma_m=np.full(len(s), sigma))
