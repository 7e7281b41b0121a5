"""A process that does not end holds no test up."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest

from tests.processes import ended, last_words

STAYS = "import time; print('here', flush=True); time.sleep(600)"


@pytest.mark.parametrize("wait", [ended, last_words])
def test_what_does_not_end_in_time_is_killed_and_told(wait: Callable[..., Any]) -> None:
    with subprocess.Popen([sys.executable, "-c", STAYS], stdout=subprocess.PIPE) as process:
        with pytest.raises(subprocess.TimeoutExpired):
            wait(process, 0.05)
        assert process.poll() is not None


def test_what_ends_gives_its_code_and_its_last_words() -> None:
    says = "print('the end'); raise SystemExit(3)"
    with subprocess.Popen([sys.executable, "-c", says], stdout=subprocess.PIPE) as process:
        assert last_words(process)[0].strip() == b"the end"
        assert ended(process) == 3
