"""Tables of numbers by column, and the same as a pandas data frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas as pd

# Values of a column, all columns equally long; a unit ends the column's name, as in `force_N`.
Columns = Mapping[str, Sequence[Any] | Any]


class MissingPandasError(ImportError):
    """A data frame is asked for where pandas is not installed."""


def dataframe(columns: Columns) -> pd.DataFrame:
    """Return columns as a data frame. Raises MissingPandasError of one sentence without pandas."""
    try:
        import pandas as pd
    except ImportError:
        raise MissingPandasError(
            "to_dataframe() needs pandas, which is not installed here; install it with "
            'pip install "labrig[dataframe]".'
        ) from None
    return pd.DataFrame(dict(columns))


def of_rows(rows: Sequence[Mapping[str, Any]], names: Sequence[str] = ()) -> dict[str, list[Any]]:
    """Return rows as columns; None where a row lacks one. `names`: columns that come first."""
    every = list(dict.fromkeys([*names, *(name for row in rows for name in row)]))
    return {name: [row.get(name) for row in rows] for name in every}
