"""Which of our columns each column of a file is: as named, as written otherwise, or as stated."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from enum import StrEnum
from typing import Final

from labrig.errors import BadInputError
from labrig.files import typed
from labrig.session.tables.text.guesses import likely
from labrig.session.tables.text.layout import TextLayout, is_number
from labrig.session.tables.text.names import (
    POSITION,
    SplitName,
    Unit,
    angle_factor,
    fits,
    is_meant,
    may_mean,
    own_unit,
    shift,
    split_name,
    unit_of,
    units_of,
    weight_factor,
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
    IGNORED = "--ignore"
    UNUSED = "not used"


@dataclass(frozen=True, kw_only=True)
class ColumnNames:
    """What the user states of tables whose columns have other names."""

    columns: Mapping[str, Sequence[str]] = field(default_factory=dict)  # ours: theirs, by table
    values: Mapping[str, str] = field(default_factory=dict)  # ours: the same in all lines
    ignored: Sequence[str] = ()  # theirs
    guesses: bool = False  # whether what is likely is taken: somebody will be asked
    several_tables: bool = False  # each takes the first of the names that it has
    only_sheet: str = ""  # the configuration, where a table need not name it
    arc_radius_m: float | None = None  # where all sheets have the same


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
    factor: Decimal | None = None  # in its place, of an angle or a weight


def meanings(
    file: str, layout: TextLayout, expected: ExpectedColumns, given: ColumnNames
) -> list[ColumnMeaning]:
    """Return the meaning of each column. Raises BadInputError, which names the column."""
    names = layout.names
    found: dict[int, ColumnMeaning] = {}

    def take(index: int, ours: str, how: How) -> None:
        one = ColumnMeaning(index=index, name=names[index], means=ours, how=how)
        found[index] = _converted(file, layout, one, given.arc_radius_m)

    for index in indices_of(names, given.ignored):
        found[index] = ColumnMeaning(index=index, name=names[index], means="", how=How.IGNORED)
    for ours, theirs in given.columns.items():
        there = indices_of(names, theirs)
        named = ours in names and names.index(ours) not in found
        if there and ours in expected.known and not named:
            _refuse_two(file, found, there[0], ours)
            take(there[0], ours, How.STATED)
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
    return [found.get(i, _unused(i, name)) for i, name in enumerate(names)]


def _unused(index: int, name: str) -> ColumnMeaning:
    return ColumnMeaning(index=index, name=name, means="", how=How.UNUSED)


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
    letters: str = "",
) -> list[ColumnMeaning]:
    """Return the columns, without guesses that nobody has agreed to.

    Raises BadInputError where one is missing or there twice, where a guess is needed, or where one
    is not known in a table that is otherwise as ours, or nearly known. `cells` are the values of
    a line; `letters` is said of a file whose letters may be read wrongly.
    """
    _refuse_the_same_twice(file, found)
    _refuse_absent(file, found, expected, given)
    guessed = [one for one in found if one.how is How.GUESSED]
    if guessed and not given.guesses:
        needed = [one for one in guessed if one.means in expected.required]
        if needed:
            raise _offered(file, needed)
        found = [_unused(one.index, one.name) if one in guessed else one for one in found]
    has = {one.means for one in found} | set(given.values)
    for one in found:
        unknown = one.how is How.UNUSED and _is_free(one.name, expected)
        if unknown and (plain or _nearly(one.name, expected, has)):
            left_out = f"; {ignoring(one)} leaves it out" if expected.renamed else ""
            raise BadInputError(
                f"{file}: column {short(one.name)!r} is not known; {_hint(one, expected, has)}"
                f"{left_out}."
            )
    for name in expected.required:
        if name not in has and name != expected.numbered:
            _refuse_a_column_for_each(file, name, found)
            free = [one for one in found if one.how is How.UNUSED and one.name]
            others = [(one.index, split_name(one.name)) for one in free]
            guesses = likely(name, others, cells) if expected.renamed and not plain else []
            offered = [short(one.name) for one in free if one.index in guesses]
            none_known = not any(one.means for one in found)
            there = [short(one.name) for one in free if none_known]
            raise BadInputError(
                _missing(file, name, offered, there, ask=expected.renamed and not plain) + letters
            )
    return found


def _with_unit(layout: TextLayout, index: int) -> SplitName:
    """Return a column's name with the unit that it has, or that the line below states."""
    name = split_name(layout.names[index])
    below = layout.units[index] if index < len(layout.units) else ""
    if name.unit is None and not name.unknown and below:
        unit = unit_of(below)
        return SplitName(name.base, unit, "" if unit else below)
    return name


def _converted(
    file: str, layout: TextLayout, column: ColumnMeaning, arc_radius_m: float | None
) -> ColumnMeaning:
    """Return a column with what makes our unit of the file's. Raises BadInputError."""
    name, ours = _with_unit(layout, column.index), column.means
    wrong = name.unknown
    if isinstance(name.unit, Unit) and not fits(name.unit, ours):
        wrong = name.unit.written
    if wrong and own_unit(ours) is not None:
        weight = unit_of(f"{wrong}f")
        is_one = weight is not None and fits(weight, ours)
        raise BadInputError(
            f"{file}: column {short(column.name)!r}: {wrong!r} is no unit of {ours}; "
            f"convert the column{f', or write {wrong}f where it is a weight' * is_one}."
        )
    _refuse_another_below(file, layout, column)
    factor = weight_factor(name.unit, ours) or angle_factor(name.unit, ours, arc_radius_m)
    if factor is not None:
        return replace(column, factor=factor)
    if ours == POSITION and name.unit is not None and name.unit.measures == "angle":
        raise BadInputError(
            f"{file}: column {short(column.name)!r} is an angle, and the sheets have different "
            f"arc radii; convert the column to {POSITION}."
        )
    return replace(column, exponent=shift(name.unit, ours))


