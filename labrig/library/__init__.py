"""A folder of sessions: what each holds, not read whole, and not read twice.

What was found is kept in SQLite in the user's cache folder, by each file's time and size.
"""

from labrig.library.conditions import ConditionMean, compare_means, condition_means
from labrig.library.entry import CatalogueEntry, read_entry
from labrig.library.index import Library
from labrig.library.select import COLUMNS, FoundSessions, SessionQuery

__all__ = [
    "COLUMNS",
    "CatalogueEntry",
    "ConditionMean",
    "FoundSessions",
    "Library",
    "SessionQuery",
    "compare_means",
    "condition_means",
    "read_entry",
]
