"""`labrig.diagnose`: what the model is missing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import cast

from labrig.api.arguments import (
    check_options,
    number,
    several,
    texts,
    whole_number,
)
from labrig.api.data import Data, model_of, paths_of, tell, tell_of_stiffness
from labrig.api.tables import GivenTables, Names, data_of
from labrig.errors import BadInputError, LabrigError
from labrig.files import AnyPath
from labrig.model_file import no_model
from labrig.one_blas_thread import one_blas_thread
from labrig.progress import Progress
from model.discrepancy import DiagnoseOptions, Diagnosis, Next
from model.discrepancy.thresholds import MOST_EFFECTS
from model.measurements import (
    Measurements,
    ModelError,
    is_number,
    require_number,
    require_truth,
    require_whole_number,
)
from model.measurements.known_arguments import known_arguments
from model.sheet.sheet_model import SheetModel


@known_arguments
@one_blas_thread
def diagnose(
    sessions: Data | Sequence[AnyPath] | None = None,
    options: DiagnoseOptions | None = None,
    *,
    sheet: AnyPath | None = None,
    forces: AnyPath | None = None,
    curves: AnyPath | None = None,
    signals: AnyPath | None = None,
    columns: Names = (),
    values: Names = (),
    ignore: str | Sequence[str] = (),
    model: AnyPath | SheetModel | None = None,
    hold_out: str | Sequence[str] = (),
    symmetric: bool = False,
    without: str | Sequence[str] = (),
    calibrate: int = 0,
    most_effects: int | None = None,
    stiffness_Nm2: float | None = None,
    keep: bool = True,
    progress: Progress | None = None,
) -> Diagnosis:
    """Find which effects are not in the model, as `labrig diagnose` does. It takes a minute or so.

    Args:
        sessions: a session file, several of the same sheet, or `Measurements`.
        options: all options of the diagnosis at once, in place of the arguments below that they
            hold: `model`, `hold_out`, `symmetric`, `without`, `calibrate`, `most_effects`,
            `stiffness_Nm2`.
        sheet: sheet.toml, with the CSV tables below in place of sessions.
        forces: forces.csv.
        curves: curves.csv.
        signals: signals.csv.
        columns: which column of the tables is which of labrig's, such as {"force_mN": "F"};
            several names for one, {"voltage_V": ["U", "Spannung"]}: the first that a table has.
        values: a value that no column has, such as {"configuration": "long"}.
        ignore: columns of the tables to leave out, such as "Nr".
        model: a model (or its file) whose effects are known.
        hold_out: positions to leave out, such as "position=25" (mm).
        symmetric: one |EIBM| for both polarities; asymmetry is then a finding.
        without: names of effects that are known to be absent; `labrig effects` lists them.
        calibrate: number of simulated sessions for the threshold of evidence; 0: the usual one.
        most_effects: number of names to look for, 3 by default; more may take minutes.
        stiffness_Nm2: B in N m² of sheets of which no force was measured.
        keep: store the diagnosis in the (first) session file, where its report shows it.
        progress: called with the share done (0 to 1) and a text.

    Returns:
        Diagnosis: `verdict`, `sentence`, `effects` with parameters in SI units but where a name
        has another one, `base` (B and EIBMs, SI), `unknown`, `notes`, `ranking`, and `model`, the
        sheet's model as `labrig diagnose -o` writes it: with what was found, with an effect that
        these data do not tell from it, or without, as `notes` say. `fitted` and `held_out` have
        the errors before and after, in mN and mm; `held_out` is of positions left out in turn.

    Raises:
        LabrigError, ModelError: one sentence that names the missing data or the wrong argument.

    Example:
        >>> found = labrig.diagnose("session.h5")  # doctest: +SKIP
        >>> found.verdict, [one.name for one in found.effects]  # doctest: +SKIP
        ('effect_named', ['nonuniform_eibm'])

    """
    if options is not None:
        check_options(
            options, DiagnoseOptions, "labrig.DiagnoseOptions",
            model=model is not None, hold_out=bool(several(hold_out)), symmetric=symmetric,
            without=bool(several(without)), calibrate=calibrate != 0,
            most_effects=most_effects is not None, stiffness_Nm2=stiffness_Nm2 is not None,
        )  # fmt: skip
    _require_effects(without if options is None else options.exclude)
    tables = GivenTables(
        sheet=sheet,
        forces=forces,
        curves=curves,
        signals=signals,
        columns=columns,
        values=values,
        ignore=ignore,
    )
    measurements = data_of(sessions, tables, progress)
    paths = [] if sessions is None else paths_of(sessions)
    if options is None:
        options = options_for(
            measurements, paths, model=model, hold_out=hold_out, symmetric=symmetric,
            without=without, calibrate=calibrate, most_effects=most_effects,
            stiffness_Nm2=stiffness_Nm2,
        )  # fmt: skip
    else:
        options = _completed(options, measurements, paths)
    return diagnosed_and_kept(measurements, paths if keep else [], options, progress)


def options_for(
    measurements: Measurements,
    sessions: Sequence[Path],
    *,
    model: AnyPath | SheetModel | None,
    hold_out: str | Sequence[str],
    symmetric: bool,
    without: str | Sequence[str],
    calibrate: int,
    most_effects: int | None,
    stiffness_Nm2: float | None,
) -> DiagnoseOptions:
    """Return the options of a diagnosis; the arguments are those of `diagnose`."""
    from labrig.analysis.holding_out import held_out

    _require_effects(without)
    if most_effects is not None:
        most_effects = whole_number("most_effects", most_effects, at_least=1, at_most=10)
    if stiffness_Nm2 is not None:
        stiffness_Nm2 = number("stiffness_Nm2", stiffness_Nm2, above=0.0)
    given = DiagnoseOptions(
        symmetric=symmetric, calibrate=whole_number("calibrate", calibrate, at_least=0),
        model=None if model is None else model_of(model), exclude=tuple(several(without)),
        hold_out=held_out(texts(hold_out), measurements), stiffness_Nm2=stiffness_Nm2,
        most_effects=MOST_EFFECTS if most_effects is None else most_effects,
    )  # fmt: skip
    return _completed(given, measurements, sessions)


def _completed(
    options: DiagnoseOptions, measurements: Measurements, sessions: Sequence[Path]
) -> DiagnoseOptions:
    """Return options with the promises that the sessions kept; tell what is not used."""
    _require_values(options)
    tell_of_stiffness(measurements, options.stiffness_Nm2)
    return replace(options, promised=options.promised or promises_kept_in(sessions))


def _require_values(options: DiagnoseOptions) -> None:
    """Raise ModelError for values of options that mean nothing, before anything takes minutes."""
    require_truth("symmetric", options.symmetric)
    require_whole_number("calibrate", options.calibrate, at_least=0)
    require_whole_number("seed", options.seed, at_least=0)
    require_whole_number("most_effects", options.most_effects, at_least=1)
    if options.stiffness_Nm2 is not None:
        require_number("stiffness_Nm2", options.stiffness_Nm2, above=0.0)
    if options.model is not None and not isinstance(options.model, SheetModel):
        raise no_model(options.model, "options: model: what labrig.load_model returns")
    names, places = cast("object", options.exclude), cast("object", options.hold_out)
    if not isinstance(names, tuple | list):
        raise ModelError(f"exclude {names!r}: a tuple of names is needed")
    if not isinstance(places, tuple | list) or not all(_is_place(one) for one in places):
        raise ModelError(
            f'hold_out {places!r}: a tuple of places is needed, such as (("long", 0.025),)'
        )


def _is_place(one: object) -> bool:
    return (
        isinstance(one, tuple | list)
        and len(one) == 2
        and isinstance(one[0], str)
        and is_number(one[1])
    )


def diagnosed_and_kept(
    measurements: Measurements,
    sessions: Sequence[Path],
    options: DiagnoseOptions,
    progress: Progress | None,
) -> Diagnosis:
    """Diagnose, add the protocol of the next measurement, and store it in the first session."""
    from labrig.experiment.next_measurement.next_protocol import with_protocol

    first = sessions[0] if sessions else None
    found = with_protocol(diagnosed(measurements, options, progress), measurements, first)
    if first is not None:
        keep_in(first, found)
    return found


def _require_effects(names: str | Sequence[str]) -> None:
    """Raise ModelError for an unknown effect, before anything that takes minutes."""
    from model.effects import effect

    for name in several(names):
        effect(name)


def diagnosed(
    measurements: Measurements, options: DiagnoseOptions, progress: Progress | None
) -> Diagnosis:
    """Diagnose measurements; raise BadInputError where nothing was driven."""
    from labrig.analysis.driven import require_driven
    from model.discrepancy import diagnose as search

    require_driven(measurements)
    return search(measurements, options, progress)


def promises_kept_in(sessions: Sequence[Path]) -> tuple[Next, ...]:
    """Return the proposals kept in the first session that the further ones have measured."""
    from labrig.experiment.next_measurement.promises import promised
    from labrig.report.data.kept_diagnosis import kept_diagnosis

    if len(sessions) < 2:
        return ()
    try:
        return promised(kept_diagnosis(sessions[0]), list(sessions))
    except BadInputError as error:
        tell(f"promises of earlier proposals are not compared: {error}")
        return ()


def keep_in(session: Path, found: Diagnosis) -> None:
    """Store a diagnosis in the session; tell where the session cannot be written."""
    from labrig.report.data.kept_diagnosis import keep_diagnosis

    try:
        keep_diagnosis(session, found)
    except LabrigError as error:
        tell(f"the diagnosis is not stored in the session: {error}")
