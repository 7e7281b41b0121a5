"""A simulated rig's folder and a panel on it."""

from __future__ import annotations

import shutil

import pytest

from labrig.config.templates import write_templates
from tests.end_to_end.small_rig import two_positions
from tests.labrig.panel.page import panel

SHORT = """
moisten = true
[pulse_train]
zero_readings = 2
readings_per_voltage = {readings}
[[places]]
configuration = "long"
positions_mm = [10]
[extras]
mode = "paper"
"""


@pytest.fixture(scope="module")
def rig_folder(tmp_path_factory):
    """rig.toml and its files; `short.toml` takes 5 s, `middle.toml` 16 s, `long.toml` 20 s."""
    folder = tmp_path_factory.mktemp("panel") / "rig"
    write_templates(folder, simulated=True)
    (folder / "short.toml").write_text(SHORT.format(readings=3))
    (folder / "middle.toml").write_text(SHORT.format(readings=14))
    (folder / "long.toml").write_text(SHORT.format(readings=18))
    return folder


@pytest.fixture(scope="module")
def server(rig_folder):
    """A panel for all tests of a file, and a lean one: see `Server`."""
    with panel(rig_folder / "rig.toml", lean=True) as found:
        yield found


@pytest.fixture
def session(tmp_path_factory, tmp_path):
    """A session on the simulated rig with frames, not analysed, in a folder of its own."""
    shutil.copy(two_positions(tmp_path_factory), tmp_path)
    return tmp_path / "session.h5"
