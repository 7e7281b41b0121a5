"""The conformance functions, under one name each.

Those of a kind of part take the part alone: the loader runs them, too, but for what takes long.
Those of a device or of an answer (`camera_faults`, `signal_faults`, `curve_faults` ...) take a
device, or an answer. None of them raises what the part's own code raises, or waits for a call that
does not return: these are faults.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import signature
from typing import ParamSpec

from drivers.boards.conformance import (
    connection_faults,
    family_faults,
    interlock_faults,
    output_faults,
    rescue_faults,
    signal_faults,
    timed_output_faults,
)
from drivers.boards.contract import faults as board_kind_faults
from drivers.boards.read_back_conformance import read_back_faults
from drivers.boards.simple.conformance import simple_board_faults
from drivers.cameras.conformance import camera_faults
from drivers.cameras.contract import faults as camera_kind_faults
from drivers.force_sensors.conformance import force_sensor_faults
from drivers.force_sensors.contract import faults as force_sensor_kind_faults
from drivers.plugins import first_faults
from drivers.positioners.conformance import positioner_faults
from drivers.positioners.contract import faults as positioner_kind_faults
from labrig.batch.conformance import faults as batch_task_faults
from labrig.cli.command import faults as command_faults
from labrig.exports.conformance import faults as export_format_faults
from labrig.extractors.conformance import faults as curve_extractor_faults
from labrig.extractors.conformance import faults_of_curve as curve_faults
from labrig.panel.pages.conformance import content_faults as page_content_faults
from labrig.panel.pages.conformance import faults as page_faults
from labrig.report.sections.conformance import content_faults as section_content_faults
from labrig.report.sections.conformance import faults as section_faults
from labrig.testing.blocking import returned
from labrig.testing.drawn_curves import curve_check_faults
from labrig.testing.settling import effect_faults
from labrig.testing.times_in_ms import extra_faults, protocol_faults
from labrig.vision.facts.conformance import faults as strip_fact_faults
from model.discrepancy.criticism.conformance import faults as verdict_check_faults
from model.discrepancy.data_checks.conformance import faults as data_check_faults
from model.dynamics.models.conformance import faults as dynamic_model_faults
from model.identification.reading_patterns.conformance import faults as reading_pattern_faults
from model.locations.conformance import faults as location_faults
from sim_hardware.families.contract import faults as simulated_family_faults
from sim_hardware.ni.boards import faults as simulated_board_faults
from sim_hardware.serial_devices.contract import faults as simulated_serial_device_faults

__all__ = [
    "batch_task_faults",
    "board_kind_faults",
    "camera_faults",
    "camera_kind_faults",
    "command_faults",
    "connection_faults",
    "curve_check_faults",
    "curve_extractor_faults",
    "curve_faults",
    "data_check_faults",
    "dynamic_model_faults",
    "effect_faults",
    "export_format_faults",
    "extra_faults",
    "family_faults",
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
    "section_content_faults",
    "section_faults",
    "signal_faults",
    "simple_board_faults",
    "simulated_board_faults",
    "simulated_family_faults",
    "simulated_serial_device_faults",
    "strip_fact_faults",
    "timed_output_faults",
    "verdict_check_faults",
]

_P = ParamSpec("_P")


def _never_raising(name: str, faults: Callable[_P, list[str]]) -> Callable[_P, list[str]]:
    """Return a conformance function of which what a part raises is one of the faults.

    And a call that does not return. Those of a device wait by a clock, and watch each call.
    A wrong call of the function itself is the caller's TypeError, and no fault of the part.
    """
    wanted = signature(faults)
    has_clock = "clock" in wanted.parameters

    @wraps(faults)
    def found(*args: _P.args, **kwargs: _P.kwargs) -> list[str]:
        try:
            wanted.bind(*args, **kwargs)
        except TypeError as error:
            called = ", ".join(wanted.parameters)
            raise TypeError(f"{error}; call it as {name}({called})") from None

        def judged() -> list[str]:
            return first_faults([lambda: faults(*args, **kwargs)])

        return judged() if has_clock else returned(judged)

    return found


globals().update({name: _never_raising(name, globals()[name]) for name in __all__})
