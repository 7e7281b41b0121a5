"""`labrig.design`: what a sheet can do in a working section, and which sheet one needs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, get_args, overload

from labrig.api.arguments import number, one_of, several, shown
from labrig.api.data import model_of
from labrig.api.eibm import Eibm, model_with_eibm
from labrig.api.simulate import tell_of_misses
from labrig.errors import BadArgumentError
from labrig.files import AnyPath
from labrig.one_blas_thread import one_blas_thread
from labrig.report.design.answers import DesignAnswers, Wanted, answer, as_dict, tables
from model.design.elongation_map import ElongationMap, elongation_map
from model.design.strength import Direction
from model.measurements import Displayed, Summary, dataframe
from model.measurements.columns import of_rows
from model.measurements.known_arguments import known_arguments
from model.sheet.misfit import Misfit, misfit
from model.sheet.sheet_model import SheetModel

if TYPE_CHECKING:
    import pandas as pd

Section = str | tuple[float, float]  # "0:30" or (0, 30), in mm
_STRAIGHT = "of its range %"  # error of the best line
MAP_STEPS = 13  # beginnings and ends of a map


@dataclass(frozen=True, repr=False)
class Design(Displayed, Sequence[DesignAnswers]):
    """The answers of each configuration, and the model they are of."""

    answers: tuple[DesignAnswers, ...]
    model: SheetModel

    def __len__(self) -> int:
        """Return the number of configurations."""
        return len(self.answers)

    @overload
    def __getitem__(self, index: int) -> DesignAnswers: ...

    @overload
    def __getitem__(self, index: slice) -> Design: ...

    def __getitem__(self, index: int | slice) -> DesignAnswers | Design:
        """Return the answers of a configuration, or of some."""
        if isinstance(index, slice):
            return Design(self.answers[index], self.model)
        return self.answers[index]

    def __iter__(self) -> Iterator[DesignAnswers]:
        """Yield the answers of each configuration."""
        return iter(self.answers)

    @property
    def errors(self) -> list[Misfit]:
        """How far the model is from the data that it was fitted to, by configuration."""
        return [misfit(self.model, one.wanted.configuration) for one in self.answers]

    def summary(self) -> Summary:
        """Return the answers in short; `to_dataframe` has all that `labrig design` prints."""
        rows = [
            (row["configuration"], row["question"], row["value"])
            for row in self._rows()
            if not row["table"].startswith("1.") or row["question"].startswith(_STRAIGHT)
        ]
        unanswered = tuple(
            f"{one.wanted.configuration}, no answer to {name}: {why}"
            for one in self.answers
            for name, why in one.unanswered.items()
        )
        return Summary("Design", ("sheet", "question", "answer"), rows, unanswered)

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each cell of the tables that `labrig design` prints, as text."""
        return dataframe(of_rows(list(self._rows())))

    def to_json(self) -> list[dict[str, Any]]:
        """Return the list that `labrig design --json` prints, in SI units."""
        return [as_dict(one, own) for one, own in zip(self.answers, self.errors, strict=True)]

    def _rows(self) -> Iterator[dict[str, str]]:
        for one in self.answers:
            for table in tables(one):
                for row in table.rows:
                    for column, value in zip(table.columns[1:], row[1:], strict=True):
                        if column == "where":
                            continue
                        what = row[0] if column == "value" else f"{column} ({row[0]})"
                        yield {
                            "configuration": one.wanted.configuration, "table": table.title,
                            "question": what, "value": value,
                        }  # fmt: skip


