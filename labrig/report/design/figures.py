"""A figure for each answer about a working section."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from labrig.report.design.answers import DesignAnswers
from labrig.report.parts.style import colour_of, figure, label_of, save
from model import SheetModel, predict
from model.design.force_map import force_map, known_voltages, section


def draw_design(model: SheetModel, found: DesignAnswers, folder: Path) -> list[Path]:
    """Draw all figures of one configuration into `folder`; their paths."""
    name = found.wanted.configuration
    drawings = {
        "forces": draw_forces,
        "shapes": draw_shapes,
        "reach": draw_reach,
        "linear": draw_validity,
        "elongation": draw_elongation,
    }
    if found.sizes:
        drawings["area"] = draw_area
    paths = []
    for key, draw in drawings.items():
        path = folder / f"{name}-{key}.png"
        draw(model, found, path)
        paths.append(path)
    return paths


def draw_forces(model: SheetModel, found: DesignAnswers, path: Path) -> None:
    """F(p) with its best lines, what is possible in both directions, and the normal force."""
    name, p = found.wanted.configuration, section(found.wanted.low_m, found.wanted.high_m)
    volts = known_voltages(model, name)
    forces = force_map(model, name, p, volts)
    with figure(9.0, 3.6) as fig:
        along, across = fig.subplots(1, 2)
        for i, line in enumerate(found.lines):
            colour = colour_of(line.voltage_V)
            label = label_of(line.voltage_V)
            along.plot(1e3 * p, 1e3 * forces.tangential_N[:, i], color=colour, label=label)
            best = line.at_zero_N.value + line.slope_N_per_m.value * p
            along.plot(1e3 * p, 1e3 * best, "--", color=colour, linewidth=0.9)
            across.plot(1e3 * p, 1e3 * forces.normal_N[:, i], color=colour)
        level = 1e3 * found.both_ways.force_N.value
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
    with figure(5.4, 3.2) as fig:
        axes = fig.subplots()
        for volt in found.shapes.voltages_V:
            one = predict(
                model, found.wanted.configuration, found.shapes.position_m, volt, as_seen=False
            )
            axes.plot(1e3 * one.x_m, 1e3 * one.y_m, color=colour_of(volt), label=label_of(volt))
        axes.set(xlabel="x (mm)", ylabel="y (mm)", aspect="equal")
        apart_mm = 1e3 * found.shapes.distance_m.value
        axes.set_title(
            f"{apart_mm:.2f} mm apart at {1e3 * found.shapes.position_m:.1f} mm", loc="left"
        )
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.6), ncols=2)
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
        axes.axhline(1e3 * found.reach.length_m.value, color="#222222", linestyle=":")
        axes.set(xlabel="position p (mm)", ylabel="contact along the sheet (mm)")
        axes.legend()
        save(fig, path)


def draw_validity(model: SheetModel, found: DesignAnswers, path: Path) -> None:  # noqa: ARG001
    """Draw the error of the linear model over position and voltage."""
    valid = found.valid
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
    with figure(5.0, 3.4) as fig:
        axes = fig.subplots()
        axes.plot(
            1e3 * found.elongated.lengths_m,
            100 * found.elongated.relative_error,
            "o-",
            color="#222222",
        )
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
