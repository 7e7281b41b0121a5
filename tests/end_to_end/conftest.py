"""A small session on the simulated rig, recorded once for all tests and workers that read it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.end_to_end.small_rig import make_rig, run_rig
from tests.made_once import made_once


@pytest.fixture(scope="session")
def rig(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a simulated rig whose session has been run; leave the files as they are."""
    return made_once(tmp_path_factory, "small-rig", lambda folder: run_rig(make_rig(folder)))


@pytest.fixture(scope="session")
def session(rig: Path) -> Path:
    """That session, not analysed."""
    return rig / "session.h5"
