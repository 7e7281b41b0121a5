"""A small session on the simulated rig, made once for all tests that read it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.end_to_end.small_rig import make_rig, run_rig


@pytest.fixture(scope="session")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a simulated rig whose session has been run; leave the files as they are."""
    folder = make_rig(tmp_path_factory.mktemp("rig") / "rig")
    run_rig(folder)
    return folder


@pytest.fixture(scope="session")
def session(rig: Path) -> Path:
    """That session, not analysed."""
    return rig / "session.h5"
