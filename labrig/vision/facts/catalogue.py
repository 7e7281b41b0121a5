"""Find the facts: the files of `kinds`, and those of other distributions.

A file adds one by its constant `FACT`; another distribution by an entry point of the group
`labrig.strip_facts`.
"""

from __future__ import annotations

from drivers.plugins import OWN, Part, PluginFolder
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
    """Return all facts by name, in their order; of two of one name or option the first."""
    found: dict[str, StripFact] = {}
    flags: set[str] = set()
    for part in sorted(FOLDER.parts().values(), key=_place):
        fact = part.part
        if fact.name not in found and fact.option.flag not in flags:
            found[fact.name] = fact
            flags.add(fact.option.flag)
    return dict(sorted(found.items(), key=lambda item: item[1].order))


def origin_of(name: str) -> str:
    """Return " of DISTRIBUTION VERSION" for a fact of another distribution; empty for ours."""
    for part in FOLDER.parts().values():
        if part.part.name == name and part.distribution != OWN:
            return f" of {part.distribution} {part.version}"
    return ""


def _place(part: Part[StripFact]) -> tuple[bool, int]:
    return part.distribution != OWN, part.part.order
