"""What a job's process does while nobody wants anything: it loads what the next run needs.

No device is opened. Of a simulated rig the world is made once and thrown away, because its compiled
functions take longest to load.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

from drivers.interfaces import DeviceError
from labrig.errors import LabrigError


def warm_up(rig: Path) -> None:
    """Import what a run on this rig imports. Faults of its files are for the order to report."""
    from labrig.experiment.operator import NoOperator
    from labrig.experiment.preflight import plan_of
    from labrig.experiment.rig.wiring import wire
    from labrig.panel.job.preflight import check_rig  # noqa: F401 - imported for later

    with suppress(LabrigError, DeviceError):
        plan = plan_of(rig)
        if plan.rig.is_simulated:
            wire(plan, NoOperator(lambda _text: None))
