"""Which of our columns each column of a file is: as named, as written otherwise, or as stated."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Final

from labrig.errors import BadInputError
from labrig.files import typed
from labrig.session.tables.text.guesses import likely
from labrig.session.tables.text.layout import TextLayout
from labrig.session.tables.text.names import (
    SplitName,
    Unit,
    is_meant,
    may_mean,
    own_unit,
    shift,
    split_name,
    unit_of,
    units_of,
)

MOST_OF_A_NAME: Final = 40  # characters that are worth showing
_MOST_NAMES = 8  # columns that a sentence lists
_NEARLY = 0.85  # so alike, a name is a slip of the pen


class How(StrEnum):
    """How the meaning of a column is known."""

    NAMED = "as named"
    WRITTEN = "by name and unit"
    STATED = "--columns"
    GUESSED = "a guess"
    UNUSED = "not used"


@dataclass(frozen=True)
class ColumnNames:
    """What the user states of tables whose columns have other names."""

    columns: Mapping[str, str] = field(default_factory=dict)  # ours: theirs
    values: Mapping[str, str] = field(default_factory=dict)  # ours: the same in all lines
    guesses: bool = False  # whether what is likely is taken: somebody will be asked
    only_sheet: str = ""  # the configuration, where a table need not name it


AS_NAMED: Final = ColumnNames()


@dataclass(frozen=True, kw_only=True)
class ExpectedColumns:
    """The columns that a kind of table has."""

    kind: str  # such as forces
    required: tuple[str, ...]
    optional: tuple[str, ...] = ()
    ignored: tuple[str, ...] = ()  # known, and of no use here
    prefix: str | None = None  # of the names of further columns
    numbered: str = ""  # of the required ones: the lines are counted where it is missing
    renamed: bool = True  # whether --columns can say what other names mean

    @property
    def known(self) -> tuple[str, ...]:
        """All of them."""
        return (*self.required, *self.optional)

    def has(self, name: str) -> bool:
        """Whether a name is that of a column."""
        further = self.prefix and name.startswith(self.prefix) and name != self.prefix
        return name in self.known or bool(further)


@dataclass(frozen=True, kw_only=True)
class ColumnMeaning:
    """One column of a file."""

    index: int
    name: str  # as in the file
    means: str  # our column; empty: none
    how: How
    exponent: int = 0  # power of ten that makes our unit of the file's


def meanings(
    file: str, layout: TextLayout, expected: ExpectedColumns, given: ColumnNames
) -> list[ColumnMeaning]:
    """Return the meaning of each column. Raises BadInputError, which names the column."""
    names = layout.names
    found: dict[int, ColumnMeaning] = {}

    def take(index: int, ours: str, how: How) -> None:
        found[index] = ColumnMeaning(
            index=index,
            name=names[index],
            means=ours,
            how=how,
            exponent=_exponent(file, layout, index, ours),
        )

    for ours, theirs in given.columns.items():
        if ours in expected.known and ours not in names:
            index = _index_of(names, theirs)
            if index is not None:
                _refuse_two(file, found, index, ours)
                take(index, ours, How.STATED)
    for index, name in enumerate(names):
        if index not in found and expected.has(name):
            take(index, name, How.NAMED)
    taken = {one.means for one in found.values()} | set(given.values)
    written: set[str] = set()
    for index in range(len(names)):
        if index in found:
            continue
        one = _with_unit(layout, index)
        meant = [ours for ours in expected.known if ours not in taken and is_meant(one, ours)]
        if meant:
            take(index, meant[0], How.WRITTEN)
            written.add(meant[0])
    taken |= written
    for ours in expected.known if expected.renamed else ():
        free = [i for i, name in enumerate(names) if i not in found and _is_free(name, expected)]
        may = [i for i in free if ours not in taken and may_mean(_with_unit(layout, i), ours)]
        if len(may) == 1:
            take(may[0], ours, How.GUESSED)
            taken.add(ours)
    return [
        found.get(i, ColumnMeaning(index=i, name=name, means="", how=How.UNUSED))
        for i, name in enumerate(names)
    ]


def _is_free(name: str, expected: ExpectedColumns) -> bool:
    return bool(name) and name not in expected.ignored


def check(
    file: str,
    found: list[ColumnMeaning],
    expected: ExpectedColumns,
    given: ColumnNames,
    *,
    plain: bool,
    cells: Sequence[str] = (),
) -> list[ColumnMeaning]:
    """Return the columns, without guesses that nobody has agreed to.

    Raises BadInputError where one is missing or there twice, where a guess is needed, or where one
    is not known in a table that is otherwise as ours, or nearly known. `cells` are the values of
    a line.
    """
    _refuse_the_same_twice(file, found)
    _refuse_absent(file, found, expected, given)
    guessed = [one for one in found if one.how is How.GUESSED]
    if guessed and not given.guesses:
        needed = [one for one in guessed if one.means in expected.required]
        if needed:
            raise _offered(file, needed)
        found = [
            ColumnMeaning(index=one.index, name=one.name, means="", how=How.UNUSED)
            if one.how is How.GUESSED
            else one
            for one in found
        ]
    has = {one.means for one in found} | set(given.values)
    for one in found:
        unused = one.how is How.UNUSED and _is_free(one.name, expected)
        if unused and (plain or _nearly(one.name, expected, has)):
            raise BadInputError(
                f"{file}: column {short(one.name)!r} is not known; {_hint(one.name, expected)}."
            )
    for name in expected.required:
        if name not in has and name != expected.numbered:
            free = [one for one in found if one.how is How.UNUSED and one.name]
            others = [(one.index, split_name(one.name)) for one in free]
            guesses = likely(name, others, cells) if expected.renamed and not plain else []
            offered = [short(one.name) for one in free if one.index in guesses]
            raise BadInputError(_missing(file, name, offered, ask=expected.renamed and not plain))
    return found


def _with_unit(layout: TextLayout, index: int) -> SplitName:
    """Return a column's name with the unit that it has, or that the line below states."""
    name = split_name(layout.names[index])
    below = layout.units[index] if index < len(layout.units) else ""
    if name.unit is None and not name.unknown and below:
        unit = unit_of(below)
        return SplitName(name.base, unit, "" if unit else below)
    return name


