"""What is true at every sample of a configuration: its equilibria, force and shapes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators._elements_beam import Beam, Cases, Found, Setting
from benchmarks.worlds.generators._elements_shape import drawn
from benchmarks.worlds.generators._elements_specimen import LAYOUT, Specimen
from benchmarks.worlds.session.effects import Acting, Image, Load, Sheet, Taken
from benchmarks.worlds.session.layout import FRAME, Run, Samples, samples_of

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]
FINER = 4  # places of a shape to one point of a curve


def taken_of(
    specimen: Specimen, runs: list[Run], design: Design, acts: Sequence[tuple[Acting, float]]
) -> Taken:
    delay = sum(act.delay_s(size) for act, size in acts if act.delay_s)
    at = Samples.joined([samples_of(LAYOUT, run, design, delay) for run in runs])
    of = {run.number: run for run in runs}
    numbers, where = np.unique(at.run, return_inverse=True)
    own = [of[int(number)] for number in numbers]
    eibm = np.array([run.eibm for run in own])[where]
    position = np.array([np.nan if r.position_m is None else r.position_m for r in own])[where]
    moved = np.array([run.moved_m for run in own])[where]

    def eibm_Nm(volts: Array) -> Array:
        return eibm * specimen.eibm_Nm(volts)

    stiffness = np.array([run.stiffness for run in own])[where] * specimen.blade.stiffness_Nm2
    cases = Cases.of(position + moved, eibm_Nm(at.sheet_V), stiffness)
    sheet = Sheet(specimen.blade.length_m, specimen.blade.elongation_m, eibm_Nm)
    given: dict[str, Any] = {"laws": [act.law(size) for act, size in acts if act.law]}
    for act, size in acts:
        if act.cases:
            act.cases(cases, at, sheet, size)
        if act.setting:
            given.update(act.setting(size))
    beam = Beam(specimen.blade, Setting(**given))
    rubbing = [(act.slides, size) for act, size in acts if act.slides]
    return _Solving(beam, cases, at, position).taken(rubbing, acts, design.curve_points)


class _Solving:
    """All samples of a configuration while they are solved."""

    def __init__(self, beam: Beam, cases: Cases, at: Samples, position: Array) -> None:
        self.beam, self.cases, self.at, self.position = beam, cases, at, position
        self.touched = np.flatnonzero(~np.isnan(position))
        self.frames = at.role == FRAME

    def taken(
        self,
        rubbing: list[tuple[Callable[[Array, Samples, float], Array], float]],
        acts: Sequence[tuple[Acting, float]],
        points: int,
    ) -> Taken:
        n = len(self.position)
        force, outward, lean = np.zeros(n), np.zeros(n), np.zeros(n)
        held = np.ones(n, dtype=np.bool_)
        image = self._image(points)
        if len(self.touched):
            shapes, index = self._contact(self.touched)
            for slides, size in rubbing:
                at = self.at.take(self.touched)
                turn = np.sign(shapes.normal_N())[index]
                self.cases.rubbing[self.touched] += turn * slides(shapes.contact_m[index], at, size)
                shapes, index = self._contact(self.touched)
            along, out = shapes.shown()
            force[self.touched], outward[self.touched] = along[index], out[index]
            lean[self.touched] = (shapes.angle_rad - shapes.beta_rad)[index]
            held[self.touched] = shapes.held[index]
            self._draw_contact(image, shapes, index)
        self._draw_free(image)
        load = Load(force, outward, lean, self.position, self.at)
        for act, size in acts:
            if act.force:
                load.force_N = act.force(load, size)
            _seen(image, act, size)
        return Taken(self.at, load, held, image)

    def _draw_contact(self, image: Image, shapes: Found, index: Rows) -> None:
        own = np.flatnonzero(self.frames[self.touched])
        used, back = np.unique(index[own], return_inverse=True)
        cases = self.cases.take(self.touched)
        cases = cases.take(_different(cases)[0][used])
        self._draw(image, self.touched[own], cases, _some(shapes, used), back.ravel())

    def _draw_free(self, image: Image) -> None:
        rows = np.flatnonzero(np.isnan(self.position) & self.frames)
        if len(rows):
            cases = self.cases.take(rows)
            cases.position_m = np.zeros(len(rows))
            first, index = _different(cases)
            cases = cases.take(first)
            self._draw(image, rows, cases, self.beam.free(cases), index)

    def _contact(self, rows: Rows) -> tuple[Found, Rows]:
        """Solve what differs, from equilibria of each run at three moments on."""
        cases = self.cases.take(rows)
        first, index = _different(cases)
        cases, run = cases.take(first), self.at.run[rows][first]
        anchors = np.concatenate(
            [_anchors(cases, np.flatnonzero(run == r)) for r in np.unique(run)]
        )
        known = self.beam.solve(cases.take(anchors))
        below, above = np.zeros((2, len(run)), dtype=np.intp)
        share = np.zeros(len(run))
        for n, r in enumerate(np.unique(run)):
            own, moment = run == r, cases.moment_Nm[anchors[3 * n : 3 * n + 3]]
            upper = cases.moment_Nm[own] > moment[1]
            below[own], above[own] = 3 * n + upper, 3 * n + 1 + upper
            gap = cases.moment_Nm[anchors[above[own]]] - cases.moment_Nm[anchors[below[own]]]
            past = cases.moment_Nm[own] - cases.moment_Nm[anchors[below[own]]]
            share[own] = past / np.where(gap > 0.0, gap, 1.0)
        return self.beam.solve(cases, _between(known, below, above, share)), index

    def _image(self, points: int) -> Image:
        """Return the shapes of the frames at even places."""
        blade = self.beam.blade
        places = np.linspace(0.0, blade.length_m + blade.elongation_m, FINER * (points - 1) + 1)
        count = int(np.sum(self.frames))
        image = Image(*(np.zeros((count, len(places))) for _ in range(4)))
        image.s_m[:] = places
        return image

    def _draw(self, image: Image, rows: Rows, cases: Cases, shapes: Found, index: Rows) -> None:
        into = np.cumsum(self.frames)[rows] - 1
        shown = drawn(self.beam, cases, shapes, image.s_m[0])
        for target, values in zip((image.x_m, image.y_m, image.phi_rad), shown, strict=True):
            target[into] = values[index]


def _some(found: Found, rows: Rows) -> Found:
    """Return some of the equilibria."""
    return Found(
        found.phi[rows], found.force_N[rows], found.contact_m[rows], found.angle_rad[rows],
        found.beta_rad[rows], found.held[rows],
    )  # fmt: skip


def _between(found: Found, below: Rows, above: Rows, share: Array) -> Found:
    """Return what lies between two equilibria, not solved."""
    low, high = _some(found, below), _some(found, above)
    part = share[:, None]
    return Found(
        low.phi + part * (high.phi - low.phi),
        low.force_N + part * (high.force_N - low.force_N),
        low.contact_m + share * (high.contact_m - low.contact_m),
        low.angle_rad + share * (high.angle_rad - low.angle_rad),
        low.beta_rad + share * (high.beta_rad - low.beta_rad),
        low.held & high.held,
    )


def _anchors(cases: Cases, rows: Rows) -> Rows:
    """Return three rows: the largest moments of either sign, and the smallest of all."""
    moment = cases.moment_Nm[rows]
    return rows[[np.argmin(moment), np.argmin(np.abs(moment)), np.argmax(moment)]]


def _different(cases: Cases) -> tuple[Rows, Rows]:
    """Return the first of each kind of cases, and which of these each lane is."""
    table = np.ascontiguousarray(cases.table()) + 0.0
    rows = table.view([("", table.dtype)] * table.shape[1]).ravel()
    _, first, index = np.unique(rows, return_index=True, return_inverse=True)
    return first, index.ravel()


def _seen(image: Image, act: Acting, size: float) -> None:
    """Let a camera see the shapes; s is measured along what it sees."""
    if act.image is None:
        return
    x, y = act.image(image, size)
    before = np.hypot(np.diff(image.x_m, axis=1), np.diff(image.y_m, axis=1))
    stretch = np.hypot(np.diff(x, axis=1), np.diff(y, axis=1)) / before
    steps = np.diff(image.s_m, axis=1) * stretch
    image.s_m[:, 1:] = np.cumsum(steps, axis=1)
    image.x_m, image.y_m = x, y
