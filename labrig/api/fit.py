"""`labrig.fit`: the model's parameters from sessions or measurements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from labrig.api.arguments import (
    check_options,
    number,
    several,
    texts,
    whole_number,
)
from labrig.api.data import Data, measurements_of, paths_of, tell, tell_of_stiffness
from labrig.errors import BadArgumentError, BadInputError
from labrig.files import AnyPath
from labrig.one_blas_thread import one_blas_thread
from labrig.progress import Progress, silent
from model import Fit, FitOptions, Measurements
from model.measurements.known_arguments import known_arguments

if TYPE_CHECKING:
    from labrig.report.tables.mountings import Run

FEWEST_REPEATS = 20  # with fewer a standard deviation says little
MOST_REPEATS = 10_000
USUAL_EXPONENT = 1.0  # q of (7)


@dataclass(frozen=True, kw_only=True)
class FittedData:
    """A fit with the data that it was made of."""

    measurements: Measurements
    fit: Fit
    runs: dict[Run, str] = field(default_factory=dict)  # which of several sessions each is from


@known_arguments
@one_blas_thread
def fit(
    sessions: Data | Sequence[AnyPath],
    options: FitOptions | None = None,
    *,
    configuration: str | Sequence[str] = (),
    hold_out: str | Sequence[str] = (),
    apart: bool = False,
    symmetric: bool = False,
    measured_curvature: bool = False,
    bootstrap: int = 0,
    q: float = USUAL_EXPONENT,
    stiffness_Nm2: float | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Identify bending stiffness B and EIBM of sheets, as `labrig fit` does.

    Args:
        sessions: a session file, several of the same sheet, or `Measurements`. A session that is
            not analysed yet is analysed now, and keeps the result; `analyze` does that by several
            processes.
        options: all options of the fit at once, in place of the arguments below that they hold
            (all but `apart` and `progress`).
        configuration: fit these sheets alone; default: all that were measured.
        hold_out: positions to leave out, such as "position=25" or
            "configuration=long,position=25" (mm).
        apart: give each session B and EIBM of its own; the sheets are named `long@FILE`.
        symmetric: one |EIBM| for both polarities.
        measured_curvature: initial curvature from the curves at 0 V, whatever sheet.toml states.
        bootstrap: number of simulated repeats that check the uncertainties; 0, or 20 to 10000.
        q: weight exponent of equation (7), for the paper's own way that is reported with the fit.
        stiffness_Nm2: B in N m² of sheets of which no force was measured.
        progress: called with the share done (0 to 1) and a text, while a session is analysed.

    Returns:
        Fit: parameters with uncertainty (`configurations`), the models (`model`: constant EIBM,
        `varying_model`: along the sheet, `preferred_model`), errors (`rmse`) and residuals.

    Raises:
        LabrigError, ModelError: one sentence that names the missing data or the wrong argument.

    A sheet that cannot be fitted is left out, with a `LabrigWarning` that says why.

    Example:
        >>> found = labrig.fit("session.h5", configuration="long")  # doctest: +SKIP
        >>> found.configurations["long"].B.value  # N m²  # doctest: +SKIP
        1.27e-06

    """
    return fitted_data(
        sessions, options, configuration=configuration, hold_out=hold_out, apart=apart,
        symmetric=symmetric, measured_curvature=measured_curvature, bootstrap=bootstrap, q=q,
        stiffness_Nm2=stiffness_Nm2, progress=progress,
    ).fit  # fmt: skip