def _exponent(file: str, layout: TextLayout, index: int, ours: str) -> int:
    name = _with_unit(layout, index)
    own = own_unit(ours)
    wrong = name.unknown
    if isinstance(name.unit, Unit) and own is not None and name.unit.measures != own.measures:
        wrong = name.unit.written
    if wrong and own is not None:
        raise BadInputError(
            f"{file}: column {short(layout.names[index])!r}: {wrong!r} is no unit of {ours}; "
            "convert the column."
        )
    return shift(name.unit, ours)


def _index_of(names: Sequence[str], theirs: str) -> int | None:
    """Return the column that a user names, whole or without its unit."""
    if theirs in names:
        return names.index(theirs)
    like = [i for i, name in enumerate(names) if split_name(name).base == theirs]
    return like[0] if len(like) == 1 else None


def _refuse_two(file: str, found: Mapping[int, ColumnMeaning], index: int, ours: str) -> None:
    if index in found:
        raise BadInputError(
            f"{file}: --columns: column {found[index].name!r} cannot be both {found[index].means} "
            f"and {ours}."
        )


def _refuse_the_same_twice(file: str, found: Sequence[ColumnMeaning]) -> None:
    seen: dict[str, str] = {}
    for one in found:
        if one.means in seen:
            both = seen[one.means]
            if both == one.name:
                raise BadInputError(f"{file}: column {one.name} is there twice.")
            raise BadInputError(
                f"{file}: columns {both!r} and {one.name!r} are both {one.means}; remove one."
            )
        if one.means:
            seen[one.means] = one.name


def _refuse_absent(
    file: str, found: Sequence[ColumnMeaning], expected: ExpectedColumns, given: ColumnNames
) -> None:
    """Raise BadInputError where a column that is needed is stated, and the file lacks it."""
    known = {one.means for one in found if one.how is not How.GUESSED}
    for ours, theirs in given.columns.items():
        if ours in expected.required and ours not in known:
            names = ", ".join(short(one.name) for one in found[:_MOST_NAMES] if one.name)
            raise BadInputError(
                f"{file}: --columns {ours}={theirs}: there is no column {theirs!r}; the file has "
                f"{names}."
            )


def _offered(file: str, guesses: Sequence[ColumnMeaning]) -> BadInputError:
    said = " ".join(stated(one) for one in guesses)
    are = "is not known" if len(guesses) == 1 else "are not known"
    names = ", ".join(repr(one.name) for one in guesses)
    return BadInputError(
        f"{file}: column{'s' * (len(guesses) > 1)} {names} {are}; if this is meant, give {said}."
    )


def stated(column: ColumnMeaning) -> str:
    """Return the option that states a column, as it is typed."""
    name = split_name(column.name).base or column.name
    return f"--columns {typed(f'{column.means}={name}')}"


def _missing(file: str, name: str, offered: Sequence[str], *, ask: bool) -> str:
    if not ask:
        return f"{file}: column {name} is missing; it is required."
    there = f"is it {' or '.join(offered[:_MOST_NAMES])}? Give" if offered else "give"
    return f"{file}: column {name} is missing; {there} --columns {name}=NAME or --value {name}=..."


def _nearly(name: str, expected: ExpectedColumns, has: set[str]) -> bool:
    lacking = [one for one in expected.known if one not in has]
    return bool(difflib.get_close_matches(name.lower(), lacking, n=1, cutoff=_NEARLY))


def _hint(name: str, expected: ExpectedColumns) -> str:
    known = expected.known
    close = difflib.get_close_matches(name[:MOST_OF_A_NAME], known, n=1, cutoff=0.5)
    if close:
        units = units_of(close[0])
        written = f", in {', '.join(units[:-1])} or {units[-1]}" if units else ""
        return f"did you mean {close[0]}{written}"
    return f"the columns are {', '.join(expected.required)}"


def short(name: str) -> str:
    """Return the part of a name that is worth showing."""
    return name if len(name) <= MOST_OF_A_NAME else f"{name[:MOST_OF_A_NAME]}..."
