"""A world of rigid links: its strips are chains that take the shape of least energy.

Chains in `_chain_links`, what can be wrong in `_chain_kinds` and `_chain_plant`, noise and set-ups
in `_chain_noise`. A run's equilibria are found at `NODES` amplitudes of the EIBM; forces and shapes
over time follow by polynomials between them, for a strip with the stiffness B b and the EIBM
amplitude u has the shape of one with B and u/b, and b times its force.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BarycentricInterpolator

from benchmarks.worlds.contract import Design, HiddenKind
from benchmarks.worlds.generators import _chain_noise as noise
from benchmarks.worlds.generators._chain_kinds import KINDS, Kind
from benchmarks.worlds.generators._chain_links import (
    Equilibria,
    Floats,
    Hold,
    Strip,
    free,
    held,
    shapes,
)
from benchmarks.worlds.generators._chain_noise import SetUp
from benchmarks.worlds.generators._chain_plant import (
    RISE_S,
    RUN_S,
    STEP_S,
    WET_S,
    Course,
    Load,
    Plant,
    Sheet,
)
from model.measurements import (
    Condition,
    Curve,
    Measurements,
    Reading,
    SheetGeometry,
    TimeSeries,
)
from model.measurements import Kind as ReadingKind

RADIUS_M, WIDTH_M, THICKNESS_M = 0.04, 0.011, 0.21e-3
NODES = 9
ROUNDS = 4  # until a position that depends on the force, or a drag, has settled
WINDOW_S = 0.1  # to either side of the sampling point
SERIES_STEPS = 5  # of a sample of the series
FREE_READINGS = 2


@dataclass(frozen=True, kw_only=True)
class Visit:
    """A planned run."""

    number: int
    sheet: Sheet
    position_m: float | None
    mounting: int = 0


@dataclass(frozen=True, kw_only=True)
class Run:
    """A run, without noise."""

    visit: Visit
    course: Course
    amplitude: Floats  # (samples,) that the shape follows
    stiffness: Floats  # (samples,) factor of B
    place_m: float | None  # true
    slots: list[tuple[ReadingKind, float]]  # of each reading, with its voltage


@dataclass(frozen=True, kw_only=True)
class Table:
    """A run's equilibria at amplitudes of the EIBM, as polynomials between them."""

    load: BarycentricInterpolator | None  # force along the arc, normal force, lean; None: free
    points: BarycentricInterpolator  # (points, 2)


