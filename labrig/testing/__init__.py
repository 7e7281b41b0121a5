"""What tests of other people's parts need: the conformance functions and a fake rig.

A conformance function of a kind of part returns what is wrong with a part, a sentence each:
`assert labrig.testing.command_faults(COMMAND) == []`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from labrig.lazy_imports import lazily
from labrig.own_packages import require_own_packages

if TYPE_CHECKING:
    from labrig.testing.conformance import batch_task_faults as batch_task_faults
    from labrig.testing.conformance import board_kind_faults as board_kind_faults
    from labrig.testing.conformance import camera_faults as camera_faults
    from labrig.testing.conformance import camera_kind_faults as camera_kind_faults
    from labrig.testing.conformance import command_faults as command_faults
    from labrig.testing.conformance import connection_faults as connection_faults
    from labrig.testing.conformance import curve_check_faults as curve_check_faults
    from labrig.testing.conformance import curve_extractor_faults as curve_extractor_faults
    from labrig.testing.conformance import curve_faults as curve_faults
    from labrig.testing.conformance import data_check_faults as data_check_faults
    from labrig.testing.conformance import dynamic_model_faults as dynamic_model_faults
    from labrig.testing.conformance import effect_faults as effect_faults
    from labrig.testing.conformance import export_format_faults as export_format_faults
    from labrig.testing.conformance import extra_faults as extra_faults
    from labrig.testing.conformance import family_faults as family_faults
    from labrig.testing.conformance import force_sensor_faults as force_sensor_faults
    from labrig.testing.conformance import force_sensor_kind_faults as force_sensor_kind_faults
    from labrig.testing.conformance import interlock_faults as interlock_faults
    from labrig.testing.conformance import location_faults as location_faults
    from labrig.testing.conformance import output_faults as output_faults
    from labrig.testing.conformance import page_content_faults as page_content_faults
    from labrig.testing.conformance import page_faults as page_faults
    from labrig.testing.conformance import positioner_faults as positioner_faults
    from labrig.testing.conformance import positioner_kind_faults as positioner_kind_faults
    from labrig.testing.conformance import protocol_faults as protocol_faults
    from labrig.testing.conformance import read_back_faults as read_back_faults
    from labrig.testing.conformance import reading_pattern_faults as reading_pattern_faults
    from labrig.testing.conformance import rescue_faults as rescue_faults
    from labrig.testing.conformance import section_content_faults as section_content_faults
    from labrig.testing.conformance import section_faults as section_faults
    from labrig.testing.conformance import signal_faults as signal_faults
    from labrig.testing.conformance import simple_board_faults as simple_board_faults
    from labrig.testing.conformance import simulated_board_faults as simulated_board_faults
    from labrig.testing.conformance import simulated_family_faults as simulated_family_faults
    from labrig.testing.conformance import (
        simulated_serial_device_faults as simulated_serial_device_faults,
    )
    from labrig.testing.conformance import strip_fact_faults as strip_fact_faults
    from labrig.testing.conformance import timed_output_faults as timed_output_faults
    from labrig.testing.conformance import verdict_check_faults as verdict_check_faults
    from labrig.testing.fake_rig import FakeRig as FakeRig
    from labrig.testing.fake_rig import short_schedule as short_schedule

_HOMES = {
    "labrig.testing.conformance": (
        "batch_task_faults",
        "family_faults",
        "board_kind_faults",
        "camera_faults",
        "camera_kind_faults",
        "command_faults",
        "connection_faults",
        "curve_faults",
        "data_check_faults",
        "verdict_check_faults",
        "dynamic_model_faults",
        "effect_faults",
        "export_format_faults",
        "extra_faults",
        "curve_check_faults",
        "curve_extractor_faults",
        "force_sensor_faults",
        "force_sensor_kind_faults",
        "interlock_faults",
        "location_faults",
        "output_faults",
        "page_content_faults",
        "page_faults",
        "positioner_faults",
        "positioner_kind_faults",
        "protocol_faults",
        "read_back_faults",
        "reading_pattern_faults",
        "rescue_faults",
        "strip_fact_faults",
        "timed_output_faults",
        "section_content_faults",
        "section_faults",
        "signal_faults",
        "simple_board_faults",
        "simulated_board_faults",
        "simulated_family_faults",
        "simulated_serial_device_faults",
    ),
    "labrig.testing.fake_rig": ("FakeRig", "short_schedule"),
}
__getattr__, __dir__, __all__ = lazily(__name__, _HOMES, before=require_own_packages)
