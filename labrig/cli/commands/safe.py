"""0 V, whatever has happened before."""

from __future__ import annotations

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import RigFile
from labrig.cli.screen import say
from labrig.errors import OutputUnknownError


def safe(rig: RigFile) -> None:
    """Write 0 V to the output, and read it back.

    Takes the boards from whoever still holds them. With an NI driver in this computer they belong
    to their program: end that first, and its guard writes 0 V. Ends with code 6 when the output is
    not known to be at 0 V: then switch the amplifier off by hand.
    """
    from labrig.experiment.safety import make_rig_safe

    report = make_rig_safe(rig)
    if not report.is_safe:
        raise OutputUnknownError(report.text)
    say(report.text)


COMMAND = Command(
    "safe",
    safe,
    order=70,
    examples=(CommandExample(line="labrig safe rig/rig.toml"),),
)
