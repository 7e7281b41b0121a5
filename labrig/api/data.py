"""What the functions take: sessions, tables or measurements, and model files or models."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.errors import (
    ArgumentWarning,
    BadInputError,
    LabrigWarning,
    type_in_words,
    warn_caller,
)
from labrig.files import AnyPath, path_of
from labrig.progress import Progress, silent
from model.measurements import Measurements, require_well_formed

if TYPE_CHECKING:
    from model.sheet.sheet_model import SheetModel  # a run needs none, and would load it first

Data = AnyPath | Measurements


def tell(text: str, *arguments: str) -> None:
    """Warn the caller of something that is no error; the command line prints it as a sentence.

    arguments: those of a function that the text names; the command line names its options.
    """
    warn_caller(ArgumentWarning(text, *arguments) if arguments else LabrigWarning(text))


def tell_of_stiffness(measurements: Measurements, stated_Nm2: float | None) -> None:
    """Tell where a stated stiffness is not used, as the forces of each sheet determine it."""
    if stated_Nm2 is None:
        return
    every = {each.configuration for each in measurements.conditions}
    measured = {each.configuration for each in measurements.conditions if each.used()}
    if measured and every == measured:
        tell(
            "stiffness_Nm2 is not used: forces were measured of "
            f"{' and '.join(sorted(measured))}, which determine B",
            "stiffness_Nm2",
        )


def paths_of(data: Data | Sequence[AnyPath]) -> list[Path]:
    """Return the sessions among the data; none where these are measurements."""
    if isinstance(data, Measurements):
        return []
    return [path_of(one) for one in _as_list(data)]


def measurements_of(
    data: Data | Sequence[AnyPath], progress: Progress | None, *, processes: int = 1
) -> Measurements:
    """Return measurements as they are, or those of sessions; analyse what is not analysed yet.

    Raises ModelError for measurements with a field that is not as its class states it.
    """
    if isinstance(data, Measurements):
        require_well_formed(data)
        return data
    from labrig.analysis.distinct import check_distinct
    from labrig.analysis.together import together
    from labrig.report.data.findings import measured

    paths = paths_of(data)
    if not paths:
        raise BadInputError("give at least one session, or measurements.")
    check_distinct(paths)
    advance = progress or silent
    return together([(path, measured(path, advance, tell, processes=processes)) for path in paths])


def model_of(model: AnyPath | SheetModel) -> SheetModel:
    """Return a model as it is, or that of a file."""
    from labrig.model_file import load_model, no_model
    from model.sheet.sheet_model import SheetModel

    if isinstance(model, SheetModel):
        return model
    if not isinstance(model, str | os.PathLike):  # a caller may give anything
        raise no_model(model, "a model or its file")
    return load_model(path_of(model))


def name_of(model: AnyPath | SheetModel) -> str:
    """Return the file's name for sentences about a model."""
    return path_of(model).name if isinstance(model, str | os.PathLike) else "the model"


def _as_list(data: AnyPath | Sequence[AnyPath]) -> list[AnyPath]:
    if isinstance(data, str | os.PathLike):
        return [data]
    # a data frame is its columns, an open h5py.File its groups, and bytes are numbers
    no_paths = isinstance(data, bytes | Mapping) or hasattr(data, "columns")
    if no_paths or not isinstance(data, Iterable):
        raise BadInputError(
            f"a session file, several, or measurements are needed, not {type_in_words(data)}; "
            "for tables see labrig.measurements_of_tables."
        )
    return list(data)
