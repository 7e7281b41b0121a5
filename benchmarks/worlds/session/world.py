"""A session as its instruments show it, from what is true at every sample."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.contract import Design, HiddenKind
from benchmarks.worlds.session.effects import Acting, Taken
from benchmarks.worlds.session.layout import FRAME, READING, SERIES, Layout, Run, runs_of, slots_of
from model.measurements import (
    Condition,
    Curve,
    Measurements,
    Reading,
    SheetGeometry,
    TimeSeries,
)

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
Acts = Sequence[tuple[Acting, float]]  # with their sizes


class Noise(Protocol):
    """What the numbers of one run are off by."""

    def readings(self, time_s: Array) -> Array:
        """Return errors of force readings at these times of the run."""

    def series(self, time_s: Array) -> Array:
        """Return errors of the force over time."""

    def images(self, count: int, points: int) -> Array:
        """Return errors of the points of each image along their normals, (count, points)."""

    def wave(self, s_m: Array) -> Array:
        """Return what all images of a condition have in common."""


@dataclass(frozen=True, kw_only=True)
class SessionWorld:
    """A generator in the common layout; how sheets are solved and what noise is are its own."""

    name: str
    numerics: str
    noise: str
    acts: Mapping[str, Acting]
    layout: Layout
    sheets: Callable[[int], Mapping[str, Any]]  # the true sheets of a seed
    geometry: Callable[[str, Any], SheetGeometry]  # what sheet.toml says of one
    taken: Callable[[Any, list[Run], Design, Acts], Taken]  # what is true
    run_noise: Callable[[int, Run, bool], Noise]  # seed, run, exact
    point_m: float  # stated errors: of a point of one image, and of all of a condition
    wave_m: float
    finer: int  # places of a shape to one point of a curve

    @property
    def kinds(self) -> Mapping[str, HiddenKind]:
        """What can be hidden."""
        return {name: one.kind for name, one in self.acts.items()}

    def parameters(self, kind: str, size: float) -> Mapping[str, float]:
        """Return the catalogue's parameters where the form is its own."""
        self._checked({kind: size})
        find = self.acts[kind].parameters
        return find(size) if find else {}

    def measure(
        self, design: Design, hidden: Mapping[str, float], seed: int, *, exact: bool = False
    ) -> Measurements:
        """Return a session; see the contract."""
        acts = self._checked(hidden)
        runs = runs_of(self.layout, design, seed, exact)
        sheets = self.sheets(seed)
        unknown = sorted(set(design.positions_m) - set(sheets))
        if unknown:
            raise ValueError(f"there is no configuration '{unknown[0]}': long and short are")
        conditions: list[Condition] = []
        series: list[TimeSeries] = []
        for name in design.positions_m:
            own = [run for run in runs if run.configuration == name]
            if not own:
                continue
            taken = self.taken(sheets[name], own, design, acts)
            for run in own:
                count = sum(
                    other.number < run.number
                    and (other.position_m, other.mounting) == (run.position_m, run.mounting)
                    for other in own
                )
                shown = _Shown(self, run, design, taken, self.run_noise(seed, run, exact), count)
                conditions += shown.conditions()
                series += shown.series()
        return Measurements(
            sheets={name: self.geometry(name, sheets[name]) for name in design.positions_m},
            conditions=tuple(conditions), series=tuple(series), source=f"{self.name}.csv",
        )  # fmt: skip

    def _checked(self, hidden: Mapping[str, float]) -> list[tuple[Acting, float]]:
        for name, size in hidden.items():
            if name not in self.acts:
                raise ValueError(f"the world '{self.name}' cannot hide '{name}'")
            most = self.acts[name].kind.largest
            if not abs(size) <= most:
                raise ValueError(f"'{name}' is at most {most:g}, not {size:g}")
        return [(one, hidden[name]) for name, one in self.acts.items() if hidden.get(name)]


class _Shown:
    """What is shown of one run."""

    def __init__(
        self, world: SessionWorld, run: Run, design: Design, taken: Taken, noise: Noise, count: int
    ) -> None:
        self.world, self.run, self.design, self.taken, self.count = world, run, design, taken, count
        own, at = taken.at.run == run.number, taken.at
        self.rows = {role: np.flatnonzero(own & (at.role == role)) for role in range(3)}
        frames = np.flatnonzero(own[at.role == FRAME])
        image = taken.image
        self.s_m = image.s_m[frames][:, :: world.finer]
        shape = np.stack([image.x_m[frames], image.y_m[frames]])[:, :, :: world.finer]
        phi = image.phi_rad[frames][:, :: world.finer]
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
            sigma = float(np.hypot(self.world.point_m / np.sqrt(len(kept)), self.world.wave_m))
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
            curve = _curve(
                self.s_m[slot], x, y, float(np.hypot(self.world.point_m, self.world.wave_m))
            )
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