@known_arguments
@one_blas_thread
def design(
    model: AnyPath | SheetModel,
    section_mm: Section,
    *,
    configuration: str | Sequence[str] = (),
    force_mN: float | None = None,
    direction: Direction = "both",
    mass_g: float = 1.0,
    bandwidth_hz: float = 1.0,
    lag_s: float = 0.0,
    eibm: Mapping[float, Eibm] | None = None,
) -> Design:
    """Answer the design questions of the paper's section 5, as `labrig design` does.

    Args:
        model: a model (or its file).
        section_mm: the working section along the arc in mm, as "0:30" or (0, 30).
        configuration: one or several of the model's sheets; default: all.
        force_mN: required throughout, in mN: then the sheet of least area is searched.
        direction: in which that force must be possible: "both", "positive" or "negative".
        mass_g: of the object on the arc, in g, for the controller.
        bandwidth_hz: wanted of the controlled object, in Hz.
        lag_s: of the voltage's effect, in s.
        eibm: EIBMs of one's own by voltage, in N m; see `labrig.simulate`.

    Returns:
        Design: a sequence of answers, one for each configuration. Each question has an answer
        with its uncertainty, or a reason in `unanswered`.

    Raises:
        LabrigError, ModelError: one sentence for a wrong argument, or when nothing about the
        section has an answer.

    Example:
        >>> import labrig
        >>> short = labrig.sheet(
        ...     free_length_mm=4.5, width_mm=11, thickness_mm=0.21, elongation_mm=40,
        ...     B_Nm2=0.85e-6, EIBM_Nm=60e-6,
        ... )
        >>> found = labrig.design(short, (-5, 5))
        >>> round(1e3 * found[0].both_ways.force_N.value, 2)  # mN
        0.93

    """
    check_requirements(force_mN=force_mN, mass_g=mass_g, bandwidth_hz=bandwidth_hz, lag_s=lag_s)
    one_of("direction", direction, get_args(Direction))
    known = model_with_eibm(model_of(model), eibm)
    low_m, high_m = section_m(section_mm)
    answers = tuple(
        answer(
            known,
            Wanted(
                configuration=name,
                low_m=low_m,
                high_m=high_m,
                force_N=None if force_mN is None else force_mN / 1000,
                direction=direction,
                mass_kg=mass_g / 1000,
                bandwidth_rad_per_s=2 * math.pi * bandwidth_hz,
                lag_s=lag_s,
            ),
        )
        for name in several(configuration) or known.sheets
    )
    found = Design(answers, known)
    tell_of_misses(found.errors)
    return found


@known_arguments
@one_blas_thread
def map_of_elongation(
    model: AnyPath | SheetModel,
    section_mm: Section,
    *,
    configuration: str,
    direction: Direction = "both",
    eibm: Mapping[float, Eibm] | None = None,
) -> ElongationMap:
    """Compare the least area with and without an elongation, for all sections within one.

    Args:
        model: a model (or its file).
        section_mm: the widest working section in mm, as "0:30" or (0, 30).
        configuration: one of the model's sheets; its material is what is cut.
        direction: in which the force must be possible: "both", "positive" or "negative".
        eibm: EIBMs of one's own by voltage, in N m; see `labrig.simulate`.

    Returns:
        ElongationMap: beginnings `low_m`, ends `high_m`, and `ratio`: the least area with an
        elongation over that without. It is the same for every force.

    Raises:
        LabrigError, ModelError: one sentence for a wrong argument.

    Example:
        >>> found = labrig.map_of_elongation("model.toml", "0:30", configuration="long")
        ... # doctest: +SKIP

    """
    import numpy as np

    one_of("direction", direction, get_args(Direction))
    low_m, high_m = section_m(section_mm)
    ends = np.linspace(low_m, high_m, MAP_STEPS)
    known = model_with_eibm(model_of(model), eibm)
    return elongation_map(known, configuration, ends[:-1], ends[1:], direction)


def check_requirements(
    *, force_mN: float | None, mass_g: float, bandwidth_hz: float, lag_s: float
) -> None:
    """Raise BadInputError for a required number that is not above 0, or a lag below 0."""
    if force_mN is not None:
        number("force_mN", force_mN, above=0.0)
    number("mass_g", mass_g, above=0.0)
    number("bandwidth_hz", bandwidth_hz, above=0.0)
    number("lag_s", lag_s, at_least=0.0)


def section_m(section_mm: Section) -> tuple[float, float]:
    """Return both ends in m; BadInputError for what is no section."""
    parts = section_mm.split(":") if isinstance(section_mm, str) else section_mm
    try:
        low_mm, high_mm = (float(part) for part in parts)
    except (ValueError, TypeError):
        raise BadArgumentError(
            f"section_mm {shown(section_mm)}: two positions in mm with a colon between, such as"
            " 0:30.",
            "section_mm",
        ) from None
    if not -math.inf < low_mm < high_mm < math.inf:
        said = section_mm if isinstance(section_mm, str) else f"{low_mm:g}:{high_mm:g}"
        raise BadArgumentError(
            f"section_mm {said}: the first position must be below the second.", "section_mm"
        )
    return low_mm / 1000, high_mm / 1000
