"""What is true at every sample of a configuration: its equilibria, force and shapes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators._shooting_equilibrium import (
    Lanes,
    Shapes,
    Shooting,
    Surroundings,
    unknowns,
)
from benchmarks.worlds.generators._shooting_specimen import LAYOUT, Specimen
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

    stiffness = np.array([run.stiffness for run in own])[where] * specimen.strip.stiffness_Nm2
    lanes = Lanes.of(position + moved, eibm_Nm(at.sheet_V), stiffness)
    sheet = Sheet(specimen.strip.length_m, specimen.strip.elongation_m, eibm_Nm)
    around: dict[str, Any] = {"laws": [act.law(size) for act, size in acts if act.law]}
    for act, size in acts:
        if act.cases:
            act.cases(lanes, at, sheet, size)
        if act.setting:
            around.update(act.setting(size))
    shooting = Shooting(specimen.strip, Surroundings(**around))
    rubbing = [(act.slides, size) for act, size in acts if act.slides]
    return _Solving(shooting, lanes, at, position).taken(rubbing, acts, design.curve_points)


class _Solving:
    """All samples of a configuration while they are solved."""

    def __init__(self, shooting: Shooting, lanes: Lanes, at: Samples, position: Array) -> None:
        self.shooting, self.lanes, self.at, self.position = shooting, lanes, at, position
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
                self.lanes.friction[self.touched] += shapes.way()[index] * slides(
                    shapes.contact_m[index], at, size
                )
                shapes, index = self._contact(self.touched)
            along, out = shapes.of_object()
            force[self.touched], outward[self.touched] = along[index], out[index]
            lean[self.touched] = (shapes.angle_rad - shapes.beta_rad)[index]
            held[self.touched] = shapes.closed[index]
            self._draw_contact(image, shapes, index)
        self._draw_free(image)
        load = Load(force, outward, lean, self.position, self.at)
        for act, size in acts:
            if act.force:
                load.force_N = act.force(load, size)
            _seen(image, act, size)
        return Taken(self.at, load, held, image)

    def _draw_contact(self, image: Image, shapes: Shapes, index: Rows) -> None:
        own = np.flatnonzero(self.frames[self.touched])
        used, back = np.unique(index[own], return_inverse=True)
        lanes = self.lanes.take(self.touched)
        lanes = lanes.take(_different(lanes)[0][used])
        guess = unknowns(shapes, self.shooting.strip)[:, used]
        drawn = self.shooting.solve(lanes, guess, dense=True)
        self._draw(image, self.touched[own], drawn, back.ravel())

    def _draw_free(self, image: Image) -> None:
        rows = np.flatnonzero(np.isnan(self.position) & self.frames)
        if len(rows):
            lanes = self.lanes.take(rows)
            lanes.position_m = np.zeros(len(rows))
            first, index = _different(lanes)
            self._draw(image, rows, self.shooting.free(lanes.take(first)), index)

    def _contact(self, rows: Rows) -> tuple[Shapes, Rows]:
        """Solve what differs, from three equilibria of each run on."""
        lanes = self.lanes.take(rows)
        first, index = _different(lanes)
        lanes, run = lanes.take(first), self.at.run[rows][first]
        anchors = np.concatenate(
            [_anchors(lanes, np.flatnonzero(run == r)) for r in np.unique(run)]
        )
        known = self.shooting.solve(lanes.take(anchors))
        q, moment = unknowns(known, self.shooting.strip), lanes.moment_Nm
        guess = np.zeros((3, len(run)))
        for r in np.unique(run):
            own, of = run == r, run[anchors] == r
            order = np.argsort(moment[anchors][of])
            for k in range(3):
                guess[k, own] = np.interp(moment[own], moment[anchors][of][order], q[k, of][order])
        return self.shooting.solve(lanes, guess), index

    def _image(self, points: int) -> Image:
        """Return the shapes of the frames at even places."""
        strip = self.shooting.strip
        places = np.linspace(0.0, strip.length_m + strip.elongation_m, FINER * (points - 1) + 1)
        count = int(np.sum(self.frames))
        image = Image(*(np.zeros((count, len(places))) for _ in range(4)))
        image.s_m[:] = places
        return image

    def _draw(self, image: Image, rows: Rows, shapes: Shapes, index: Rows) -> None:
        """Put shapes in their place: x, y by Hermite's cubics, whose slopes are known."""
        places = image.s_m[0]
        at = np.sum(shapes.s_m[:, :, None] <= places + 1e-12, axis=1) - 1
        at = np.clip(at, 0, shapes.s_m.shape[1] - 2)
        ends = [
            [np.take_along_axis(v, at + k, axis=1) for k in (0, 1)]
            for v in (shapes.s_m, shapes.x_m, shapes.y_m, shapes.phi_rad)
        ]
        (s0, s1), x, y, (phi0, phi1) = ends
        h = np.where(s1 > s0, s1 - s0, 1.0)
        t = (places - s0) / h
        into = np.cumsum(self.frames)[rows] - 1
        for target, (a, b), slope in ((image.x_m, x, np.cos), (image.y_m, y, np.sin)):
            rise = h * slope(phi0), h * slope(phi1)
            target[into] = (
                (2 * t**3 - 3 * t**2 + 1) * a + (t**3 - 2 * t**2 + t) * rise[0]
                + (3 * t**2 - 2 * t**3) * b + (t**3 - t**2) * rise[1]
            )[index]  # fmt: skip
        image.phi_rad[into] = (phi0 + t * (phi1 - phi0))[index]


def _anchors(lanes: Lanes, rows: Rows) -> Rows:
    """Return three rows: the largest moments of either sign, and the smallest of all."""
    moment = lanes.moment_Nm[rows]
    return rows[[np.argmin(moment), np.argmin(np.abs(moment)), np.argmax(moment)]]


def _different(lanes: Lanes) -> tuple[Rows, Rows]:
    """Return the first of each kind of lanes, and which of these each lane is."""
    table = np.ascontiguousarray(lanes.table()) + 0.0
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
