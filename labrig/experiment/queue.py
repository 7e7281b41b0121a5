"""Run several sessions one after the other, after checking all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from labrig.errors import LabrigError
from labrig.experiment.plan import Plan, load_plan
from labrig.experiment.preflight import calibrations, disk_space, doubts


@dataclass(frozen=True, kw_only=True)
class QueuedRun:
    """A session to come."""

    rig: Path
    protocol: Path
    sheet: Path
    session: Path  # the file to make
    about: str | None = None  # text, in place of the about.toml beside rig.toml

    def plan(self) -> Plan:
        """Return what is going to be done; LabrigError for any fault of files or limits."""
        plan = load_plan(self.rig, self.protocol, self.sheet)
        return plan if self.about is None else plan.with_about(self.about)


def faults_of(runs: Sequence[QueuedRun]) -> list[str]:
    """Return a sentence for each fault that can be found without the rig."""
    faults = _name_faults(runs)
    plans: list[Plan] = []
    for run in runs:
        try:
            plans.append(run.plan())
        except LabrigError as error:
            faults.append(str(error))
    for plan in plans[:1]:  # the calibrations are the rig's, which all of them share
        faults += [f"{check.in_words}." for check in calibrations(plan) if not check.ok]
    for plan in plans:
        faults += [f"{check.in_words}." for check in doubts(plan) if not check.ok]
    if plans:
        space = disk_space(plans, runs[0].session.parent)
        if not space.ok:
            faults.append(f"{space.name}: {space.found}, wanted {space.wanted}.")
    return list(dict.fromkeys(faults))


def _name_faults(runs: Sequence[QueuedRun]) -> list[str]:
    paths = [run.session for run in runs]
    faults = [f"{path}: exists already; choose another name." for path in paths if path.exists()]
    twice = {path for path in paths if paths.count(path) > 1}
    return faults + [f"{path}: two sessions of the queue have this name." for path in sorted(twice)]
