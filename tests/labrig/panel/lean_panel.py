"""`labrig` with a lean panel, for tests: `python -P lean_panel.py panel rig.toml`.

It fits nothing beside a run and keeps no process ready for the next job: both take longer than most
runs of tests. Both have tests of their own, and what is promised to users in seconds is measured
with a whole panel.
"""

from __future__ import annotations

import labrig.panel.core.panel
from labrig.cli import main
from labrig.panel.job.process import JobProcesses


class NoFit:
    """In place of `LiveFit`."""

    def __init__(self, *_settings: object) -> None:
        pass

    def result(self, _session: str) -> None:
        """There is none."""

    def close(self) -> None:
        """Nothing to end."""


def prepare(self: JobProcesses, *, beside_a_job: bool = False) -> None:
    """Start nothing: an order starts its process."""


if __name__ == "__main__":
    labrig.panel.core.panel.LiveFit = NoFit  # type: ignore[assignment,misc]
    JobProcesses.prepare = prepare  # type: ignore[method-assign]
    main()
