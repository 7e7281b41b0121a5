"""The questions of the paper's section 5, asked of a model: every answer with its uncertainty."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

import numpy as np

from labrig.report.parts.table import Table, fixed, volts, with_sigma
from model import ModelError, Parameter, SheetModel
from model.design.force_map import keeping_maps, known_voltages
from model.design.linear_models import (
    Controller,
    LinearModel,
    StateSpace,
    ValidityMap,
    controller,
    fit_linear,
    state_space,
    validity,
)
from model.design.sizing import Linearity, Size, least_area, linearity
from model.design.strength import Direction
from model.design.work import WorkAlongArc, work_along_arc
from model.design.working_section import (
    BothWays,
    LargestForce,
    Reach,
    ShapeDifference,
    StraightLine,
    best_line,
    force_both_ways,
    largest_forces,
    shape_difference,
    shortest_sheet,
)
from model.measurements import Displayed, Summary, signed
from model.sheet.misfit import Misfit

WITHOUT, WITH = "without elongation", "with elongation"


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """What the sheet is to do."""

    configuration: str
    low_m: float  # of the working section
    high_m: float
    force_N: float | None  # required throughout the section
    direction: Direction
    mass_kg: float  # of the object on the arc
    bandwidth_rad_per_s: float  # of its control
    lag_s: float  # of the voltage's effect


@dataclass(frozen=True, kw_only=True, repr=False)
class DesignAnswers(Displayed):
    """One configuration's answers; None and `unanswered`, with the reason, where there is none."""

    wanted: Wanted
    lines: tuple[StraightLine, ...]  # of the voltages that have one
    control: LinearControl | None
    shapes: ShapeDifference | None
    reach: Reach | None
    largest: dict[str, LargestForce]
    both_ways: BothWays | None
    sizes: dict[str, Size]  # without, with elongation
    elongated: Linearity | None
    work: WorkAlongArc | None
    unanswered: dict[str, str]  # question -> why

    def summary(self) -> Summary:
        """Return shapes, reach, forces and work; the other tables are in `tables`."""
        table = _force_table(self, self.wanted.configuration)
        why = tuple(f"no answer to {name}: {text}" for name, text in self.unanswered.items())
        return Summary(f"DesignAnswers {table.title}", table.columns, table.rows, why)

    @property
    def nothing(self) -> bool:
        """Whether no question about the section has an answer."""
        found = (self.control, self.shapes, self.reach, self.both_ways, self.work)
        return not (self.lines or self.largest or self.sizes or any(found))


@dataclass(frozen=True, kw_only=True)
class LinearControl:
    """The plane through F(p, V), where it holds, and the controller made from it."""

    plane: LinearModel
    plane_error_N: float
    valid: ValidityMap
    gains: Controller
    matrices: StateSpace


Found = TypeVar("Found")


class _Questions:
    """Ask one question after the other; those without an answer take no other along."""

    def __init__(self) -> None:
        self.unanswered: dict[str, str] = {}

    def ask(self, name: str, question: Callable[[], Found]) -> Found | None:
        try:
            return question()
        except ModelError as error:
            self.unanswered[name] = str(error)
            return None


def answer(model: SheetModel, wanted: Wanted) -> DesignAnswers:
    """Ask everything. Raises ModelError when nothing about the section has an answer."""
    _check_section(model, wanted)
    with keeping_maps():
        return _answer(model, wanted)


def _answer(model: SheetModel, wanted: Wanted) -> DesignAnswers:
    place = (model, wanted.configuration, wanted.low_m, wanted.high_m)
    asked = _Questions()
    lines = [
        asked.ask(f"best line at {volts(float(volt))}", partial(best_line, *place, float(volt)))
        for volt in known_voltages(model, wanted.configuration)
    ]
    found = DesignAnswers(
        wanted=wanted,
        lines=tuple(line for line in lines if line is not None),
        control=asked.ask("linear model", lambda: _control(model, wanted)),
        shapes=asked.ask("shapes", lambda: shape_difference(*place)),
        reach=asked.ask("shortest length", lambda: shortest_sheet(*place)),
        largest=asked.ask("largest forces", lambda: largest_forces(*place)) or {},
        both_ways=asked.ask("force in both directions", lambda: force_both_ways(*place)),
        sizes=_sizes(model, wanted, asked),
        elongated=asked.ask("effect of an elongation", lambda: linearity(*place)),
        work=asked.ask("work along the arc", lambda: work_along_arc(*place)),
        unanswered=asked.unanswered,
    )
    if found.nothing:
        raise ModelError(next(iter(asked.unanswered.values())))
    return found


