"""The questions of the paper's section 5, asked of a model: every answer with its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from labrig.report.parts.table import Table, with_sigma
from model import ModelError, Parameter, SheetModel
from model.design.force_map import known_voltages
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
from model.design.sizing import Direction, Linearity, Size, least_area, linearity
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


@dataclass(frozen=True, kw_only=True)
class DesignAnswers:
    """One configuration's answers; what cannot be answered is in `unanswered`, with the reason."""

    wanted: Wanted
    lines: tuple[StraightLine, ...]
    plane: LinearModel
    plane_error_N: float
    valid: ValidityMap
    gains: Controller
    matrices: StateSpace
    shapes: ShapeDifference
    reach: Reach
    largest: dict[str, LargestForce]
    both_ways: BothWays
    sizes: dict[str, Size]  # without, with elongation
    elongated: Linearity
    unanswered: dict[str, str]


def answer(model: SheetModel, wanted: Wanted) -> DesignAnswers:
    """Ask everything. Raises ModelError when the section itself is out of reach."""
    place = (model, wanted.configuration, wanted.low_m, wanted.high_m)
    volts = known_voltages(model, wanted.configuration)
    plane, plane_error_N = fit_linear(*place)
    sizes, unanswered = _sizes(model, wanted)
    return DesignAnswers(
        wanted=wanted,
        lines=tuple(best_line(*place, float(volt)) for volt in volts),
        plane=plane,
        plane_error_N=plane_error_N,
        valid=validity(model, plane, wanted.low_m, wanted.high_m),
        gains=controller(plane, wanted.mass_kg, wanted.bandwidth_rad_per_s),
        matrices=state_space(plane, wanted.mass_kg, lag_s=wanted.lag_s),
        shapes=shape_difference(*place),
        reach=shortest_sheet(*place),
        largest=largest_forces(*place),
        both_ways=force_both_ways(*place),
        sizes=sizes,
        elongated=linearity(*place),
        unanswered=unanswered,
    )


def _sizes(model: SheetModel, wanted: Wanted) -> tuple[dict[str, Size], dict[str, str]]:
    if wanted.force_N is None:
        return {}, {}
    sizes: dict[str, Size] = {}
    unanswered: dict[str, str] = {}
    for name, elongated in (("without elongation", False), ("with elongation", True)):
        try:
            sizes[name] = least_area(
                model,
                wanted.configuration,
                wanted.low_m,
                wanted.high_m,
                wanted.force_N,
                elongated,
                wanted.direction,
            )
        except ModelError as error:
            unanswered[name] = str(error)
    return sizes, unanswered


def _said(found: Parameter, factor: float) -> str:
    """Return a value and its standard uncertainty in another unit."""
    return with_sigma(factor * found.value, factor * found.sigma)


def tables(found: DesignAnswers) -> list[Table]:
    """Return the answers as tables, in the order of the paper's list."""
    name = found.wanted.configuration
    result = [_line_table(found, name), _control_table(found), _force_table(found, name)]
    if found.sizes or found.unanswered:
        result.append(_size_table(found))
    return result


def _line_table(found: DesignAnswers, name: str) -> Table:
    section = f"{1e3 * found.wanted.low_m:g} to {1e3 * found.wanted.high_m:g} mm"
    rows = tuple(
        (
            f"{line.voltage_V:+g}" if line.voltage_V else "0",
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


def _control_table(found: DesignAnswers) -> Table:
    gains, plane, wanted = found.gains, found.plane, found.wanted
    valid = 100 * float(np.mean(found.valid.valid()))
    rows = (
        ("stiffness dF/dp, mN/mm", _said(plane.stiffness_N_per_m, 1.0)),
        ("gain dF/dV, mN/V", _said(plane.gain_N_per_V, 1e3)),
        ("error over section and voltages, RMS, mN", f"{1e3 * found.plane_error_N:.3f}"),
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
    shapes, reach, both = found.shapes, found.reach, found.both_ways
    rows = [
        (
            "2. shapes at opposite EIBMs are apart by, mm",
            _said(shapes.distance_m, 1e3),
            f"at {1e3 * shapes.position_m:.1f} mm, {1e3 * shapes.s_m:.1f} mm along the sheet",
        ),
        (
            "3. shortest length that reaches everywhere, mm",
            _said(reach.length_m, 1e3),
            f"for {1e3 * reach.position_m:.1f} mm at {reach.voltage_V:+g} V",
        ),
    ]
    for direction, force in found.largest.items():
        where = f"at {1e3 * force.position_m:.1f} mm and {force.voltage_V:+g} V"
        rows.append((f"4. largest force, {direction}, mN", _said(force.force_N, 1e3), where))
    limit = f"at {1e3 * both.position_m:.1f} mm in the {'+' if both.pushes else '-'} direction"
    possible = both.force_N.value > 0
    value = _said(both.force_N, 1e3) if possible else "none"
    said = f"limited {limit}" if possible else f"no force {limit}"
    rows.append(("5. force in both directions, mN", value, said))
    return Table(
        title=f"2-5. {name}: shapes, reach and forces",
        columns=("", "value", "where"),
        rows=tuple(rows),
    )


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
    rows += [(name, "-", "-", "-", why) for name, why in found.unanswered.items()]
    force_mN = 1e3 * (found.wanted.force_N or 0.0)
    title = f"6. The sheet of least area for {force_mN:g} mN ({found.wanted.direction})"
    return Table(
        title=title,
        columns=("", "length mm", "width mm", "area mm²", "elongation mm"),
        rows=tuple(rows),
    )


def as_dict(found: DesignAnswers) -> dict[str, Any]:
    """For `--json`, in SI."""
    return {
        "configuration": found.wanted.configuration,
        "section_m": [found.wanted.low_m, found.wanted.high_m],
        "lines": [
            {
                "voltage_V": line.voltage_V,
                "slope_N_per_m": line.slope_N_per_m.to_json(),
                "at_zero_N": line.at_zero_N.to_json(),
                "rms_error_N": line.rms_error_N.to_json(),
                "relative_error": line.relative_error,
            }
            for line in found.lines
        ],
        "linear_model": {
            "stiffness_N_per_m": found.plane.stiffness_N_per_m.to_json(),
            "gain_N_per_V": found.plane.gain_N_per_V.to_json(),
            "rms_error_N": found.plane_error_N,
        },
        "state_space": {
            "states": list(found.matrices.states),
            **{key: getattr(found.matrices, key).tolist() for key in "ABCD"},
        },
        "controller": vars(found.gains),
        "largest_shape_difference_m": found.shapes.distance_m.to_json(),
        "shortest_length_m": found.reach.length_m.to_json(),
        "largest_forces_N": {key: force.force_N.to_json() for key, force in found.largest.items()},
        "force_both_ways_N": found.both_ways.force_N.to_json(),
        "least_area": {
            name: {
                "length_m": size.length_m,
                "width_m": size.width_m.to_json(),
                "area_m2": size.area_m2.to_json(),
                "elongation_m": size.elongation_m,
            }
            for name, size in found.sizes.items()
        },
        "unanswered": found.unanswered,
    }
