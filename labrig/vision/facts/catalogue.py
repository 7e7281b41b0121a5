"""Find the facts: the files of `kinds`, and those of other distributions.

A file adds one by its constant `FACT`; another distribution by an entry point of the group
`labrig.strip_facts`.
"""

from __future__ import annotations

import sys
import warnings
from functools import lru_cache

from drivers.plugins import OWN, Part, PluginFolder, PluginWarning
from labrig.vision.facts.contract import StripFact


def _faults(part: object) -> list[str]:
    from labrig.vision.facts.conformance import faults

    return faults(part)


FOLDER: PluginFolder[StripFact] = PluginFolder(
    what="strip fact",
    package="labrig.vision.facts.kinds",
    constant="FACT",
    group="labrig.strip_facts",
    faults=_faults,
)


def strip_facts() -> dict[str, StripFact]:
    """Return all facts by name, in their order."""
    return dict(_in_order(tuple(sys.path)))


@lru_cache(maxsize=8)
def _in_order(path: tuple[str, ...]) -> dict[str, StripFact]:
    """Return the facts as seen from these places; of two with one name or option the first."""
    del path
    found: dict[str, StripFact] = {}
    for part in sorted(FOLDER.parts().values(), key=_place):
        fact = part.part
        before = [
            one
            for one in found.values()
            if fact.name == one.name or fact.option.flag == one.option.flag
        ]
        if before:
            warnings.warn(
                f"the strip fact '{fact.name}' of {part.distribution} is left out: there is one "
                f"'{before[0].name}' with the option {before[0].option.flag} already.",
                PluginWarning,
                stacklevel=2,
            )
        else:
            found[fact.name] = fact
    return dict(sorted(found.items(), key=lambda item: item[1].order))


def origin_of(name: str) -> str:
    """Return " of DISTRIBUTION VERSION" for a fact of another distribution; empty for ours."""
    for part in FOLDER.parts().values():
        if part.part.name == name and part.distribution != OWN:
            return f" of {part.distribution} {part.version}"
    return ""


def _place(part: Part[StripFact]) -> tuple[bool, int]:
    return part.distribution != OWN, part.part.order
