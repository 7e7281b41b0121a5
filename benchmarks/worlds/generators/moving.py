"""A world that moves: chains with mass and losses, followed in time, their electrodes charging.

The chain is that of `sim_hardware.world.motion`; sheets, noise, set-ups and what is hidden are this
world's own. Held runs go in steps of 5 ms, free ones of 2.5 ms. A free strip still swings by
millimetres when its image is taken half a second after an edge, whatever is hidden; `exact` shows
it without its mass, at rest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.worlds.contract import Design, HiddenKind
from benchmarks.worlds.generators import _moving_noise as noise
from benchmarks.worlds.generators._moving_kinds import KINDS, Kind
from benchmarks.worlds.generators._moving_sheet import (
    LINKS,
    RADIUS_M,
    RISE_S,
    THICKNESS_M,
    WIDTH_M,
    Course,
    Floats,
    Strip,
    Wrong,
    extrapolated,
    points,
)
from model.measurements import Condition, Curve, Measurements, Reading, SheetGeometry, TimeSeries
from model.measurements import Kind as ReadingKind

RUN_S, WET_S, WINDOW_S = 70.0, 10.0, 0.1
FREE_READINGS = 4
SERIES_STEPS = 2


@dataclass(frozen=True, kw_only=True)
class Visit:
    """A planned run."""

    number: int
    strip: Strip
    position_m: float | None
    mounting: int = 0


class MovingWorld:
    """The world."""

    name = "moving"
    numerics = (
        "chains of 40 and 80 links with mass and loss, stepped in time and extrapolated; electrodes"
        " as RC ladders"
    )
    noise = (
        "a zero that drifts, hum of the mains, images that shake about the clamp and share errors;"
        " free shapes that still swing; set-ups with a triangular scatter of EIBM 1 %, B 1 %,"
        " position 0.05 mm"
    )
    kinds: Mapping[str, HiddenKind] = {name: kind.told for name, kind in KINDS.items()}

    def parameters(self, kind: str, size: float) -> Mapping[str, float]:
        """Return the catalogue's parameters where the form is the catalogue's."""
        known = _kind(kind).parameters
        return {} if known is None else known(size)

    def measure(
        self, design: Design, hidden: Mapping[str, float], seed: int, *, exact: bool = False
    ) -> Measurements:
        """Return a session; see the contract."""
        wrong, strips = Wrong(), noise.strips(seed)
        for name, size in hidden.items():
            kind = _kind(name)
            if not abs(size) <= kind.told.largest:
                raise ValueError(f"{name} has sizes up to {kind.told.largest:g}, not {size:g}")
            if size != 0.0:
                kind.change(wrong, size)
        visits = list(_visits(design, strips, seed))
        conditions: list[Condition] = []
        series: list[TimeSeries] = []
        for visit in visits:
            run = _Run(design, wrong, visit, len(visits), None if exact else seed)
            conditions += run.conditions()
            if design.series and visit.position_m is not None:
                series.append(run.series())
        return Measurements(
            sheets={name: _geometry(strip) for name, strip in strips.items()
                    if name in design.positions_m},
            conditions=tuple(conditions), series=tuple(series), source="forces.csv",
        )  # fmt: skip


def _kind(name: str) -> Kind:
    if name not in KINDS:
        raise ValueError(f"the world moving hides no '{name}', but {', '.join(KINDS)}")
    return KINDS[name]


def _visits(design: Design, strips: Mapping[str, Strip], seed: int) -> Iterator[Visit]:
    """Yield the runs in their order."""
    number = 0
    for name, positions in design.positions_m.items():
        turns = noise.order(seed, len(positions), name) if design.random_order else None
        again = np.linspace(0, len(positions) - 1, design.remounts).round().astype(int)
        places: list[tuple[float | None, int]] = [(None, 0)] * design.free_shapes
        places += [(positions[k], 0) for k in turns or range(len(positions))]
        places += [(positions[k], 1) for k in again]
        for position_m, mounting in places:
            yield Visit(number=number, strip=strips[name], position_m=position_m, mounting=mounting)
            number += 1


def _geometry(strip: Strip) -> SheetGeometry:
    return SheetGeometry(
        configuration=strip.name, free_length_m=strip.free_m, width_m=WIDTH_M,
        thickness_m=THICKNESS_M, elongation_m=strip.bar_m, arc_radius_m=RADIUS_M,
        arc_origin_rad=0.0, initial_curvature=(strip.nodes_m, strip.rest_per_m),
        rise_time_s=RISE_S,
    )  # fmt: skip


class _Run:
    """One visit, simulated; `seed` None: without noise and mass, nominal, amid the session."""

    def __init__(
        self, design: Design, wrong: Wrong, visit: Visit, count: int, seed: int | None
    ) -> None:
        self._design, self._wrong, self._visit, self._seed = design, wrong, visit, seed
        setup = noise.SetUp() if seed is None else noise.set_up(seed, visit.number)
        self._slots = list(self._readings())
        session = 0.5 if seed is None else (visit.number + 0.5) / count
        place_m = visit.position_m
        if place_m is not None:
            for move in wrong.place:
                place_m = move(place_m, session)
            place_m += setup.place_m
        sheets = [
            wrong.sheet(visit.strip, place_m, setup.stiffness, links, massless=seed is None)
            for links in LINKS
        ]
        self._step_s = sheets[0].step_s
        self._steps = round(design.pulse_s / self._step_s)
        self._course = self._timed([volts for _, volts in self._slots], session)
        share, stiff = (
            np.full(self._course.volts.size, setup.eibm),
            np.ones(self._course.volts.size),
        )
        for moment in wrong.moment:
            share = share * moment(self._course)
        for factor in wrong.stiff:
            stiff = stiff * factor(self._course)
        runs = [sheet.run(self._course.volts, share, stiff) for sheet in sheets]
        self._force = self._shown(extrapolated(*(force for force, _ in runs))[:-1])
        self._phi = [phi for _, phi in runs]

    def _readings(self) -> Iterator[tuple[ReadingKind, float]]:
        d = self._design
        readings = d.readings if self._visit.position_m is not None else FREE_READINGS
        yield from (("zero", 0.0) for _ in range(readings))
        for k in range(d.discarded + 2 * readings):
            yield "discarded" if k < d.discarded else "kept", d.voltages_V[k % 2]

    def _timed(self, volts: Sequence[float], session: float) -> Course:
        pulse = np.cumsum(np.asarray(volts) != 0.0) - 1.0
        return Course(
            strip=self._visit.strip, position_m=self._visit.position_m, session=session,
            time_s=self._step_s * np.arange(len(volts) * self._steps),
            volts=np.repeat(np.asarray(volts, dtype=float), self._steps),
            pulse=np.repeat(pulse, self._steps),
        )  # fmt: skip

    def _shown(self, force: Floats) -> Floats:
        """Return what the load cell shows, at the steps' beginnings."""
        shown = force
        if self._visit.position_m is not None:
            for more in self._wrong.felt:
                shown = shown + more(self._course, force)
        if self._seed is None:
            return shown
        return shown + noise.force_noise(self._seed, self._visit.number, self._course.time_s)

    def conditions(self) -> Iterator[Condition]:
        """Yield what is measured at each voltage."""
        d, visit = self._design, self._visit
        single, mean = self._curves()
        reach = round(WINDOW_S / self._step_s)
        window = np.hanning(2 * reach + 1)
        readings = []
        for k, (kind, volts) in enumerate(self._slots):
            time_s = k * d.pulse_s + d.sample_s
            at = round(time_s / self._step_s)
            part = self._force[at - reach : at + reach + 1]
            weights = window[: len(part)]
            readings.append((volts, Reading(
                index=k, kind=kind, force_N=float(weights @ part / weights.sum()), time_s=time_s,
                session_s=visit.number * RUN_S + time_s, wetted_s=WET_S + time_s,
                curve=single[k] if d.series else None,
            )))  # fmt: skip
        for volts in (0.0, *d.voltages_V):
            yield Condition(
                configuration=visit.strip.name, position_m=visit.position_m, voltage_V=volts,
                readings=tuple(r for v, r in readings if v == volts), curve=mean[volts],
                mounting=visit.mounting, approach="" if visit.position_m is None else "up",
            )  # fmt: skip

    def series(self) -> TimeSeries:
        """Return the force over time."""
        time_s, force = (
            v.reshape(-1, SERIES_STEPS).mean(axis=1) for v in (self._course.time_s, self._force)
        )
        return TimeSeries(
            configuration=self._visit.strip.name, position_m=self._visit.position_m, time_s=time_s,
            drive_V=self._course.volts[::SERIES_STEPS], force_N=force,
            mounting=self._visit.mounting,
        )  # fmt: skip

    def _curves(self) -> tuple[list[Curve], dict[float, Curve]]:
        """Return the curves of all images, and of each voltage's mean image."""
        d, strip = self._design, self._visit.strip
        s_m = np.linspace(0.0, strip.free_m + strip.bar_m, d.curve_points)
        at = np.arange(len(self._slots)) * d.pulse_s + d.sample_s - self._wrong.late_s
        rows = np.rint(at / self._step_s).astype(int)
        xy = extrapolated(*(points(strip, phi[rows], s_m) for phi in self._phi))
        for pictured in self._wrong.seen:
            xy = pictured(self._course, xy)
        along = np.gradient(xy, s_m, axis=1)
        normal = np.stack([-along[..., 1], along[..., 0]], axis=2)
        shared, own = np.zeros((3, s_m.size)), np.zeros((len(self._slots), s_m.size))
        if self._seed is not None:
            shared, own = noise.image_errors(self._seed, self._visit.number, s_m, len(own))
        sigma = float(np.hypot(noise.POINT_M, noise.SHARED_M))
        volts = (0.0, *d.voltages_V)
        mine = np.array([shared[volts.index(v)] for _, v in self._slots]) + own
        xy = xy + mine[..., None] * normal
        mean = {}
        for v in volts:
            use = [k for k, (kind, u) in enumerate(self._slots) if u == v and kind != "discarded"]
            mean[v] = _curve(s_m, xy[use].mean(axis=0), sigma)
        return [_curve(s_m, one, sigma) for one in xy], mean


def _curve(s_m: Floats, xy: Floats, sigma_m: float) -> Curve:
    return Curve(s_m=s_m, x_m=xy[:, 0], y_m=xy[:, 1], sigma_m=np.full(s_m.size, sigma_m))


WORLD = MovingWorld()
