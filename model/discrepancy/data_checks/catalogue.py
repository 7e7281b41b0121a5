"""Find the data checks: the files of `kinds`, and those of other distributions.

A file adds one by its constant `CHECK`; another distribution by an entry point of the group
`labrig.data_checks`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial

from model.discrepancy.data_checks.contract import Change, DataCheck, Suspicion
from model.identification.foreign_parts import answers_of
from model.measurements import Measurements
from model.plugins import OWN, Part, PluginFolder


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
    names = sorted(found, key=lambda n: found[n].part.order)
    return {
        name: found[name].part if found[name].distribution == OWN else _guarded(found[name])
        for name in names
    }


@dataclass(frozen=True, kw_only=True)
class _Guarded(DataCheck):
    """A check of another distribution: what its code raises on these data costs no fit."""

    check: DataCheck
    whose: str

    def suspicions(self, measurements: Measurements) -> Iterator[Suspicion]:
        """See `DataCheck.suspicions`."""
        ask = partial(self.check.suspicions, measurements)
        yield from answers_of(self.whose, Suspicion, ask, _WITHOUT) or ()

    def changes(self, measurements: Measurements) -> Iterator[Change]:
        """See `DataCheck.changes`."""
        ask = partial(self.check.changes, measurements)
        yield from answers_of(self.whose, Change, ask, _WITHOUT) or ()

    def of_failed_fit(self, measurements: Measurements) -> Iterator[Suspicion]:
        """See `DataCheck.of_failed_fit`."""
        ask = partial(self.check.of_failed_fit, measurements)
        yield from answers_of(self.whose, Suspicion, ask, _WITHOUT) or ()

    def of_stiffness(
        self, measurements: Measurements, B_Nm2: Mapping[str, float]
    ) -> Iterator[Suspicion]:
        """See `DataCheck.of_stiffness`."""
        ask = partial(self.check.of_stiffness, measurements, B_Nm2)
        yield from answers_of(self.whose, Suspicion, ask, _WITHOUT) or ()


_WITHOUT = "the data were checked"


@lru_cache(maxsize=64)  # the same object each time: what was found is kept by it
def _guarded(part: Part[DataCheck]) -> DataCheck:
    check = part.part
    whose = f"the data check '{part.name}' of {part.distribution} {part.version}"
    return _Guarded(
        name=check.name, meaning=check.meaning, order=check.order, check=check, whose=whose
    )


def origins() -> dict[str, str]:
    """Return "distribution version" by name of the data checks of other distributions."""
    return FOLDER.origins()
