"""Find the verdict checks: the files of `kinds`, and those of other distributions.

A file adds one by its constant `CHECK`; another distribution by an entry point of the group
`labrig.verdict_checks`.
"""

from __future__ import annotations

from model.discrepancy.criticism.contract import VerdictCheck
from model.plugins import PluginFolder


def _faults(part: object) -> list[str]:
    from model.discrepancy.criticism.conformance import faults

    return faults(part)


FOLDER: PluginFolder[VerdictCheck] = PluginFolder(
    what="verdict check",
    package="model.discrepancy.criticism.kinds",
    constant="CHECK",
    group="labrig.verdict_checks",
    faults=_faults,
)


def verdict_checks() -> dict[str, VerdictCheck]:
    """Return all verdict checks by name, in their order."""
    found = FOLDER.parts()
    return {name: found[name].part for name in sorted(found, key=lambda n: found[n].part.order)}


def origins() -> dict[str, str]:
    """Return "distribution version" by name of the verdict checks of other distributions."""
    return FOLDER.origins()
