"""What the readings of a session have in common beside their means and trends, one file each."""

from model.identification.reading_patterns.catalogue import origins, reading_patterns
from model.identification.reading_patterns.contract import (
    FoundPattern,
    ReadingPattern,
    ReadingsOf,
    ReadingsOfCondition,
)

__all__ = [
    "FoundPattern",
    "ReadingPattern",
    "ReadingsOf",
    "ReadingsOfCondition",
    "origins",
    "reading_patterns",
]
