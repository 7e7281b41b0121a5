"""What labrig.testing offers to tests of other people's parts."""

from __future__ import annotations

import subprocess
import sys

import pytest

from drivers.interfaces import Camera, Clock, Operator, Positioner, SignalInput, VoltageOutput
from labrig import testing
from labrig.cli.commands.plan import COMMAND
from protocols.execution.events import ReadingTaken


def test_a_conformance_function_names_what_is_wrong_and_nothing_else() -> None:
    assert testing.command_faults(COMMAND) == []
    assert testing.command_faults("plan") == ["COMMAND is a str, not a labrig.Command"]


KINDS = [
    "board_kind_faults",
    "camera_kind_faults",
    "command_faults",
    "dynamic_model_faults",
    "effect_faults",
    "extra_faults",
    "curve_check_faults",
    "curve_extractor_faults",
    "force_sensor_kind_faults",
    "data_check_faults",
    "location_faults",
    "page_faults",
    "positioner_kind_faults",
    "protocol_faults",
    "reading_pattern_faults",
    "section_faults",
    "simulated_board_faults",
    "simulated_family_faults",
    "simulated_serial_device_faults",
    "strip_fact_faults",
    "verdict_check_faults",
]


@pytest.mark.parametrize("name", KINDS)
def test_each_conformance_function_answers_in_sentences_what_is_no_part_at_all(name: str) -> None:
    found = getattr(testing, name)(object())
    assert found
    assert all(isinstance(sentence, str) and sentence for sentence in found)


def test_a_wrong_call_of_a_conformance_function_is_no_fault_of_the_part() -> None:
    said = r"'clock'; call it as positioner_faults\(positioner, clock, positions_m, outside_m"
    with pytest.raises(TypeError, match=said):
        testing.positioner_faults(object())


def test_the_fake_rig_runs_a_schedule_and_ends_at_0_V() -> None:
    rig = testing.FakeRig()
    schedule = testing.short_schedule(0.01)
    rig.scheduler().run(schedule)
    assert len(rig.of_kind(ReadingTaken)) == len(schedule.runs[0].readings)
    assert rig.output.last_V == 0.0


def test_the_fake_devices_have_the_drivers_interfaces() -> None:
    rig = testing.FakeRig()
    output: VoltageOutput = rig.output
    signals: SignalInput = rig.signals
    camera: Camera = rig.camera
    stage: Positioner = rig.stage
    operator: Operator = rig.operator
    clock: Clock = rig.clock
    for device in (output, signals, camera, stage):
        device.open()
    assert clock.now() > 0.0
    assert hasattr(operator, "ask")


@pytest.mark.slow
def test_what_runs_an_experiment_loads_neither_the_test_tools_nor_models() -> None:
    code = (
        "import sys, labrig.cli.main, labrig.cli.follow; "
        "print({'labrig.testing', 'model.sheet', 'model.effects'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout == "set()\n"
