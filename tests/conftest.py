"""Options and fixtures of the whole test suite."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import settings

# A shared, busy machine stalls any example now and then; and a test must not fail by chance alone.
settings.register_profile("labrig", deadline=None, derandomize=True)
settings.load_profile("labrig")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--rig", type=Path, help="rig.toml of the rig that real_hardware tests may use"
    )


# Begun first, or one worker waits for the other at the end. The soak stays last: it wants quiet.
LONGEST = ("tests/end_to_end/test_demo.py", "tests/end_to_end/test_closed_loop")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """The longest come first; real hardware is touched only when a rig is named."""
    items.sort(key=lambda item: not item.nodeid.startswith(LONGEST))
    if config.getoption("--rig") is not None:
        return
    skip = pytest.mark.skip(reason="needs a rig: -m real_hardware --rig rig.toml")
    for item in items:
        if "real_hardware" in item.keywords:
            item.add_marker(skip)


@pytest.fixture(scope="session")
def rig_file(request: pytest.FixtureRequest) -> Path:
    """The rig.toml given with --rig."""
    path: Path = request.config.getoption("--rig")
    return path
