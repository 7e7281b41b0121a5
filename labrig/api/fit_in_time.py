"""`labrig.fit_in_time`: mass, loss, electrodes and stiffness of a sheet, from its motion."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from labrig.analysis.motion.dynamic_fit import DynamicFit, model_of
from labrig.api.data import tell
from labrig.api.motion_data import checksum_of, fits_of, request_of
from labrig.files import AnyPath
from labrig.one_blas_thread import one_blas_thread
from labrig.progress import Progress
from model import SheetModel
from model.measurements import Displayed, Summary, dataframe
from model.measurements.columns import of_rows
from model.measurements.known_arguments import known_arguments

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, kw_only=True, repr=False)
class FitInTime(Displayed):
    """The sheets in time, and the model that a file holds."""

    configurations: Mapping[str, DynamicFit]  # `found.parameters`, `noise`, `runs` of each
    model: SheetModel

    def summary(self) -> Summary:
        """Return the parameters as `labrig fit --dynamic` prints them."""
        from labrig.report.tables.in_time.parameters import dynamic_table

        tables = {name: dynamic_table(fit) for name, fit in self.configurations.items()}
        columns = ("sheet", *next(iter(tables.values())).columns[:4], "determined by")
        rows = [(name, *row[:4], row[-1]) for name, one in tables.items() for row in one.rows]
        rough = [name for name, fit in self.configurations.items() if not fit.found.converged]
        notes = [f"{name}: the search did not end; its intervals are rough" for name in rough]
        return Summary("FitInTime", columns, rows, tuple(notes))

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each parameter as a pandas data frame, in SI units."""
        return dataframe(of_rows([
            {"configuration": name, "parameter": one.name, "unit": one.parameter.unit,
             "value": one.parameter.value, "sigma": one.parameter.sigma,
             "low90": one.parameter.interval()[0], "high90": one.parameter.interval()[1],
             "determined": one.determined}
            for name, fit in self.configurations.items() for one in fit.found.parameters
        ]))  # fmt: skip

    def to_json(self) -> dict[str, Any]:
        """Return the object that `labrig fit --dynamic --json` prints."""
        from labrig.report.tables.in_time.parameters import dynamic_json

        return dynamic_json(list(self.configurations.values()))


@known_arguments
@one_blas_thread
def fit_in_time(
    sessions: AnyPath | Sequence[AnyPath],
    *,
    configuration: str | Sequence[str] = (),
    position_mm: float | Sequence[float] = (),
    fluid: str = "air",
    elongation_g_per_m: float | None = None,
    progress: Progress | None = None,
) -> FitInTime:
    """Identify the sheet in time, as `labrig fit --dynamic` does. It takes seconds per position.

    Args:
        sessions: a session file, or several of the same sheet.
        configuration: fit these sheets alone; default: all that moved.
        position_mm: use the pulses at these positions alone, in mm; default: three of them.
        fluid: what the sheet moves in: "air", "water" or "vacuum".
        elongation_g_per_m: mass of the rigid elongation per length, in g/m.
        progress: called with the share done (0 to 1) and a text.

    Returns:
        FitInTime: `configurations` (each a fit with `found.parameters`, 90 % intervals, and which
        of them these data determine) and `model`, which `labrig.save_model` writes.

    Raises:
        LabrigError, ModelError: one sentence that names the missing data or the wrong argument.

    What was not recorded, and positions that are left out, are named in a `LabrigWarning`.

    Example:
        >>> found = labrig.fit_in_time("session.h5", position_mm=5)  # doctest: +SKIP
        >>> found.configurations["long"].found["B"].parameter.value  # N m²  # doctest: +SKIP
        1.25e-06

    """
    request = request_of(sessions, configuration, position_mm, fluid, elongation_g_per_m)
    fits = fits_of(request, progress)
    for fit in fits:
        for doubt in doubts(fit):
            tell(f"{fit.sheet.configuration}: {doubt}")
    return FitInTime(
        configurations={fit.sheet.configuration: fit for fit in fits},
        model=model_of(fits, checksum_of(request)),
    )


def doubts(fit: DynamicFit) -> Iterator[str]:
    """Yield why a fit is not to be trusted."""
    found = fit.found
    if not found.converged:
        yield "the search did not end; take its intervals as rough."
    if found.misses_data:
        yield (
            f"the fitted sheet leaves {found.chi2 / found.count:.1f} times the squares that the"
            " noise explains; do not trust its parameters (labrig compare shows which quantity it"
            " misses)."
        )
    if fit.misses_curves:
        yield f"{fit.off_the_curves}, more than images explain; do not trust its mass and loss."
