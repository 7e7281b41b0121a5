"""What is true at each sample of a session of the world `legendre`.

Within a run only few quantities change, and the equilibria are smooth in them. So they are solved
at Chebyshev's nodes of what changes, for all runs together, and are polynomials between. Where the
rolls rub, or a strip comes off the rolls, or too much changes at once, each sample is solved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators._legendre_ritz import PLACE, Array, Bools, Cases, Ritz
from benchmarks.worlds.generators._legendre_shape import felt, free, held, lies
from benchmarks.worlds.generators._legendre_specimen import DRIVE_V, LAYOUT, Specimen
from benchmarks.worlds.generators._legendre_strip import strip_of
from benchmarks.worlds.session.effects import Acting, Image, Load, Sheet, Taken
from benchmarks.worlds.session.layout import FRAME, Run, Samples, samples_of

Acts = Sequence[tuple[Acting, float]]
Rows = npt.NDArray[np.intp]

FINER = 4
NODES, FEWER, MOST = 17, 6, 110  # nodes of the EIBM, of what else changes, of all in a run
STILL = {"drive": 0.0, "even": 1e-7, "rest_per_m": 1e-7, "stiffness": 1e-7, "place_m": 1e-10}
SAME = {"drive": 1e-7, "even": 1e-7, "rest_per_m": 1e-6, "stiffness": 1e-7, "place_m": 1e-10,
        "way": 1e-4}  # fmt: skip


@dataclass
class Framed(Image):
    """Images with their samples."""

    samples: Samples


def taken(true: Specimen, runs: list[Run], design: Design, acts: Acts) -> Taken:
    """Return what is true of a configuration; see `Taken`."""
    delay = sum(one.delay_s(size) for one, size in acts if one.delay_s)
    at = Samples.joined([samples_of(LAYOUT, run, design, delay) for run in runs])
    state = _state(true, runs, at, acts)
    ritz = Ritz(strip_of(true, acts))
    whole = true.length_m + true.elongation_m
    places = np.linspace(0.0, whole, (design.curve_points - 1) * FINER + 1)
    touched = np.isfinite(state.place_m)
    plant = _Plant(ritz, state, at, places)
    plant.loose(np.flatnonzero(~touched))
    plant.touched(np.flatnonzero(touched), [(a.slides, z) for a, z in acts if a.slides])
    load = plant.load()
    for one, size in acts:
        if one.force is not None:
            load = replace(load, force_N=one.force(load, size))
    image = plant.image()
    for one, size in acts:
        if one.image is not None:
            image.x_m, image.y_m = one.image(image, size)
    return Taken(at=at, load=load, held=plant.held, image=image)


def _state(true: Specimen, runs: list[Run], at: Samples, acts: Acts) -> Cases:
    """Return what drives the strip at each sample."""
    order = np.searchsorted([run.number for run in runs], at.run)

    def of_run(value: Callable[[Run], float]) -> Array:
        return np.array([value(run) for run in runs], dtype=float)[order]

    def eibm(volts: Array) -> Array:
        return true.stiffness_Nm2 * true.eibm_per_m * true.amplitude(volts)

    place = of_run(lambda r: np.nan if r.position_m is None else r.position_m)
    state = Cases(
        drive=true.amplitude(at.sheet_V), even=(at.sheet_V / DRIVE_V) ** 2,
        rest_per_m=np.zeros(len(place)), stiffness=of_run(lambda r: r.stiffness),
        place_m=place.copy(), way=np.zeros(len(place)),
    )  # fmt: skip
    sheet = Sheet(true.length_m, true.elongation_m, eibm)
    for one, size in acts:
        if one.cases is not None:
            one.cases(state, at, sheet, size)
    state.drive[:] *= of_run(lambda r: r.eibm)
    if not any(one.setting and "even" in one.setting(size) for one, size in acts):
        state.even[:] = 0.0
    state.place_m[:] += of_run(lambda r: r.moved_m)
    return state


class _Plant:
    """Equilibria at all samples, and shapes at those of the frames."""

    def __init__(self, ritz: Ritz, state: Cases, at: Samples, places: Array) -> None:
        self.ritz, self.state, self.at, self.places = ritz, state, at, places
        count, frames = len(at.run), np.flatnonzero(at.role == FRAME)
        self.frame_of = np.full(count, -1)
        self.frame_of[frames] = np.arange(len(frames))
        self.felt, self.held = np.zeros((count, 3)), np.ones(count, dtype=bool)
        self.contact = np.full(count, np.nan)
        self.curves = np.zeros((3, len(frames), len(places)))

    # ------------------------------------------------------------------------- strips alone

    def loose(self, rows: Rows) -> None:
        """Nothing touches these."""
        rows = rows[self.frame_of[rows] >= 0]
        if len(rows):
            own = self.state.take(rows)
            x, extra = free(self.ritz, own)
            shown = lies(self.ritz, x, own, extra, self.places)
            self.curves[:, self.frame_of[rows]] = np.stack(shown[1:])

    # ------------------------------------------------------------------------- strips in the rolls

    def touched(
        self, rows: Rows, slides: list[tuple[Callable[[Array, Samples, float], Array], float]]
    ) -> None:
        """Solve what the rolls hold."""
        parts = [rows[self.at.run[rows] == number] for number in np.unique(self.at.run[rows])]
        axes = [_Axes(self.state.take(own), self._changing()) for own in parts]
        if not axes:
            return
        nodes = _joined([one.nodes for one in axes])
        x, ok, extra = held(self.ritz, nodes)
        smooth = self._smooth(x, ok)
        shown = np.stack(lies(self.ritz, x, nodes, extra, self.places)[1:])
        table = np.concatenate([felt(self.ritz, x, nodes), x[:, PLACE:]], axis=1)
        begin = 0
        for own, one in zip(parts, axes, strict=True):
            span = slice(begin, begin + len(one.nodes.drive))
            begin = span.stop
            if not np.all(smooth[span]):
                self._each(own, None, slides)
                continue
            found = one.weights @ table[span]
            self.felt[own], self.contact[own] = found[:, :3], found[:, 3]
            frames = self.frame_of[own] >= 0
            self.curves[:, self.frame_of[own[frames]]] = one.weights[frames] @ shown[:, span]
            self._judged(own, np.ones(len(own), dtype=bool))
            if slides or one.crowded:
                self._each(own, one.weights @ x[span], slides)

    def _changing(self) -> tuple[str, ...]:
        """Return what the equilibria depend on beside the EIBM over the stiffness."""
        one = self.ritz.strip
        gives = one.clamp_rad_per_Nm, one.joint_rad_per_Nm, one.cell_m_per_N, one.clamp_play_rad
        needed = any(gives) or one.weight_N_per_m
        return ("even", "rest_per_m", "place_m", *(("stiffness",) if needed else ()))

    def _smooth(self, x: Array, ok: Bools) -> Bools:
        """Return which nodes can be interpolated: the contact stays on strip or elongation."""
        one = self.ritz.strip
        on_strip = x[:, PLACE] < one.length_m - 1e-5
        usual = on_strip if one.elongation_m == 0.0 else ~on_strip
        plain = one.clamp_play_rad == 0.0 and one.eccentric_m == 0.0
        return ok & usual & plain

    def _each(
        self, rows: Rows, near: Array | None,
        slides: list[tuple[Callable[[Array, Samples, float], Array], float]],
    ) -> None:  # fmt: skip
        """Solve each sample that differs from the others."""
        if slides:
            if near is None:
                self._each(rows, None, [])
            for slide, size in slides:
                self.state.way[rows] += slide(self.contact[rows], self.at.take(rows), size)
        own = self.state.take(rows)
        parts = [np.round(getattr(own, name) / step) for name, step in SAME.items()]
        _, first, which = np.unique(
            np.stack(parts, axis=1), axis=0, return_index=True, return_inverse=True
        )
        which = which.reshape(-1)
        some = own.take(first)
        x, ok, extra = held(self.ritz, some, None if near is None else near[first])
        self.felt[rows], self.contact[rows] = felt(self.ritz, x, some)[which], x[which, PLACE]
        self._judged(rows, ok[which])
        frames = self.frame_of[rows] >= 0
        shown = np.stack(lies(self.ritz, x, some, extra, self.places)[1:])
        self.curves[:, self.frame_of[rows[frames]]] = shown[:, which[frames]]

    def _judged(self, rows: Rows, ok: Bools) -> None:
        one = self.ritz.strip
        reach = self.contact[rows] <= one.length_m + one.elongation_m
        self.held[rows] = ok & reach & (np.cos(self.felt[rows, 2]) > 0.05)

    # ------------------------------------------------------------------------- what is shown

    def load(self) -> Load:
        """Return what the cell feels."""
        B = self.ritz.strip.stiffness_Nm2 * self.state.stiffness * self.held
        touched = np.isfinite(self.state.place_m)
        force, across, lean = self.felt.T
        return Load(
            force_N=np.where(touched, B * force, 0.0), outward_N=np.where(touched, B * across, 0.0),
            lean_rad=lean, position_m=self.state.place_m, samples=self.at,
        )  # fmt: skip

    def image(self) -> Framed:
        """Return the images of the frames."""
        x, y, phi = self.curves
        return Framed(
            s_m=np.broadcast_to(self.places, x.shape), x_m=x, y_m=y, phi_rad=phi,
            samples=self.at.take(self.frame_of >= 0),
        )  # fmt: skip


class _Axes:
    """The nodes of a run, and each sample's weights on them."""

    def __init__(self, state: Cases, others: tuple[str, ...]) -> None:
        over = {n: getattr(state, n) / state.stiffness for n in ("drive", "even")}
        values = {n: over.get(n, getattr(state, n)) for n in ("drive", *others)}
        changing = [n for n, v in values.items() if np.ptp(v) > STILL[n]]
        self.crowded = NODES * FEWER ** len(changing[1:]) > MOST
        if self.crowded:
            changing = changing[:1]
        grids, self.weights = [], np.ones((len(state.drive), 1))
        for name in changing:
            nodes, own = _between(values[name], NODES if name == "drive" else FEWER)
            grids.append(nodes)
            self.weights = np.einsum("ni,nj->nij", self.weights, own).reshape(len(own), -1)
        mesh = [m.reshape(-1) for m in np.meshgrid(*grids, indexing="ij")]
        given = dict(zip(changing, mesh, strict=True))
        count = self.weights.shape[1]
        whole = {
            f.name: given.get(f.name, np.full(count, _middle(values.get(f.name), state, f.name)))
            for f in fields(Cases)
        }
        for name in ("drive", "even"):
            whole[name] = whole[name] * whole["stiffness"]
        self.nodes = Cases(**whole)


def _middle(values: Array | None, state: Cases, name: str) -> float:
    if name == "way":
        return 0.0
    shown = getattr(state, name) if values is None else values
    return float(0.5 * (np.min(shown) + np.max(shown)))


def _between(values: Array, count: int) -> tuple[Array, Array]:
    """Return Chebyshev's nodes of the values' range, and Lagrange's polynomials at the values."""
    angle = (2 * np.arange(count) + 1) * np.pi / (2 * count)
    low, high = float(np.min(values)), float(np.max(values))
    t = (2.0 * values - low - high) / max(high - low, 1e-300)
    k = np.arange(count)
    at_values = np.cos(k * np.arccos(np.clip(t, -1.0, 1.0))[:, None])
    at_nodes = np.cos(k * angle[:, None])
    scale = np.where(k == 0, 1.0, 2.0) / count
    nodes = 0.5 * (low + high) + 0.5 * (high - low) * np.cos(angle)
    return nodes, np.asarray(at_values @ (scale[:, None] * at_nodes.T))


def _joined(parts: list[Cases]) -> Cases:
    return Cases(
        **{f.name: np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Cases)}
    )
