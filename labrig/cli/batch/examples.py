"""Examples of `labrig batch`; the documentation runs them."""

from __future__ import annotations

from labrig.cli.command import CommandExample

EXAMPLES = (
    CommandExample(line="labrig batch analyze *.h5 --dry-run"),
    CommandExample(line="labrig batch fit session.h5 night --dry-run"),
    CommandExample(line="labrig batch diagnose *.h5 --dry-run"),
    CommandExample(line="labrig batch report *.h5 --dry-run"),
    CommandExample(line="labrig batch verify session.h5 night --workers 1 -o verified"),
    CommandExample(line="labrig batch simulate model.toml --count 100 --dry-run"),
    CommandExample(line="labrig batch design model.toml --force-mN 0.2 --dry-run"),
)
