"""`labrig.compare`: other models fitted to the same session."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from labrig.api.arguments import elongation_kg_per_m
from labrig.api.data import measurements_of, model_of, name_of
from labrig.api.fit import what_can_be_fitted
from labrig.errors import BadArgumentError, BadInputError
from labrig.files import AnyPath, path_of
from labrig.one_blas_thread import one_blas_thread
from labrig.progress import Progress, silent
from model import FitOptions, Measurements
from model.identification.baselines import BaselineRow
from model.measurements import Displayed, Summary, dataframe
from model.measurements.columns import of_rows
from model.measurements.known_arguments import known_arguments
from model.sheet.sheet_model import SheetModel

if TYPE_CHECKING:
    import pandas as pd

    from labrig.analysis.comparison import DynamicComparison


@dataclass(frozen=True, kw_only=True, repr=False)
class ModelComparison(Displayed):
    """Simpler models at rest, and those of others in time, fitted to one session."""

    static: tuple[BaselineRow, ...] = ()  # a row for each model and configuration
    dynamic: tuple[DynamicComparison, ...] = ()  # one for each configuration
    why_no_dynamic: Mapping[str, str] = field(default_factory=dict)  # by configuration

    def summary(self) -> Summary:
        """Return the errors of the models at rest, and the evidence of those in time."""
        from labrig.report.tables.baselines import baseline_table

        table = baseline_table(self.static) if self.static else None
        best = [
            f"in time, {one.configuration}: {one.models[0].title} has the largest evidence"
            for one in self.dynamic
            if one.models
        ]
        return Summary(
            "ModelComparison",
            table.columns if table else (),
            table.rows if table else (),
            (*best, *self.why_no_dynamic.values()),
        )

    def to_dataframe(self) -> pd.DataFrame:
        """Return the models at rest as a pandas data frame, in SI units."""
        from labrig.report.tables.baselines import baselines_as_list

        return dataframe(of_rows(baselines_as_list(self.static)))

    def to_json(self) -> dict[str, Any]:
        """Return the object that `labrig compare --json` prints."""
        from labrig.report.tables.baselines import baselines_as_list

        return {
            "static": baselines_as_list(self.static),
            "dynamic": [asdict(one) for one in self.dynamic],
            "why_no_dynamic": dict(self.why_no_dynamic),
        }


class ProgressSteps(Protocol):
    """Where the progress of a step of the comparison is shown."""

    def __call__(self, title: str) -> AbstractContextManager[Progress]:
        """Begin a step."""


@known_arguments
@one_blas_thread
def compare(
    session: AnyPath,
    *,
    model: AnyPath | SheetModel | None = None,
    static: bool = False,
    dynamic: bool = False,
    elongation_g_per_m: float | None = None,
    progress: Progress | None = None,
) -> ModelComparison:
    """Compare other models with labrig's, each fitted to a session, as `labrig compare` does.

    Args:
        session: a session file. It is analysed where it is not yet, and keeps what is found.
        model: a model (or its file) to compare as it is.
        static: the sheet at rest alone, in seconds.
        dynamic: the sheet in time alone; an error where that cannot be.
        elongation_g_per_m: mass of the rigid elongation per length in g/m, for the sheet in time.
        progress: called with the share of a step that is done (0 to 1) and a text.

    Returns:
        ModelComparison: `static`, `dynamic`, and `why_no_dynamic` where that could not be.

    Raises:
        LabrigError, ModelError: one sentence on what is missing.

    Example:
        >>> labrig.compare("session.h5", static=True)  # doctest: +SKIP

    """
    advance = progress or silent
    return compared(
        path_of(session), lambda _title: nullcontext(advance), model=model, static=static,
        dynamic=dynamic, elongation_g_per_m=elongation_g_per_m,
    )  # fmt: skip


def compared(
    session: Path,
    steps: ProgressSteps,
    *,
    model: AnyPath | SheetModel | None,
    static: bool,
    dynamic: bool,
    elongation_g_per_m: float | None,
    processes: int = 1,
) -> ModelComparison:
    """Compare, and show the progress of each step; `processes` analyse what is not analysed."""
    if static and dynamic:
        raise BadArgumentError("give static or dynamic, or neither for both.", "static", "dynamic")
    elongation = elongation_kg_per_m(elongation_g_per_m)  # before anything is fitted
    # read first: a wrong file is refused before anything is fitted
    given = None if model is None else (model_of(model), name_of(model))
    with steps("analyze") as advance:
        measurements = measurements_of(session, advance, processes=processes)
    rows = () if dynamic else _at_rest(session, measurements, given)
    found, why_not = ([], {}) if static else _in_time(session, elongation, steps)
    if dynamic and not found:
        why = "; ".join(one.rstrip(".") for one in why_not.values())
        said = f"{why}." if why else f"{session}: nothing was driven."
        raise BadArgumentError(said, "elongation_g_per_m")
    return ModelComparison(static=rows, dynamic=tuple(found), why_no_dynamic=why_not)


def _at_rest(
    session: Path, measurements: Measurements, given: tuple[SheetModel, str] | None
) -> tuple[BaselineRow, ...]:
    from model.identification.baselines import compare as compare_models

    fitted = what_can_be_fitted(str(session), measurements, FitOptions())
    options = replace(fitted.options, configurations=tuple(fitted.configurations))
    rows = compare_models(measurements, options, fitted)
    if given is None:
        return rows
    from labrig.report.tables.model_file import model_rows

    names = list(fitted.configurations)
    rows = (*rows, *model_rows(measurements, *given, names))
    return tuple(sorted(rows, key=lambda row: names.index(row.configuration)))


def _in_time(
    session: Path, elongation: float | None, steps: ProgressSteps
) -> tuple[list[DynamicComparison], dict[str, str]]:
    """Return what was compared and kept, and by configuration why not, a sentence each."""
    from labrig.analysis.comparison import compare_in_time, keep_comparisons, why_not_in_time
    from labrig.analysis.motion.beginning import StatedValues
    from labrig.session import open_session, stored_curve_extractor

    stated = StatedValues(elongation_kg_per_m=elongation)
    found: list[DynamicComparison] = []
    why_not: dict[str, str] = {}
    extractor = stored_curve_extractor(session).partition(" ")[0]
    with open_session(session) as recorded:
        names = dict.fromkeys(run.planned.configuration for run in recorded.runs if run.started)
        if not names:
            why_not[""] = "Models in time were not compared: the session holds tables alone."
        for name in names:
            if why := why_not_in_time(recorded, name):
                why_not[name] = f"Models in time were not compared for '{name}': {why}"
                continue
            try:
                with steps("compare in time") as advance:
                    found.append(
                        compare_in_time(
                            recorded, name, stated, progress=advance,
                            **({"extractor": extractor} if extractor else {}),
                        )
                    )  # fmt: skip
            except BadInputError as error:
                why_not[name] = f"Models in time were not compared for '{name}': {error}"
    if found:
        keep_comparisons(session, found)
    return found, why_not
