"""Find the locations of discrepancy: one a file of this folder, and those of other distributions.

A file of this folder adds one by its constant `LOCATION`; another distribution by an entry point
of the group `labrig.locations`.
"""

from __future__ import annotations

from model.locations.contract import Location
from model.measurements import ModelError
from model.plugins import PluginFolder, UnknownPartError


def _faults(part: object) -> list[str]:
    from model.locations.conformance import faults

    return faults(part)


FOLDER: PluginFolder[Location] = PluginFolder(
    what="location of discrepancy",
    package="model.locations",
    constant="LOCATION",
    group="labrig.locations",
    faults=_faults,
)


def locations() -> dict[str, Location]:
    """Return all locations by name, in the order of presentation."""
    found = FOLDER.parts()
    return {name: found[name].part for name in sorted(found, key=lambda n: found[n].part.order)}


def location(name: str) -> Location:
    """Return the location of this name; a `ModelError` lists those there are."""
    try:
        return FOLDER.get(name)
    except UnknownPartError as error:
        raise ModelError(str(error)) from None


def origins() -> dict[str, str]:
    """Return "distribution version" by name of the locations of other distributions."""
    return FOLDER.origins()
