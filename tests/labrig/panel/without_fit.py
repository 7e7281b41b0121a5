"""`labrig` with a panel that fits nothing beside a run: `python -P without_fit.py panel rig.toml`.

For tests of something else: a fit beside each run takes half of their processor time.
"""

from __future__ import annotations

import labrig.panel.core.panel
from labrig.cli import main


class NoFit:
    """In place of `LiveFit`."""

    def __init__(self, *_settings: object) -> None:
        pass

    def result(self, _session: str) -> None:
        """There is none."""

    def close(self) -> None:
        """Nothing to end."""


if __name__ == "__main__":
    labrig.panel.core.panel.LiveFit = NoFit  # type: ignore[assignment,misc]
    main()