def _check_section(model: SheetModel, wanted: Wanted) -> None:
    sheet = model.sheet(wanted.configuration).sheet
    ends = [sheet.arc_origin_rad + p / sheet.arc_radius_m for p in (wanted.low_m, wanted.high_m)]
    if max(map(abs, ends)) > np.pi:
        raise ModelError(
            f"the section {1e3 * wanted.low_m:g} to {1e3 * wanted.high_m:g} mm goes beyond half the"
            f" circle of the arc, whose radius is {1e3 * sheet.arc_radius_m:g} mm"
        )


def _control(model: SheetModel, wanted: Wanted) -> LinearControl:
    plane, error_N = fit_linear(model, wanted.configuration, wanted.low_m, wanted.high_m)
    return LinearControl(
        plane=plane,
        plane_error_N=error_N,
        valid=validity(model, plane, wanted.low_m, wanted.high_m),
        gains=controller(plane, wanted.mass_kg, wanted.bandwidth_rad_per_s),
        matrices=state_space(plane, wanted.mass_kg, lag_s=wanted.lag_s),
    )


def _sizes(model: SheetModel, wanted: Wanted, asked: _Questions) -> dict[str, Size]:
    if wanted.force_N is None:
        return {}
    found = {}
    for name in (WITHOUT, WITH):
        size = asked.ask(
            name,
            partial(
                least_area,
                model,
                wanted.configuration,
                wanted.low_m,
                wanted.high_m,
                wanted.force_N,
                elongated=name == WITH,
                direction=wanted.direction,
            ),
        )
        if size is not None:
            found[name] = size
    return found


def _said(found: Parameter, factor: float) -> str:
    """Return a value and its standard uncertainty in another unit."""
    return with_sigma(factor * found.value, factor * found.sigma)


def tables(found: DesignAnswers) -> list[Table]:
    """Return the answers as tables, in the order of the paper's list."""
    name = found.wanted.configuration
    result = [_line_table(found, name)] if found.lines else []
    if found.control is not None:
        result.append(_control_table(found.control, found.wanted))
    forces = _force_table(found, name)
    result += [forces] if forces.rows else []
    if found.wanted.force_N is not None:
        result.append(_size_table(found))
    if found.work is not None:
        result.append(_work_table(found.work, found.wanted))
    return result


def _line_table(found: DesignAnswers, name: str) -> Table:
    section = f"{1e3 * found.wanted.low_m:g} to {1e3 * found.wanted.high_m:g} mm"
    rows = tuple(
        (
            signed(line.voltage_V),
            _said(line.slope_N_per_m, 1.0),
            _said(line.at_zero_N, 1e3),
            _said(line.rms_error_N, 1e3),
            f"{100 * line.relative_error:.2f}",
        )
        for line in found.lines
    )
    columns = ("V", "slope mN/mm", "F at 0 mm, mN", "RMS error mN", "of its range %")
    return Table(
        title=f"1. {name}: the best line through F(p), {section}", columns=columns, rows=rows
    )


def _control_table(control: LinearControl, wanted: Wanted) -> Table:
    gains, plane = control.gains, control.plane
    valid = 100 * float(np.mean(control.valid.valid()))
    rows = (
        ("stiffness dF/dp, mN/mm", _said(plane.stiffness_N_per_m, 1.0)),
        ("gain dF/dV, mN/V", _said(plane.gain_N_per_V, 1e3)),
        ("error over section and voltages, RMS, mN", fixed(1e3 * control.plane_error_N, 3)),
        ("part of it where the error is below 5 %, %", f"{valid:.0f}"),
        ("feedforward V = a + b p: a, V", f"{gains.feedforward_V:.4f}"),
        ("feedforward: b, V/mm", f"{gains.feedforward_V_per_m / 1e3:.4f}"),
        ("feedback of the position, V/mm", f"{gains.position_V_per_m / 1e3:.5f}"),
        ("feedback of the speed, V s/mm", f"{gains.speed_Vs_per_m / 1e3:.5f}"),
    )
    title = (
        f"1. Linear model and controller, for {1e3 * wanted.mass_kg:g} g and "
        f"{wanted.bandwidth_rad_per_s / (2 * np.pi):g} Hz"
    )
    return Table(title=title, columns=("", "value"), rows=rows)


def _force_table(found: DesignAnswers, name: str) -> Table:
    rows = [*_shape_rows(found), *_force_rows(found)]
    return Table(
        title=f"2-5. {name}: shapes, reach and forces",
        columns=("", "value", "where"),
        rows=tuple(rows),
    )


def _shape_rows(found: DesignAnswers) -> Iterator[tuple[str, str, str]]:
    shapes, reach = found.shapes, found.reach
    if shapes is not None:
        where = f"at {1e3 * shapes.position_m:.1f} mm, {1e3 * shapes.s_m:.1f} mm along the sheet"
        apart = _said(shapes.distance_m, 1e3)
        yield "2. shapes at opposite EIBMs are apart by, mm", apart, where
    if reach is not None:
        where = f"for {1e3 * reach.position_m:.1f} mm at {volts(reach.voltage_V)}"
        length = _said(reach.length_m, 1e3)
        yield "3. shortest length that reaches everywhere, mm", length, where


