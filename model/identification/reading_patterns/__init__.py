"""What the readings of a session have in common beside their means and trends, one file each."""

from model.identification.reading_patterns.catalogue import origins, reading_patterns
from model.identification.reading_patterns.contract import (
    FoundPattern,
    ReadingPattern,
    ReadingsOf,
)

__all__ = ["FoundPattern", "ReadingPattern", "ReadingsOf", "origins", "reading_patterns"]