class ChainWorld:
    """The world."""

    name = "chain"
    numerics = "chains of 20 and 40 rigid links of least energy, by Newton's method, extrapolated"
    noise = (
        "hum of the mains, a zero that wanders, knocks that decay, curves whose points err together"
        " along the sheet; set-ups with a Student's scatter of EIBM 1 %, B 1 %, position 0.05 mm"
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
        plant, sheets = Plant(), noise.sheets(seed)
        for name, size in hidden.items():
            kind = _kind(name)
            if not abs(size) <= kind.told.largest:
                raise ValueError(f"{name} has sizes up to {kind.told.largest:g}, not {size:g}")
            if size != 0.0:
                kind.change(plant, size)
        rig = _Rig(design, plant, None if exact else seed)
        visits = list(_visits(design, sheets, seed))
        runs = [rig.run(visit, len(visits)) for visit in visits]
        conditions: list[Condition] = []
        series: list[TimeSeries] = []
        for sheet in sheets.values():
            own = [r for r in runs if r.visit.sheet is sheet]
            for run, table in zip(own, rig.tables(sheet, own), strict=True):
                rig.record(run, table, conditions, series)
        return Measurements(
            sheets={name: _geometry(sheet) for name, sheet in sheets.items()},
            conditions=tuple(conditions), series=tuple(series), source="forces.csv",
        )  # fmt: skip


def _kind(name: str) -> Kind:
    if name not in KINDS:
        raise ValueError(f"the world chain hides no '{name}', but {', '.join(KINDS)}")
    return KINDS[name]


def _visits(design: Design, sheets: Mapping[str, Sheet], seed: int) -> Iterator[Visit]:
    """Yield the runs in their order."""
    number = 0
    for name, positions in design.positions_m.items():
        places: list[tuple[float | None, int]] = [(None, 0)] * design.free_shapes
        turns = noise.order(seed, len(positions), name) if design.random_order else None
        places += [(positions[k], 0) for k in turns or range(len(positions))]
        again = np.linspace(0, len(positions) - 1, design.remounts).round().astype(int)
        places += [(positions[k], 1) for k in again]
        for position_m, mounting in places:
            yield Visit(number=number, sheet=sheets[name], position_m=position_m, mounting=mounting)
            number += 1


def _geometry(sheet: Sheet) -> SheetGeometry:
    return SheetGeometry(
        configuration=sheet.name, free_length_m=sheet.free_m, width_m=WIDTH_M,
        thickness_m=THICKNESS_M, elongation_m=sheet.elongation_m, arc_radius_m=RADIUS_M,
        arc_origin_rad=0.0, initial_curvature=(sheet.nodes_m, sheet.rest_per_m),
        rise_time_s=RISE_S,
    )  # fmt: skip


class _Rig:
    """Measures; `seed` None: without noise, every set-up nominal, amid the session."""

    def __init__(self, design: Design, plant: Plant, seed: int | None) -> None:
        self._design, self._plant, self._seed = design, plant, seed

    # ------------------------------------------------------------------------- what happens

    def run(self, visit: Visit, count: int) -> Run:
        """Let a run go by."""
        setup = SetUp() if self._seed is None else noise.set_up(self._seed, visit.number)
        slots = list(self._slots(visit))
        course = self._course(visit, [volts for _, volts in slots], count)
        stiffness = setup.stiffness * self._plant.stiffened(course)
        place_m = visit.position_m
        if place_m is not None:
            for move in self._plant.place:
                place_m = move(place_m, float(course.session[0]))
            place_m += setup.place_m
        return Run(
            visit=visit, course=course, slots=slots, stiffness=stiffness, place_m=place_m,
            amplitude=setup.eibm * self._plant.driven(course) / stiffness,
        )  # fmt: skip

    def _slots(self, visit: Visit) -> Iterator[tuple[ReadingKind, float]]:
        d = self._design
        readings = d.readings if visit.position_m is not None else FREE_READINGS
        yield from (("zero", 0.0) for _ in range(readings))
        for k in range(d.discarded + 2 * readings):
            yield "discarded" if k < d.discarded else "kept", d.voltages_V[k % 2]

    def _course(self, visit: Visit, volts: Sequence[float], count: int) -> Course:
        steps = round(self._design.pulse_s / STEP_S)
        train = np.repeat(np.asarray(volts), steps)
        time_s = STEP_S * np.arange(len(train))
        session_s = visit.number * RUN_S + time_s
        share = np.full(len(train), 0.5) if self._seed is None else session_s / (count * RUN_S)
        pulse = np.cumsum(np.asarray(volts) != 0.0) - 1
        return Course(
            sheet=visit.sheet, position_m=visit.position_m, time_s=time_s, session=share,
            volts=train, pulse=np.repeat(pulse, steps).astype(float),
            since_s=time_s % self._design.pulse_s, pulse_s=self._design.pulse_s,
        )  # fmt: skip

    # ------------------------------------------------------------------------- equilibria

    def tables(self, sheet: Sheet, runs: Sequence[Run]) -> list[Table]:
        """Return the equilibria of the runs of a configuration, all found together."""
        most = 1.001 * max((float(np.max(np.abs(r.amplitude))) for r in runs), default=1.0)
        nodes = most * np.cos((2 * np.arange(NODES) + 1) * np.pi / (2 * NODES))
        found: dict[int, Table] = {}
        for loose in (True, False):
            own = [r for r in runs if (r.place_m is None) == loose]
            if own:
                tables = self._tables(sheet, own, nodes, loose)
                found |= {r.visit.number: t for r, t in zip(own, tables, strict=True)}
        return [found[r.visit.number] for r in runs]

    def _tables(
        self, sheet: Sheet, runs: Sequence[Run], nodes: Floats, loose: bool
    ) -> Iterator[Table]:
        strip, s_m = self._plant.strip(sheet), self._places(sheet)
        hold = Hold(
            amplitude=np.tile(nodes, len(runs)), radius_m=RADIUS_M, beside_m=self._plant.beside_m,
            position_m=np.repeat([r.place_m or 0.0 for r in runs], NODES),
            weight_N_per_m=self._plant.weight_N_per_m, whole_m=sheet.free_m + sheet.elongation_m,
        )  # fmt: skip
        if loose:
            found = free(strip, hold)
        else:
            hold, found = self._settled(strip, hold)
        points = shapes(strip, hold, found, s_m)
        loads = _loads(hold, found)
        for k in range(0, len(points), NODES):
            yield Table(
                load=None if loose else BarycentricInterpolator(nodes, loads[k : k + NODES]),
                points=BarycentricInterpolator(nodes, points[k : k + NODES]),
            )

    def _settled(self, strip: Strip, hold: Hold) -> tuple[Hold, Equilibria]:
        """Return equilibria with a cell that gives way and rolls that drag."""
        give, friction, stated_m = self._plant.cell_give_m_per_N, self._plant.friction, hold
        found = held(strip, hold)
        for _ in range(ROUNDS if give or friction else 0):
            force, normal, _ = _loads(hold, found).T
            middle = np.repeat(np.mean(found.length_m.reshape(-1, NODES), axis=1), NODES)
            way = np.sign(found.length_m - middle) * np.sign(hold.amplitude)
            hold = replace(
                hold,
                position_m=stated_m.position_m + give * force,
                drag_N=friction * np.abs(normal) * np.tanh(2.0 * hold.amplitude) * way,
            )
            found = held(strip, hold, found)
        return hold, found

    def _places(self, sheet: Sheet) -> Floats:
        return np.linspace(0.0, sheet.free_m + sheet.elongation_m, self._design.curve_points)

    # ------------------------------------------------------------------------- what is measured

    def record(
        self, run: Run, table: Table, conditions: list[Condition], series: list[TimeSeries]
    ) -> None:
        """Add what a run leaves."""
        force, course = self._force(run, table), run.course
        curves = self._curves(run, table)
        d, visit = self._design, run.visit
        steps = round(d.pulse_s / STEP_S)
        reach, middle = round(WINDOW_S / STEP_S), round(d.sample_s / STEP_S)
        window = np.hanning(2 * reach + 1)
        readings = []
        for k, (kind, volts) in enumerate(run.slots):
            at = k * steps + middle
            part = force[at - reach : at + reach + 1]
            weights = window[: len(part)]
            time_s = at * STEP_S
            readings.append((volts, Reading(
                index=k, kind=kind, force_N=float(weights @ part / np.sum(weights)), time_s=time_s,
                session_s=visit.number * RUN_S + time_s, wetted_s=WET_S + time_s,
                curve=curves.single[k] if d.series else None,
            )))  # fmt: skip
        conditions += [
            Condition(
                configuration=visit.sheet.name, position_m=visit.position_m, voltage_V=volts,
                readings=tuple(r for v, r in readings if v == volts), curve=curves.mean[volts],
                mounting=visit.mounting, approach="" if visit.position_m is None else "up",
            )
            for volts in (0.0, *d.voltages_V)
        ]  # fmt: skip
        if d.series and visit.position_m is not None:
            count = len(force) // SERIES_STEPS * SERIES_STEPS
            parts = (v[:count].reshape(-1, SERIES_STEPS) for v in (course.time_s, force))
            time_s, mean = (np.mean(p, axis=1) for p in parts)
            series.append(TimeSeries(
                configuration=visit.sheet.name, position_m=visit.position_m, time_s=time_s,
                drive_V=course.volts[:count:SERIES_STEPS], force_N=mean, mounting=visit.mounting,
            ))  # fmt: skip

    def _force(self, run: Run, table: Table) -> Floats:
        """Return what the cell shows, (samples,) in N."""
        count = len(run.amplitude)
        load = Load(np.zeros(count), np.zeros(count), np.zeros(count))
        if table.load is not None:
            force, normal, lean = table.load(run.amplitude).T
            load = Load(run.stiffness * force, run.stiffness * normal, lean)
        shown = load.force_N
        if table.load is not None:
            for more in self._plant.felt:
                shown = shown + more(run.course, load)
        if self._seed is None:
            return shown
        return shown + noise.force_noise(self._seed, run.visit.number, run.course.time_s)

    def _curves(self, run: Run, table: Table) -> _Curves:
        """Return the curves of all images of a run and of their means."""
        d, course, s_m = self._design, run.course, self._places(run.visit.sheet)
        at = np.arange(len(run.slots)) * d.pulse_s + d.sample_s - self._plant.late_s
        amplitude = np.interp(at, course.time_s, run.amplitude)
        points = np.asarray(table.points(amplitude))
        for pictured in self._plant.seen:
            points = pictured(course, points)
        normal = _normals(points)
        shared, means = np.zeros((3, len(s_m))), np.zeros((3, len(s_m)))
        single = np.zeros((len(run.slots), len(s_m)))
        if self._seed is not None:
            shared, means, single = noise.curve_errors(
                self._seed, run.visit.number, s_m, len(run.slots)
            )
        volts = (0.0, *d.voltages_V)
        curves = _Curves([], {})
        for k, (_, v) in enumerate(run.slots):
            off = shared[volts.index(v)] + single[k]
            curves.single.append(_curve(s_m, points[k] + off[:, None] * normal[k], noise.IMAGES))
        for i, v in enumerate(volts):
            use = [k for k, (kind, u) in enumerate(run.slots) if u == v and kind != "discarded"]
            off = (shared[i] + means[i])[:, None] * np.mean(normal[use], axis=0)
            curves.mean[v] = _curve(s_m, np.mean(points[use], axis=0) + off, 1)
        return curves


@dataclass(frozen=True)
class _Curves:
    single: list[Curve]
    mean: dict[float, Curve]


def _loads(hold: Hold, found: Equilibria) -> Floats:
    """Return the force along the arc, the normal force (N) and the lean gamma, (n, 3)."""
    beta, phi = hold.position_m / RADIUS_M, found.angle_rad
    fx, fy = (-f for f in found.force_N)  # on the cell
    along = -fx * np.sin(beta) + fy * np.cos(beta)
    normal = -fx * np.sin(phi) + fy * np.cos(phi)
    return np.stack([along, normal, phi - beta], axis=1)


def _normals(points: Floats) -> Floats:
    """Return the unit normals of curves (n, points, 2)."""
    along = np.gradient(points, axis=1)
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    return np.stack([-along[..., 1], along[..., 0]], axis=-1)


def _curve(s_m: Floats, points: Floats, rougher: int) -> Curve:
    sigma = float(np.hypot(noise.POINT_M * np.sqrt(rougher), noise.TOGETHER_M))
    return Curve(s_m=s_m, x_m=points[:, 0], y_m=points[:, 1], sigma_m=np.full(len(s_m), sigma))


WORLD = ChainWorld()