def _force_rows(found: DesignAnswers) -> Iterator[tuple[str, str, str]]:
    for direction, force in found.largest.items():
        where = f"at {1e3 * force.position_m:.1f} mm and {volts(force.voltage_V)}"
        yield f"4. largest force, {direction}, mN", _said(force.force_N, 1e3), where
    both = found.both_ways
    if both is not None:
        limit = f"at {1e3 * both.position_m:.1f} mm in the {'+' if both.pushes else '-'} direction"
        possible = both.force_N.value > 0
        value = _said(both.force_N, 1e3) if possible else "none"
        said = f"limited {limit}" if possible else f"no force {limit}"
        yield "5. force in both directions, mN", value, said


def _size_table(found: DesignAnswers) -> Table:
    rows = [
        (
            name,
            f"{1e3 * size.length_m:.2f}",
            _said(size.width_m, 1e3),
            _said(size.area_m2, 1e6),
            f"{1e3 * size.elongation_m:.1f}",
        )
        for name, size in found.sizes.items()
    ]
    lacking = [name for name in (WITHOUT, WITH) if name in found.unanswered]
    rows += [(name, "-", "-", "-", "-") for name in lacking]
    force_mN = 1e3 * (found.wanted.force_N or 0.0)
    title = f"6. The sheet of least area for {force_mN:g} mN ({found.wanted.direction})"
    return Table(
        title=title,
        columns=("", "length mm", "width mm", "area mm²", "elongation mm"),
        rows=tuple(rows),
    )


def _work_table(work: WorkAlongArc, wanted: Wanted) -> Table:
    rows = [
        (f"outward at {volts(v)}, µJ", _said(one, 1e6))
        for v, one in sorted(work.outward_J.items(), reverse=True)
    ]
    low_V, high_V = work.voltages_V
    rows.append(
        (f"out at {volts(high_V)} and back at {volts(low_V)}, µJ", _said(work.cycle_J, 1e6))
    )
    return Table(
        title=f"7. {wanted.configuration}: quasi-static work on the object over the section",
        columns=("", "value"),
        rows=tuple(rows),
    )


def as_dict(found: DesignAnswers, errors: Misfit) -> dict[str, Any]:
    """For `--json`, in SI; null where a question has no answer. `errors`: of the model itself."""
    return {
        "configuration": found.wanted.configuration,
        "section_m": [found.wanted.low_m, found.wanted.high_m],
        "model_errors": {
            "force_rmse_N": errors.force_N,
            "curve_rmse_m": errors.curve_m,
            "misses_its_data": errors.misses,
        },
        "lines": [_line_as_dict(line) for line in found.lines],
        **_control_as_dict(found.control),
        "largest_shape_difference_m": found.shapes and found.shapes.distance_m.to_json(),
        "shortest_length_m": found.reach and found.reach.length_m.to_json(),
        "largest_forces_N": {key: force.force_N.to_json() for key, force in found.largest.items()},
        "force_both_ways_N": found.both_ways and found.both_ways.force_N.to_json(),
        "least_area": {name: _size_as_dict(size) for name, size in found.sizes.items()},
        "work_J": found.work and {str(v): w.to_json() for v, w in found.work.outward_J.items()},
        "work_of_a_cycle_J": found.work and found.work.cycle_J.to_json(),
        "unanswered": found.unanswered,
    }


def _line_as_dict(line: StraightLine) -> dict[str, Any]:
    return {
        "voltage_V": line.voltage_V,
        "slope_N_per_m": line.slope_N_per_m.to_json(),
        "at_zero_N": line.at_zero_N.to_json(),
        "rms_error_N": line.rms_error_N.to_json(),
        "relative_error": line.relative_error,
    }


def _control_as_dict(control: LinearControl | None) -> dict[str, Any]:
    if control is None:
        return {"linear_model": None, "state_space": None, "controller": None}
    return {
        "linear_model": {
            "stiffness_N_per_m": control.plane.stiffness_N_per_m.to_json(),
            "gain_N_per_V": control.plane.gain_N_per_V.to_json(),
            "rms_error_N": control.plane_error_N,
        },
        "state_space": {
            "states": list(control.matrices.states),
            **{key: getattr(control.matrices, key).tolist() for key in "ABCD"},
        },
        "controller": vars(control.gains),
    }


def _size_as_dict(size: Size) -> dict[str, Any]:
    return {
        "length_m": size.length_m,
        "width_m": size.width_m.to_json(),
        "area_m2": size.area_m2.to_json(),
        "elongation_m": size.elongation_m,
    }
