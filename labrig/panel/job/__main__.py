"""A job's process. It hears the panel before it loads anything: the panel may go meanwhile."""

from __future__ import annotations

import sys

from labrig.panel.job.hear import heard


def main() -> int:
    """Do what is ordered."""
    lines = heard()
    from labrig.panel.job.perform import perform

    return perform(lines)


if __name__ == "__main__":
    ended = main()
    if "labrig.session.recording.disk" in sys.modules:
        sys.modules["labrig.session.recording.disk"].end_before_the_library_does(ended)
    sys.exit(ended)
