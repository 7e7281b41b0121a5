"""The devices that docs/howto/devices.md shows keep their contracts, as they stand there."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from drivers import cameras, force_sensors, positioners
from drivers.cameras.conformance import camera_faults
from drivers.force_sensors.conformance import force_sensor_faults
from drivers.interfaces import RealClock
from drivers.positioners.conformance import positioner_faults
from labrig.config.derived import model_of
from sim_hardware.clock import VirtualClock
from sim_hardware.serial_devices import InMemorySerial
from sim_hardware.serial_devices import faults as simulated_faults

PAGE_PATH = Path(__file__).parents[2] / "docs" / "howto" / "devices.md"
PAGE = PAGE_PATH.read_text(encoding="utf-8")


def shown(constant: str) -> Any:
    """The part of the block of code that defines this constant."""
    blocks = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    (code,) = (block for block in blocks if f"\n{constant} =" in block)
    names: dict[str, Any] = {"__name__": f"docs_{constant.lower()}"}
    exec(compile(code, "docs/howto/devices.md", "exec", dont_inherit=True), names)
    return names[constant]


class Line:
    """A serial line to a device that answers each command at once."""

    def __init__(self, answer) -> None:
        self.answer, self.said = answer, b""

    def __call__(self, port: str, **options: object) -> Line:
        return self

    def write(self, data: bytes) -> None:
        self.said += self.answer(data.decode().strip()).encode() + b"\n"

    def read_until(self, end: bytes) -> bytes:
        line, found, self.said = self.said.partition(end)
        return line + found

    def close(self) -> None: ...


@pytest.mark.parametrize(
    ("folder", "constant"),
    [
        (cameras.CAMERAS, "CAMERA"),
        (positioners.POSITIONERS, "POSITIONER"),
        (force_sensors.FORCE_SENSORS, "FORCE_SENSOR"),
    ],
)
def test_each_is_a_kind_whose_settings_make_a_table(folder, constant):
    part = shown(constant)
    assert folder.faults(part) == []
    assert model_of(part.settings, part.kind).model_json_schema()["properties"]["kind"]


def test_the_camera_keeps_the_contract():
    kind, clock = shown("CAMERA"), VirtualClock()
    camera = kind.make(kind.settings(source="bar:"), clock, 25.0)
    assert camera_faults(camera, clock) == []


def test_the_camera_keeps_its_rate_whatever_is_done_between_two_images():
    kind, clock = shown("CAMERA"), VirtualClock()
    capture = kind.make(kind.settings(source="bar:"), clock, 25.0)._factory("bar:")
    began_s = clock.now()
    for _ in range(50):
        clock.sleep_until(clock.now() + 0.015)  # as long as the work takes
        capture.grab()
    assert clock.now() - began_s == pytest.approx(2.0)


def test_the_positioner_keeps_the_contract():
    kind, place_mm = shown("POSITIONER"), [0.0]

    def stepper(command: str) -> str:
        if command.startswith("G "):
            place_mm[0] = float(command[2:])
        return f"{place_mm[0]:.3f}"

    around = SimpleNamespace(transport=Line(stepper))
    stage = kind.make(kind.settings(port="COM1"), around)
    assert positioner_faults(stage, RealClock(), outside_m=0.1) == []


def test_the_positioner_keeps_the_contract_on_the_simulated_stepper_of_the_page_of_worlds():
    page = PAGE_PATH.with_name("world.md").read_text(encoding="utf-8")
    (code,) = (
        one for one in re.findall(r"```python\n(.*?)```", page, re.DOTALL) if "SERIAL" in one
    )
    names: dict[str, Any] = {"__name__": "docs_stepper"}
    exec(compile(code, "docs/howto/world.md", "exec", dont_inherit=True), names)
    assert simulated_faults(names["SERIAL_DEVICE"]) == []
    clock, placed = VirtualClock(), []
    world = SimpleNamespace(place=placed.append)

    def opened(_port: str, **options: Any) -> InMemorySerial:
        return InMemorySerial(names["SERIAL_DEVICE"].make(world, clock, 0), clock, **options)

    kind = shown("POSITIONER")
    stage = kind.make(kind.settings(port="simulated"), SimpleNamespace(transport=opened))
    assert positioner_faults(stage, clock, outside_m=0.1) == []
    assert placed


def test_the_force_sensor_keeps_the_contract():
    kind = shown("FORCE_SENSOR")
    sensor = kind.make(kind.settings(port="COM1"), RealClock(), Line(lambda _command: "12.3"))
    assert force_sensor_faults(sensor, RealClock()) == []


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_the_stand_in_answers_stepper_and_balance(tmp_path):
    (code,) = (one for one in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL) if "pty" in one)
    (tmp_path / "stand_in.py").write_text(code, encoding="utf-8")
    with subprocess.Popen(
        [sys.executable, "-u", "stand_in.py"], cwd=tmp_path, stdout=subprocess.PIPE, text=True
    ) as served:
        try:
            assert served.stdout is not None
            ports = dict(served.stdout.readline().split() for _ in range(2))
            clock, (stage, sensor) = RealClock(), (shown("POSITIONER"), shown("FORCE_SENSOR"))
            around = SimpleNamespace(transport=None, clock=clock)
            stepper = stage.make(stage.settings(port=ports["stepper:"]), around)
            balance = sensor.make(sensor.settings(port=ports["balance:"]), clock, None)
            stepper.open()
            assert stepper.move_to(0.0125)
            assert stepper.position() == pytest.approx(0.0125)
            balance.open()
            assert balance.read_force() == pytest.approx(1.25e-3)
            stepper.close()
            balance.close()
        finally:
            served.kill()
