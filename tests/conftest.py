"""Options and fixtures of the whole test suite."""

from __future__ import annotations

import gc
import os
import re
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from tests import compiled_code, system_packages
from tests.fits_unchecked import fits_unchecked
from tests.side_by_side import in_parts, in_turn, is_alone, step_back, watches

# Workers are processes already: threads of linear algebra and of pictures only wait for each other,
# and take up to twice the processor. Said before anything imports numpy or cv2.
for _threads in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"):
    os.environ.setdefault(_threads, "1")

# FFmpeg reads it when a process opens its first video, which may be one that a test opens.
os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")

# A shared, busy machine stalls any example now and then; and a test must not fail by chance alone.
settings.register_profile("labrig", deadline=None, derandomize=True)
settings.load_profile("labrig")

BEGUN = pytest.StashKey[bool]()  # of a worker: it has begun
BEGAN_S = time.time()
GARBAGE = (20_000, 20, 50)  # objects, and passes, before the next one


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--rig", type=Path, help="rig.toml of the rig that real_hardware tests may use"
    )


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Files of thorough or of slow tests alone are not even imported where those are left out."""
    left_out = [mark for mark in ("thorough", "slow") if f"not {mark}" in config.option.markexpr]
    if collection_path.suffix != ".py" or not left_out:
        return None
    if any(collection_path == Path(name.partition("::")[0]).resolve() for name in config.args):
        return None  # asked for by its name: pytest says what it leaves out
    text = collection_path.read_text(encoding="utf-8")
    marked = rf"^pytestmark = (\[\s*)?pytest\.mark\.({'|'.join(left_out)})\b"
    return True if re.search(marked, text, re.MULTILINE) else None


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """What is collected stays to the end: the garbage collector need not look at it ever again.

    Else each of its full passes takes a third of a second, in each worker. It looks more seldom at
    what comes later, too: that is a twentieth of the processor time, and of what reads all modules
    two thirds.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(*GARBAGE)
        gc.enable()


def pytest_itemcollected(item: pytest.Item) -> None:
    system_packages.note(item)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    for line in system_packages.summary(terminalreporter.stats):
        terminalreporter.write_line(line)
    for line in compiled_code.summary(compiled_code.compiled_since(BEGAN_S)):
        terminalreporter.write_line(line)


@pytest.hookimpl(trylast=True)  # when those that are not wanted have gone
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Each in its turn; real hardware is touched only when a rig is named."""
    if all(map(is_alone, items)):
        items[:] = in_turn(items)
    else:
        items[:] = in_parts(items, int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")))
    if config.getoption("--rig") is not None:
        return
    skip = pytest.mark.skip(reason="needs a rig: -m real_hardware --rig rig.toml")
    for item in items:
        if "real_hardware" in item.keywords:
            item.add_marker(skip)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> None:
    """A worker that begins with what computes steps back for those that watch."""
    if "PYTEST_XDIST_WORKER" in os.environ and not item.config.stash.get(BEGUN, False):
        item.config.stash[BEGUN] = True
        if not watches(item):
            step_back()


@pytest.fixture(scope="session", autouse=True)
def one_process() -> Iterator[None]:
    """Workers are processes already: each of them looks for curves in its own, unless asked."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("labrig.report.data.findings.workers", lambda: 1)
        yield


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """No test reads or writes the caches of the user, in this process or in one that it starts."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LABRIG_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="module")
def data_unchecked() -> Iterator[None]:
    """Fits, diagnoses and reports do not look for data stated wrongly: most of their time.

    For modules that test something else; tests/labrig/test_data_warnings.py has that check on.
    """
    with fits_unchecked():
        yield


@pytest.fixture(scope="session")
def rig_file(request: pytest.FixtureRequest) -> Path:
    """The rig.toml given with --rig."""
    path: Path = request.config.getoption("--rig")
    return path
