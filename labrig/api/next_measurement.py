"""`labrig.next_measurement`: the measurement that tells two effects apart, with its protocol."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from labrig.api.arguments import several, shown
from labrig.api.data import Data, model_of, paths_of, tell
from labrig.api.diagnose import diagnosed, keep_in
from labrig.api.tables import GivenTables, Names, data_of
from labrig.config.base import parse_toml
from labrig.errors import BadArgumentError
from labrig.files import AnyPath, check_free, path_of, write_text
from labrig.one_blas_thread import one_blas_thread
from labrig.progress import Progress
from model.discrepancy import DiagnoseOptions, Diagnosis, Next
from model.measurements import Displayed, Measurements, Summary
from model.measurements.known_arguments import known_arguments
from model.sheet.sheet_model import SheetModel

_WIDTH = 98  # letters of a line


@dataclass(frozen=True, kw_only=True, repr=False)
class NextMeasurement(Displayed):
    """What to measure next, and the text of its protocol.toml."""

    proposal: Next  # `why`, `separation` of the effects now and as `expected` after it, `minutes`
    protocol: str

    def summary(self) -> Summary:
        """Return which measurement it is, and how well it separates the effects."""
        from labrig.report.diagnosis.tables import next_sentence

        between = " and ".join(self.proposal.between)
        title = f"NextMeasurement: {self.proposal.extra}" + (f" for {between}" if between else "")
        return Summary(title, notes=tuple(textwrap.wrap(next_sentence(self.proposal), _WIDTH)))

    def save(self, path: AnyPath, *, force: bool = False) -> None:
        """Write protocol.toml. Raises LabrigError where it is there already, unless `force`."""
        check_free(path_of(path), force=force)
        write_text(path_of(path), self.protocol)

    def to_json(self) -> dict[str, Any]:
        """Return the object that `labrig next --json` prints."""
        one = self.proposal
        return {
            "why": one.why, "extra": one.extra, "separation_now": one.separation,
            "separation_expected": one.expected, "minutes": one.minutes,
            "protocol": parse_toml(self.protocol, "protocol.toml"),
        }  # fmt: skip


@known_arguments
@one_blas_thread
def next_measurement(
    sessions: Data | Sequence[AnyPath] | None = None,
    *,
    between: tuple[str, str] | None = None,
    sheet: AnyPath | None = None,
    forces: AnyPath | None = None,
    curves: AnyPath | None = None,
    signals: AnyPath | None = None,
    columns: Names = (),
    values: Names = (),
    ignore: str | Sequence[str] = (),
    model: AnyPath | SheetModel | None = None,
    symmetric: bool = False,
    progress: Progress | None = None,
) -> NextMeasurement:
    """Say which measurement tells two effects apart, as `labrig next` does.

    Args:
        sessions: a session file, several of the same sheet, or `Measurements`.
        between: names of two effects; default: those that the diagnosis cannot tell apart. A
            session that holds no diagnosis is then diagnosed first, and keeps the diagnosis; tables
            and `Measurements` are diagnosed.
        sheet: sheet.toml, with the CSV tables below in place of sessions.
        forces: forces.csv.
        curves: curves.csv.
        signals: signals.csv.
        columns: which column of the tables is which of labrig's, such as {"force_mN": "F"};
            several names for one, {"voltage_V": ["U", "Spannung"]}: the first that a table has.
        values: a value that no column has, such as {"configuration": "long"}.
        ignore: columns of the tables to leave out, such as "Nr".
        model: a model (or its file) whose effects are known.
        symmetric: one |EIBM| for both polarities.
        progress: called with the share done (0 to 1) and a text.

    Returns:
        NextMeasurement: `proposal` with its reason, and `protocol`, which `save` writes.

    Raises:
        LabrigError, ModelError: one sentence, such as for effects that no measurement separates.

    Example:
        >>> found = labrig.next_measurement(  # doctest: +SKIP
        ...     "session.h5", between=("gravity", "clamp_angle")
        ... )
        >>> found.save("next.toml")  # doctest: +SKIP

    """
    require_two(between)
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
    known = None if model is None else model_of(model)
    options = DiagnoseOptions(symmetric=symmetric, model=known)
    return proposed(measurements, paths, between, options, progress)


def require_two(between: tuple[str, str] | None) -> None:
    """Raise BadInputError unless two different effects are named."""
    if between is None:
        return
    names = several(between)
    if len(names) != 2 or not all(isinstance(name, str) for name in names):
        raise BadArgumentError(
            f"between {shown(between)}: name two effects, such as gravity and clamp_angle.",
            "between",
        )
    if names[0] == names[1]:
        raise BadArgumentError(
            f"between names {names[0]} twice; name two different effects.", "between"
        )


def proposed(
    measurements: Measurements,
    sessions: Sequence[Path],
    between: tuple[str, str] | None,
    options: DiagnoseOptions,
    progress: Progress | None,
) -> NextMeasurement:
    """Return the next measurement; diagnose where nobody names effects and none is kept."""
    from labrig.experiment.next_measurement.next_protocol import protocol_text
    from labrig.experiment.next_measurement.proposal import proposal

    first = sessions[0] if sessions else None
    diagnosis = None
    usual = options.model is None and not options.symmetric
    if first is not None and (between is None or usual):
        diagnosis = _diagnosis_of(first, measurements, between, options, progress)
    elif between is None:
        diagnosis = diagnosed(measurements, options, progress)
    found = proposal(measurements, diagnosis, between, options)
    return NextMeasurement(proposal=found, protocol=protocol_text(found, measurements, first))


def _diagnosis_of(
    session: Path,
    measurements: Measurements,
    between: tuple[str, str] | None,
    options: DiagnoseOptions,
    progress: Progress | None,
) -> Diagnosis | None:
    """Return the diagnosis that a session keeps; where it must name the effects, make one."""
    from labrig.report.data.kept_diagnosis import kept_diagnosis

    found = kept_diagnosis(session)
    if found is None and between is None:
        tell(f"{session} holds no diagnosis yet, so it is diagnosed first")
        found = diagnosed(measurements, options, progress)
        keep_in(session, found)
    return found
