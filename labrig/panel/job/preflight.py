"""The job `preflight`: what `labrig check` does."""

from __future__ import annotations

from pathlib import Path

from labrig.check import failures
from labrig.errors import ExitCode
from labrig.experiment.operator import NoOperator
from labrig.experiment.plan import load_plan
from labrig.experiment.preflight import preflight
from labrig.experiment.rig.wiring import wire
from labrig.panel.job.host import Host


def check_rig(host: Host) -> tuple[int, str]:
    """Look; exit code and a sentence."""
    plan = load_plan(*host.order.files())
    wired = wire(plan, NoOperator(lambda _text: None))
    checks = preflight(wired, plan, Path(host.order.data))
    good = all(check.ok for check in checks)
    shown = [{**check.as_dict(), "warning": check.warning} for check in checks]
    host.publish({"type": "preflight", "ok": good, "checks": shown})
    if good:
        return ExitCode.DONE, "the rig is ready"
    return ExitCode.NOT_READY, f"the rig is not ready: {failures(checks)}"
