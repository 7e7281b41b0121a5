"""Find the data checks: the files of `kinds`, and those of other distributions.

A file adds one by its constant `CHECK`; another distribution by an entry point of the group
`labrig.data_checks`.
"""

from __future__ import annotations

from model.discrepancy.data_checks.contract import DataCheck
from model.plugins import PluginFolder


def _faults(part: object) -> list[str]:
    from model.discrepancy.data_checks.conformance import faults

    return faults(part)


FOLDER: PluginFolder[DataCheck] = PluginFolder(
    what="data check",
    package="model.discrepancy.data_checks.kinds",
    constant="CHECK",
    group="labrig.data_checks",
    faults=_faults,
)


def data_checks() -> dict[str, DataCheck]:
    """Return all data checks by name, in their order."""
    found = FOLDER.parts()
    return {name: found[name].part for name in sorted(found, key=lambda n: found[n].part.order)}


def origins() -> dict[str, str]:
    """Return "distribution version" by name of the data checks of other distributions."""
    return FOLDER.origins()
