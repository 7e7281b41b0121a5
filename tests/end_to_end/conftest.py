"""A small session on the simulated rig, recorded once for all tests and workers that read it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.end_to_end.small_rig import small_rig


@pytest.fixture(scope="session")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a simulated rig whose session has been run; leave the files as they are."""
    return small_rig(tmp_path_factory)


@pytest.fixture(scope="session")
def session(rig: Path) -> Path:
    """That session, not analysed."""
    return rig / "session.h5"
