"""Begin the process that finds curves: `python -m labrig.panel.live.curve_start`."""

from __future__ import annotations

from labrig.garbage import look_for_garbage_seldom
from labrig.parent_process import end_with_input


def main() -> None:
    """Serve; nothing slow is loaded before this process ends with its input."""
    end_with_input()
    look_for_garbage_seldom()
    from labrig.panel.live import curve_process

    curve_process.main()


if __name__ == "__main__":
    main()
