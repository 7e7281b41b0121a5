"""A kind of protocol that comes with another distribution is used like labrig's own."""

from __future__ import annotations

import sys

import pytest

from drivers.plugins import PluginWarning
from labrig.cli.main import run
from labrig.config import PROTOCOLS, parse_protocol
from labrig.config.schema import schemas
from labrig.errors import BadInputError
from labrig.experiment.resume import resumed_plan
from labrig.panel.core.configuration_files import kind_of
from labrig.report.tables.overview import overview
from labrig.session import open_session
from labrig.session.format.setup import present_versions
from tests.end_to_end.small_rig import make_rig, run_rig

FLASH = '''
"""One short pulse."""

from dataclasses import dataclass
from typing import ClassVar

from protocols import ProtocolKind, ReadingKind
from protocols.kinds.fields import duration, voltage
from protocols.planning.builder import Builder


@dataclass(frozen=True, kw_only=True)
class Flash(ProtocolKind):
    """One short pulse."""

    name: ClassVar[str] = "flash"
    voltage_V: float = voltage(1.0, "of the pulse")
    pulse_s: float = duration(0.2, "length of the pulse")

    def steps_and_readings(self):
        run = Builder()
        run.step(self.voltage_V, self.pulse_s)
        run.reading(self.pulse_s / 2, 0.01, ReadingKind.KEPT)
        return run.finish()
'''
TEXT = """[flash]
voltage_V = 1.5
[[places]]
configuration = "long"
positions_mm = [0.0]
[extras]
mode = "paper"
"""


@pytest.fixture
def installed(tmp_path, monkeypatch):
    def install(code: str) -> None:
        (tmp_path / "flash_protocol.py").write_text(code)
        info = tmp_path / "flash_protocol-1.2.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(
            "Metadata-Version: 2.1\nName: flash-protocol\nVersion: 1.2\n"
        )
        (info / "entry_points.txt").write_text("[labrig.protocols]\nflash = flash_protocol:Flash\n")

    monkeypatch.syspath_prepend(tmp_path)
    yield install
    sys.modules.pop("flash_protocol", None)


@pytest.mark.slow
def test_an_installed_protocol_is_planned_and_has_a_form_and_a_version(installed, tmp_path, capsys):
    installed(FLASH)
    steps = parse_protocol(TEXT, "protocol.toml").schedule("protocol.toml").runs[0].steps
    assert [(s.time_s, s.voltage_V) for s in steps] == [(0.0, 1.5), (0.2, 0.0)]
    schema = schemas()["protocol"]
    assert "flash" in schema["properties"]
    assert schema["$defs"]["Flash"]["properties"]["pulse_s"]["description"] == "length of the pulse"
    assert kind_of(TEXT, ".toml") == "protocol"
    assert present_versions()["flash-protocol"] == "1.2"
    path = tmp_path / "protocol.toml"
    path.write_text(TEXT)
    assert run(["plan", str(path)]) == 0
    assert "1.5" in capsys.readouterr().out


def test_an_installed_protocol_that_does_not_conform_is_left_out_with_a_sentence(installed):
    installed(FLASH.replace("return run.finish()", "return run.finish()[0][:1], (), 0.2"))
    with pytest.warns(PluginWarning, match="'flash' of flash-protocol .*leaves 1 V at the sheet"):
        assert "flash" not in PROTOCOLS.parts()


def test_an_installed_protocol_that_returns_no_run_is_named(installed):
    broken = FLASH.replace(
        "return run.finish()", "return run.finish() if self.pulse_s < 1 else None"
    )
    installed(broken)
    schedule = parse_protocol(TEXT.replace("1.5", "1.5\npulse_s = 2.0"), "protocol.toml")
    with pytest.raises(BadInputError, match="flash: its steps_and_readings returned NoneType"):
        schedule.schedule("protocol.toml")


def test_a_protocol_whose_run_has_no_finite_voltage_is_not_planned(installed, tmp_path, capsys):
    installed(
        FLASH.replace("run.step(self.voltage_V,", "run.step(self.voltage_V * share(self.pulse_s),")
        + "\n\ndef share(pulse_s):\n    return 1.0 if pulse_s < 1 else float('nan')\n"
    )
    path = tmp_path / "protocol.toml"
    path.write_text(TEXT.replace("1.5", "1.5\npulse_s = 2.0"))
    assert run(["plan", str(path)]) == 2
    said = capsys.readouterr()
    assert said.err.endswith("run 1 (long at 0 mm): a time or a voltage is not a finite number.\n")
    assert "nan" not in said.out


@pytest.mark.slow
def test_a_session_names_who_its_protocol_is_from_where_that_is_no_longer_installed(
    installed, tmp_path, monkeypatch
):
    installed(FLASH)
    rig = make_rig(tmp_path / "rig", TEXT)
    session_path = run_rig(rig)
    with open_session(session_path) as session:
        assert session.versions["protocols.flash"] == "flash-protocol 1.2"
        assert ("other parts", "flash (flash-protocol 1.2)") in overview(session).facts
        assert resumed_plan(session).schedule.protocol == "flash"
        monkeypatch.setattr(sys, "path", [p for p in sys.path if p != str(tmp_path)])
        with pytest.raises(
            BadInputError, match=r"protocols\.flash of flash-protocol 1\.2; install"
        ):
            resumed_plan(session)
