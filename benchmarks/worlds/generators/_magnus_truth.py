"""What is true at every sample of a configuration: its equilibria, force and shapes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators._magnus_acting import Own, Seen
from benchmarks.worlds.generators._magnus_rod import Cases, Setting, Sheets, State
from benchmarks.worlds.generators._magnus_shape import Shape, drawn, free
from benchmarks.worlds.generators._magnus_specimen import LAYOUT, Specimen
from benchmarks.worlds.session.effects import Acting, Load, Sheet, Taken
from benchmarks.worlds.session.layout import FRAME, Run, Samples, samples_of

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
Acts = Sequence[tuple[Acting, float]]
FINER = 3  # places of a shape to one point of a curve


def taken_of(specimen: Specimen, runs: list[Run], design: Design, acts: Acts) -> Taken:
    """Return what is true of the runs of one configuration."""
    delay = sum(act.delay_s(size) for act, size in acts if act.delay_s)
    at = Samples.joined([samples_of(LAYOUT, run, design, delay) for run in runs])
    numbers, where = np.unique(at.run, return_inverse=True)
    of = {run.number: run for run in runs}
    own = [of[int(number)] for number in numbers]

    def each(values: list[float]) -> Array:
        return np.array(values)[where]

    position = each([np.nan if r.position_m is None else r.position_m for r in own])
    eibm = each([r.eibm for r in own])

    def eibm_Nm(volts: Array) -> Array:
        return eibm * specimen.eibm_Nm(volts)

    rod = specimen.rod
    stiffness = each([r.stiffness for r in own]) * rod.stiffness_Nm2
    cases = Cases.of(position + each([r.moved_m for r in own]), eibm_Nm(at.sheet_V), stiffness)
    given: dict[str, Any] = {"laws": [act.law(size) for act, size in acts if act.law]}
    for act, size in acts:
        if act.cases:
            act.cases(cases, at, Sheet(rod.length_m, rod.elongation_m, eibm_Nm), size)
        if act.setting:
            given.update(act.setting(size))
    found = _Session(Sheets(rod, Setting(**given)), cases, at, position)
    taken = found.taken(acts, design.curve_points)
    image, frames = taken.image, at.run[at.role == FRAME]
    for run in own:
        rows = frames == run.number
        scale = specimen.jitter(run, int(np.sum(rows)))[:, None]
        image.s_m[rows] *= scale
        image.x_m[rows] *= scale
        image.y_m[rows] *= scale
    return taken


class _Session:
    """All samples of a configuration while they are solved."""

    def __init__(self, sheets: Sheets, cases: Cases, at: Samples, position: Array) -> None:
        self.sheets, self.cases, self.at, self.position = sheets, cases, at, position
        self.touched = np.flatnonzero(~np.isnan(position))
        self.frames = at.role == FRAME

    def taken(self, acts: Acts, points: int) -> Taken:
        n = len(self.position)
        load = Load(*np.zeros((3, n)), self.position, self.at)
        held = np.ones(n, dtype=np.bool_)
        image = self._image(points)
        if len(self.touched):
            state, index = self._contacts(acts)
            for into, values in zip((load.force_N, load.outward_N), state.shown(), strict=True):
                into[self.touched] = values[index]
            load.lean_rad[self.touched] = (state.angle_rad - state.beta_rad)[index]
            held[self.touched] = state.held[index]
            self._draw_contacts(image, state, index)
        self._draw_free(image)
        for act, size in acts:
            if act.force:
                load.force_N = act.force(load, size)
            if act.image:
                _see(image, *act.image(image, size))
        return Taken(self.at, load, held, image)

    def _contacts(self, acts: Acts) -> tuple[State, Rows]:
        """Solve; and again where a kind wants to know a first solution."""
        state, index = self._solved()
        again = [(act.again, size) for act, size in acts if isinstance(act, Own) and act.again]
        if again:
            at, own = self.at.take(self.touched), self.cases.take(self.touched)
            for change, size in again:
                change(own, state.contact_m[index], state.normal_N()[index], at, size)
            for name in ("rubbing", "offset_m"):
                getattr(self.cases, name)[self.touched] = getattr(own, name)
            state, index = self._solved()
        return state, index

    def _solved(self) -> tuple[State, Rows]:
        """Solve what differs, from equilibria of each run at three moments on."""
        cases = self.cases.take(self.touched)
        first, index = _different(cases)
        cases, run = cases.take(first), self.at.run[self.touched][first]
        numbers, of = np.unique(run, return_inverse=True)
        anchors = np.concatenate([_three(cases, np.flatnonzero(run == r)) for r in numbers])
        known = self.sheets.cold(cases.take(anchors))
        moment = cases.moment_Nm[anchors].reshape(-1, 3)[of]
        upper = cases.moment_Nm > moment[:, 1]
        low = np.where(upper, moment[:, 1], moment[:, 0])
        gap = np.where(upper, moment[:, 2], moment[:, 1]) - low
        share = (cases.moment_Nm - low) / np.where(gap > 0.0, gap, 1.0)
        below, above = known.take(3 * of + upper), known.take(3 * of + 1 + upper)
        return self.sheets.solve(cases, below.between(above, share)), index

    def _image(self, points: int) -> Seen:
        """Return room for the shapes of the frames, at even places."""
        places = np.linspace(0.0, self.sheets.whole_m, FINER * (points - 1) + 1)
        count = int(np.sum(self.frames))
        image = Seen(*np.zeros((4, count, len(places))), self.at.take(self.frames))
        image.s_m[:] = places
        return image

    def _draw_contacts(self, image: Seen, state: State, index: Rows) -> None:
        own = np.flatnonzero(self.frames[self.touched])
        used, back = np.unique(index[own], return_inverse=True)
        cases = self.cases.take(self.touched)
        cases = cases.take(_different(cases)[0][used])
        shape = drawn(self.sheets, cases, state.take(used), image.s_m[0])
        self._put(image, self.touched[own], shape, back.ravel())

    def _draw_free(self, image: Seen) -> None:
        rows = np.flatnonzero(np.isnan(self.position) & self.frames)
        if len(rows):
            cases = self.cases.take(rows)
            cases.position_m = np.zeros(len(rows))
            first, index = _different(cases)
            self._put(image, rows, free(self.sheets, cases.take(first), image.s_m[0]), index)

    def _put(self, image: Seen, rows: Rows, shape: Shape, index: Rows) -> None:
        into = np.cumsum(self.frames)[rows] - 1
        for target, values in zip((image.x_m, image.y_m, image.phi_rad), shape, strict=True):
            target[into] = values[index]


def _three(cases: Cases, rows: Rows) -> Rows:
    """Return the rows of the least moment, of that nearest to none, and of the largest."""
    moment = cases.moment_Nm[rows]
    return rows[[np.argmin(moment), np.argmin(np.abs(moment)), np.argmax(moment)]]


def _different(cases: Cases) -> tuple[Rows, Rows]:
    """Return the first of each kind of cases, and which of these each case is."""
    table = np.ascontiguousarray(cases.table()) + 0.0
    rows = table.view([("", table.dtype)] * table.shape[1]).ravel()
    _, first, index = np.unique(rows, return_index=True, return_inverse=True)
    return first, index.ravel()


def _see(image: Seen, x: Array, y: Array) -> None:
    """Take over what a camera sees; s is measured along that."""
    before = np.hypot(np.diff(image.x_m, axis=1), np.diff(image.y_m, axis=1))
    after = np.hypot(np.diff(x, axis=1), np.diff(y, axis=1))
    steps = np.diff(image.s_m, axis=1) * after / np.where(before > 0.0, before, 1.0)
    image.s_m[:, 1:] = np.cumsum(steps, axis=1)
    image.x_m, image.y_m = x, y