def fitted_data(
    sessions: Data | Sequence[AnyPath],
    options: FitOptions | None = None,
    *,
    configuration: str | Sequence[str] = (),
    hold_out: str | Sequence[str] = (),
    apart: bool = False,
    symmetric: bool = False,
    measured_curvature: bool = False,
    bootstrap: int = 0,
    q: float = USUAL_EXPONENT,
    stiffness_Nm2: float | None = None,
    progress: Progress | None = None,
    processes: int = 1,
) -> FittedData:
    """Fit as `fit` does, and return the data with it.

    `processes`: how many analyse a session that is not analysed yet.
    """
    from labrig.analysis.holding_out import held_out
    from labrig.report.data.separate_sessions import only

    if options is not None:
        check_options(
            options, FitOptions, "labrig.FitOptions",
            configuration=bool(several(configuration)), hold_out=bool(several(hold_out)),
            symmetric=symmetric, measured_curvature=measured_curvature, bootstrap=bootstrap != 0,
            q=q != USUAL_EXPONENT, stiffness_Nm2=stiffness_Nm2 is not None,
        )  # fmt: skip
    bootstrap = whole_number("bootstrap", bootstrap, at_least=0, at_most=MOST_REPEATS)
    if 0 < bootstrap < FEWEST_REPEATS:
        raise BadArgumentError(
            f"bootstrap {bootstrap}: give at least {FEWEST_REPEATS}, or 0.", "bootstrap"
        )
    number("q", q)
    if stiffness_Nm2 is not None:
        stiffness_Nm2 = number("stiffness_Nm2", stiffness_Nm2, above=0.0)
    chosen = options or FitOptions(
        weight_exponent=q, symmetric=symmetric, measured_curvature=measured_curvature,
        bootstrap=bootstrap, stiffness_Nm2=stiffness_Nm2,
    )  # fmt: skip
    whole, runs = _measured(sessions, apart, progress, processes)
    measurements = only(whole, several(configuration))
    if hold_out:
        chosen = replace(chosen, held_out=held_out(texts(hold_out), measurements))
    _require_measured(chosen, measurements)
    tell_of_stiffness(measurements, chosen.stiffness_Nm2)
    source = ", ".join(map(str, paths_of(sessions))) or measurements.source or "the measurements"
    return FittedData(
        measurements=measurements, fit=what_can_be_fitted(source, measurements, chosen), runs=runs
    )


def what_can_be_fitted(source: str, measurements: Measurements, options: FitOptions) -> Fit:
    """Fit all configurations that allow it; tell of the others with the reason."""
    from labrig.report.data.fitted import fit_what_can_be

    fitted = fit_what_can_be(measurements, options)
    lacking = {name: why.rstrip(".") for name, why in fitted.missing.items()}
    if fitted.fit is None:
        why = "; ".join(dict.fromkeys(lacking.values())) or "nothing was measured"
        raise BadInputError(f"{source}: no configuration can be fitted: {why}.")
    for name, why in lacking.items():
        tell(f"{name}: could not be fitted: {why}.")
    return fitted.fit


def _measured(
    sessions: Data | Sequence[AnyPath], apart: bool, progress: Progress | None, processes: int
) -> tuple[Measurements, dict[Run, str]]:
    """Return the measurements, and which of several sessions each run is from."""
    from labrig.analysis.distinct import check_distinct
    from labrig.analysis.together import together
    from labrig.plausibility import field_warnings
    from labrig.report.data.findings import measured
    from labrig.report.data.separate_sessions import apart as taken_apart
    from labrig.report.data.separate_sessions import labels
    from labrig.report.tables.mountings import sessions_of_runs

    paths = paths_of(sessions)
    if apart and len(paths) < 2:
        raise BadArgumentError("apart: give several sessions to be kept apart.", "apart")
    if not paths:
        given = measurements_of(sessions, progress, processes=processes)
        if not given.source:  # no file: nobody has looked at the units yet
            for sentence in field_warnings(given):
                tell(sentence)
        return given, {}
    check_distinct(paths)
    names = labels(paths)
    advance = progress or silent
    parts = [measured(path, advance, tell, processes=processes) for path in paths]
    if apart:
        return taken_apart(parts, names), {}
    whole = together(list(zip(paths, parts, strict=True)))
    return whole, sessions_of_runs(whole, parts, names) if len(parts) > 1 else {}


def _require_measured(options: FitOptions, measurements: Measurements) -> None:
    """Raise BadArgumentError for what is to be fitted, or held out, and was not measured."""
    from model.identification.options import is_held_out

    known = list(dict.fromkeys(c.configuration for c in measurements.conditions))
    for name in options.configurations or ():
        if name not in known:
            raise BadArgumentError(
                f"options: configurations: nothing was measured of {name!r}; measured were "
                f"{', '.join(known) or 'none'}.",
                "options",
            )
    for held in options.held_out:
        if not any(is_held_out(c, held) for c in measurements.conditions):
            places = {
                c.position_m
                for c in measurements.conditions
                if c.position_m is not None and held[0] in ("", c.configuration)
            }
            have = ", ".join(f"{place:g}" for place in sorted(places)) or "none"
            of = f" of {held[0]!r}" if held[0] else ""
            raise BadArgumentError(
                f"options: held_out {held}: nothing was measured there; the positions{of} are "
                f"{have} m.",
                "options",
            )
