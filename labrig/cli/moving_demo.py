"""The demo's last part: a sheet that moves is recorded, identified and simulated."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.cli.screen import print_table, progress, say
from labrig.files import typed

if TYPE_CHECKING:
    from labrig.analysis.motion.dynamic_fit import DynamicFit
    from labrig.report.figures.motion import MotionComparison

CONFIGURATION, WORLD = "long", "moving.toml"
PROTOCOL = f"""\
# What a sheet in time is identified from: pulses in contact, and a free step and release.
[pulse_train]
zero_readings = 2
pulses_discarded = 0
readings_per_voltage = 2

[[places]]
configuration = "{CONFIGURATION}"
positions_mm = [5]

[extras]
random_order = false
free_shapes = false
reversed_approach = false

[extras.release]
voltages_V = [1.0]
rest_s = 1.0
swing_s = 1.2
"""

# The others take as long as all of these together.
COMPARED = ("bao", "gonzalez", "huynh_alici", "lee", "pugal", "tamagawa", "yagasaki")
NOTE = (
    "In this world each set-up differs from its sheet, as at a rig: by 1 % in stiffness and moment "
    "(standard deviation), by 0.05 mm in position. The intervals are those of its two set-ups."
)


def write_moving_rig(folder: Path) -> tuple[Path, Path, Path]:
    """Write the files of a simulated rig in the moving world: rig, protocol and sheet."""
    from labrig.config.templates import write_templates

    write_templates(folder, simulated=True)
    rig = folder / "rig.toml"
    tables = rig.read_text(encoding="utf-8").partition("[simulated]")[0]
    rig.write_text(f'{tables}[simulated]\nworld = "{WORLD}"\n', encoding="utf-8")
    (folder / "protocol.toml").write_text(PROTOCOL, encoding="utf-8")
    return rig, folder / "protocol.toml", folder / "sheet.toml"


def fit_and_draw(session: Path, folder: Path) -> None:
    """Identify the sheet, print it beside the world's own, and draw a pulse with its model."""
    from labrig.api.fit_in_time import fit_in_time
    from labrig.experiment.rig.stand_ins import true_moving_sheet
    from labrig.model_file import save_model
    from labrig.report.figures.motion import compared, motion_figure
    from labrig.report.parts.style import DEFAULT_FORMATS, save_all

    with progress("read the motion") as advance:
        found = fit_in_time(session, configuration=CONFIGURATION, progress=advance)
    fit = found.configurations[CONFIGURATION]
    truth = true_moving_sheet(folder / WORLD, CONFIGURATION)
    columns = ["parameter", "unit", "fitted", "90 % interval", "in the world"]
    print_table("The long sheet in time", columns, parameter_rows(fit, truth))
    say(NOTE)
    say()
    runs = [compared(fit.found.beam, run) for run in fit.runs]
    held = next(run for run in runs if run.recorded.plan.setup is not None)
    free = next(run for run in runs if run.recorded.plan.setup is None)
    columns = ["run", "force mN", "current mA", "tip mm"]
    title = "Measured less simulated, root mean square, of single samples and frames"
    print_table(title, columns, [_errors(held), _errors(free)])
    save_model(found.model, folder / "model.toml", force=True)
    say(f"wrote {folder / 'model.toml'}")
    for path in save_all(motion_figure(held, free), folder, "motion", DEFAULT_FORMATS):
        say(f"wrote {path}")
    say()
    _compare(fit, session)


def _compare(fit: DynamicFit, session: Path) -> None:
    """Rank some models from the literature beside the sheet that was fitted."""
    from labrig.analysis.comparison import compare_fitted
    from labrig.report.tables.in_time.comparison import dynamic_comparison_table

    table = dynamic_comparison_table(compare_fitted(fit, names=COMPARED))
    print_table(table.title, table.columns, table.rows)
    say(table.note)
    say(
        f"labrig compare {typed(session)} fits all nine models from the literature, "
        "in about a minute."
    )


def parameter_rows(fit: DynamicFit, truth: Mapping[str, float]) -> Iterator[list[str]]:
    """Yield a row for each parameter: what was found, and what the world holds."""
    from labrig.report.tables.in_time.parameters import shown

    for one in fit.found.parameters:
        as_shown = shown(one.name)
        numbers = (one.parameter.value, *one.parameter.interval(), truth[one.name])
        value, low, high, true = (f"{as_shown.scale * x:.4g}" for x in numbers)
        interval = f"{low} to {high}" if one.determined else "not determined"
        yield [as_shown.text, as_shown.unit, value, interval, true]


def _errors(run: MotionComparison) -> list[str]:
    def fixed(value: float, digits: int) -> str:
        return "-" if math.isnan(value) else f"{1e3 * value:.{digits}f}"

    return [
        run.recorded.plan.name,
        fixed(run.force_rms_N, 3),
        fixed(run.current_rms_A, 2),
        fixed(run.tip_rms_m, 3),
    ]
