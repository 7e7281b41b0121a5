"""What tests of other people's parts need: the conformance functions and a fake rig.

A conformance function of a kind of part returns what is wrong with a part, a sentence each:
`assert labrig.testing.command_faults(COMMAND) == []`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from labrig.lazy_imports import lazily
from labrig.own_packages import require_own_packages

if TYPE_CHECKING:
    from labrig.testing.conformance import command_faults as command_faults
    from labrig.testing.fake_rig import FakeRig as FakeRig
    from labrig.testing.fake_rig import short_schedule as short_schedule

_HOMES = {
    "labrig.testing.conformance": ("command_faults",),
    "labrig.testing.fake_rig": ("FakeRig", "short_schedule"),
}
__getattr__, __dir__, __all__ = lazily(__name__, _HOMES, before=require_own_packages)