def _refuse_another_below(file: str, layout: TextLayout, column: ColumnMeaning) -> None:
    """Raise BadInputError where a name has a unit and the line below states another."""
    named = split_name(layout.names[column.index]).unit
    text = layout.units[column.index] if column.index < len(layout.units) else ""
    below = unit_of(text)
    if named and below and replace(named, written="") != replace(below, written=""):
        raise BadInputError(
            f"{file}: column {short(column.name)!r}: the line below its name says {text!r}; "
            "state one unit."
        )


def indices_of(names: Sequence[str], theirs: Sequence[str]) -> list[int]:
    """Return the columns that a user names, each whole or without its unit, where they exist."""
    found = []
    for one in theirs:
        like = [i for i, name in enumerate(names) if split_name(name).base == one]
        if one in names:
            found.append(names.index(one))
        elif len(like) == 1:
            found.append(like[0])
    return found


def _refuse_two(file: str, found: Mapping[int, ColumnMeaning], index: int, ours: str) -> None:
    if index in found:
        raise BadInputError(
            f"{file}: --columns: column {found[index].name!r} cannot be both "
            f"{found[index].means or 'ignored'} and {ours}."
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


def _refuse_a_column_for_each(file: str, ours: str, found: Sequence[ColumnMeaning]) -> None:
    """Raise BadInputError where the names are values of the missing column: -2 V, 0 V, 2 V."""
    split = {one.name: split_name(one.name) for one in found if not one.means}
    values = [
        name
        for name, one in split.items()
        if one.unit is not None and fits(one.unit, ours) and is_number(one.base)
    ]
    if values[1:]:
        raise BadInputError(
            f"{file}: it has a column for each {ours} ({', '.join(values[:_MOST_NAMES])}); write a "
            f"line for each value, with a column {ours}."
        )


def _refuse_absent(
    file: str, found: Sequence[ColumnMeaning], expected: ExpectedColumns, given: ColumnNames
) -> None:
    """Raise BadInputError where a column that is needed is stated, and the file lacks it."""
    known = {one.means for one in found if one.how is not How.GUESSED}
    for ours, theirs in given.columns.items():
        if ours in expected.required and ours not in known:
            names = ", ".join(short(one.name) for one in found[:_MOST_NAMES] if one.name)
            add = f"; add --columns {ours}=NAME with its name in this table"
            further = add if given.several_tables else ""
            raise BadInputError(
                f"{file}: {as_typed(ours, theirs)}: there is no column "
                f"{' or '.join(map(repr, theirs))}; the file has {names}{further}."
            )


def _offered(file: str, guesses: Sequence[ColumnMeaning]) -> BadInputError:
    said = " ".join(stated(one) for one in guesses)
    are = "is not known" if len(guesses) == 1 else "are not known"
    names = ", ".join(repr(one.name) for one in guesses)
    out = "--ignore NAME leaves one out" if guesses[1:] else f"{ignoring(guesses[0])} leaves it out"
    return BadInputError(
        f"{file}: column{'s' * (len(guesses) > 1)} {names} {are}; if this is meant, give {said}; "
        f"{out}."
    )


def stated(column: ColumnMeaning) -> str:
    """Return the option that states a column, as it is typed."""
    return f"--columns {typed(f'{column.means}={_base(column)}')}"


def ignoring(column: ColumnMeaning) -> str:
    """Return the option that leaves a column out, as it is typed."""
    return f"--ignore {typed(_base(column))}"


def as_typed(ours: str, theirs: Sequence[str]) -> str:
    """Return the options that state the names of a column."""
    return " ".join(f"--columns {ours}={one}" for one in theirs)


def _base(column: ColumnMeaning) -> str:
    return split_name(column.name).base or column.name


def _missing(
    file: str, name: str, offered: Sequence[str], there: Sequence[str], *, ask: bool
) -> str:
    if not ask:
        return f"{file}: column {name} is missing; it is required."
    give = f"is it {' or '.join(offered[:_MOST_NAMES])}? Give" if offered else "give"
    others = ", ".join(there[:_MOST_NAMES])
    has = f" (the file has {others})" if others and not offered else ""
    return (
        f"{file}: column {name} is missing; {give} --columns {name}=NAME{has} or --value {name}=..."
    )


def _nearly(name: str, expected: ExpectedColumns, has: set[str]) -> bool:
    lacking = [one for one in expected.known if one not in has]
    return bool(difflib.get_close_matches(name.lower(), lacking, n=1, cutoff=_NEARLY))


def _hint(column: ColumnMeaning, expected: ExpectedColumns, has: set[str]) -> str:
    """Return which of our columns one may be: by its letters, else by its unit."""
    name, known = column.name, expected.known
    close = difflib.get_close_matches(name[:MOST_OF_A_NAME], known, n=1, cutoff=0.5)
    if close:
        units = units_of(close[0])
        written = f", in {', '.join(units[:-1])} or {units[-1]}" if units else ""
        return f"did you mean {close[0]}{written}"
    split = split_name(name)
    lacking = [one for one in expected.required if one not in has and one != expected.numbered]
    may = [one for one in lacking if split.unit is not None and fits(split.unit, one)]
    if may and expected.renamed:
        is_it = replace(column, means=may[0])
        return f"is it {may[0]}? Give {stated(is_it)}"
    return f"the columns are {', '.join(expected.required)}"


def short(name: str) -> str:
    """Return the part of a name that is worth showing."""
    return name if len(name) <= MOST_OF_A_NAME else f"{name[:MOST_OF_A_NAME]}..."
