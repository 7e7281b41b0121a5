"""A figure for each answer about a working section."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from labrig.report.design.answers import DesignAnswers
from labrig.report.parts.style import colour_of, figure, label_of, legend_below, save
from model import SheetModel, predict
from model.design.force_map import force_map, known_voltages, section

if TYPE_CHECKING:
    from matplotlib.artist import Artist


def draw_design(model: SheetModel, found: DesignAnswers, folder: Path) -> list[Path]:
    """Draw the figure of each answer of one configuration into `folder`; their paths."""
    name = found.wanted.configuration
    drawings: dict[str, tuple[object, Callable[[SheetModel, DesignAnswers, Path], None]]] = {
        "forces": (found.lines, draw_forces),
        "shapes": (found.shapes, draw_shapes),
        "reach": (found.reach, draw_reach),
        "linear": (found.control, draw_validity),
        "elongation": (found.elongated, draw_elongation),
        "area": (found.sizes, draw_area),
    }
    paths = []
    for key, (answered, draw) in drawings.items():
        if not answered:
            continue
        path = folder / f"{name}-{key}.png"
        draw(model, found, path)
        paths.append(path)
    return paths


Found = TypeVar("Found")


def answered(found: Found | None) -> Found:
    """Return an answer that is drawn only where there is one."""
    assert found is not None  # noqa: S101 - for the type checker
    return found


def draw_forces(model: SheetModel, found: DesignAnswers, path: Path) -> None:
    """F(p) with its best lines, what is possible in both directions, and the normal force."""
    name, p = found.wanted.configuration, section(found.wanted.low_m, found.wanted.high_m)
    volts = known_voltages(model, name)
    forces = force_map(model, name, p, volts)
    with figure(9.0, 3.6) as fig:
        along, across = fig.subplots(1, 2)
        for line in found.lines:
            i = int(np.flatnonzero(volts == line.voltage_V)[0])
            colour = colour_of(line.voltage_V)
            label = label_of(line.voltage_V)
            along.plot(1e3 * p, 1e3 * forces.tangential_N[:, i], color=colour, label=label)
            best = line.at_zero_N.value + line.slope_N_per_m.value * p
            along.plot(1e3 * p, 1e3 * best, "--", color=colour, linewidth=0.9)
            across.plot(1e3 * p, 1e3 * forces.normal_N[:, i], color=colour)
        level = 1e3 * found.both_ways.force_N.value if found.both_ways else 0.0
        if level > 0:
            along.axhspan(-level, level, color="#999999", alpha=0.18)
        along.set(xlabel="position p (mm)", ylabel="F along the tangent (mN)")
        along.set_title(f"(a) {name}: F(p), best lines dashed, both ways shaded", loc="left")
        along.legend(ncols=3, loc="best")
        across.set(xlabel="position p (mm)", ylabel="force along the normal (mN)")
        across.set_title("(b) normal force", loc="left")
        save(fig, path)


def draw_shapes(model: SheetModel, found: DesignAnswers, path: Path) -> None:
    """Draw the shapes at opposite EIBMs where they are farthest apart."""
    shapes = answered(found.shapes)
    with figure(5.4, 3.2) as fig:
        axes = fig.subplots()
        lines: list[Artist] = []
        for volt in shapes.voltages_V:
            one = predict(model, found.wanted.configuration, shapes.position_m, volt, as_seen=False)
            lines += axes.plot(
                1e3 * one.x_m, 1e3 * one.y_m, color=colour_of(volt), label=label_of(volt)
            )
        axes.set(xlabel="x (mm)", ylabel="y (mm)", aspect="equal")
        apart_mm = 1e3 * shapes.distance_m.value
        axes.set_title(f"{apart_mm:.2f} mm apart at {1e3 * shapes.position_m:.1f} mm", loc="left")
        legend_below(fig, lines)
        save(fig, path)


def draw_reach(model: SheetModel, found: DesignAnswers, path: Path) -> None:
    """Where along the sheet the object is touched."""
    name, p = found.wanted.configuration, section(found.wanted.low_m, found.wanted.high_m)
    volts = known_voltages(model, name)
    forces = force_map(model, name, p, volts)
    with figure(5.0, 3.4) as fig:
        axes = fig.subplots()
        for i, volt in enumerate(volts):
            axes.plot(
                1e3 * p, 1e3 * forces.s_hat_m[:, i], color=colour_of(volt), label=label_of(volt)
            )
        axes.axhline(1e3 * answered(found.reach).length_m.value, color="#222222", linestyle=":")
        axes.set(xlabel="position p (mm)", ylabel="contact along the sheet (mm)")
        axes.legend()
        save(fig, path)


def draw_validity(model: SheetModel, found: DesignAnswers, path: Path) -> None:  # noqa: ARG001
    """Draw the error of the linear model over position and voltage."""
    valid = answered(found.control).valid
    size = 1e3 * float(np.nanmax(np.abs(valid.error_N)))
    with figure(5.4, 3.6) as fig:
        axes = fig.subplots()
        drawn = axes.pcolormesh(
            1e3 * valid.position_m,
            valid.voltage_V,
            1e3 * valid.error_N.T,
            cmap="RdBu_r",
            vmin=-size,
            vmax=size,
            shading="gouraud",
        )
        axes.contour(
            1e3 * valid.position_m, valid.voltage_V, valid.valid().T, [0.5], colors="#222222"
        )
        fig.colorbar(drawn, label="linear less full model (mN)")
        axes.set(xlabel="position p (mm)", ylabel="voltage (V)")
        axes.set_title("within the line: below 5 % of the range", loc="left")
        axes.grid(visible=False)
        save(fig, path)


def draw_elongation(model: SheetModel, found: DesignAnswers, path: Path) -> None:  # noqa: ARG001
    """How straight F(p) is, against how much of the reach is sheet."""
    elongated = answered(found.elongated)
    with figure(5.0, 3.4) as fig:
        axes = fig.subplots()
        lengths_mm, error_percent = 1e3 * elongated.lengths_m, 100 * elongated.relative_error
        axes.plot(lengths_mm, error_percent, "o-", color="#222222")
        axes.set(
            xlabel="length of the sheet, the rest is elongation (mm)",
            ylabel="error of the best line (% of the range)",
            ylim=(0, None),
        )
        save(fig, path)


def draw_area(model: SheetModel, found: DesignAnswers, path: Path) -> None:  # noqa: ARG001
    """Area that is needed, against the sheet's length."""
    with figure(5.0, 3.4) as fig:
        axes = fig.subplots()
        for (name, size), style in zip(found.sizes.items(), ("-", "--"), strict=False):
            possible = np.isfinite(size.areas_m2)
            axes.plot(
                1e3 * size.lengths_m[possible], 1e6 * size.areas_m2[possible], style, label=name
            )
            axes.plot(1e3 * size.length_m, 1e6 * size.area_m2.value, "o", color="#222222")
        axes.set(xlabel="length of the sheet (mm)", ylabel="area (mm²)", ylim=(0, None))
        axes.legend()
        save(fig, path)
