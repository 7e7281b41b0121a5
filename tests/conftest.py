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


# Begun first, or one worker waits for the other at the end.
LONGEST = ("tests/end_to_end/test_demo.py", "tests/end_to_end/test_closed_loop")


def _turn(item: pytest.Item) -> int:
    """The longest come first, and last what wants a quiet computer."""
    if "alone" in item.keywords:
        return 2
    return 0 if item.nodeid.startswith(LONGEST) else 1


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Each in its turn; real hardware is touched only when a rig is named."""
    items.sort(key=_turn)
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
