"""What happens when: a schedule is plain data, and the scheduler runs one on a clock."""

from protocols.encoding import run_from_dict, run_to_dict, schedule_from_dict, schedule_to_dict
from protocols.errors import ScheduleError
from protocols.hold import Hold
from protocols.lateness import Lateness, lateness_of, lateness_s
from protocols.limits import SafetyLimits, check_schedule, time_under_voltage_s
from protocols.planning import Extras, Place, make_schedule
from protocols.pulse_train import PulseTrain
from protocols.schedule import (
    PlannedReading,
    PlannedRun,
    Purpose,
    ReadingKind,
    Schedule,
    VoltageStep,
)
from protocols.staircase import Staircase
from protocols.step_response import StepResponse

__all__ = [
    "Extras",
    "Hold",
    "Lateness",
    "Place",
    "PlannedReading",
    "PlannedRun",
    "PulseTrain",
    "Purpose",
    "ReadingKind",
    "SafetyLimits",
    "Schedule",
    "ScheduleError",
    "Staircase",
    "StepResponse",
    "VoltageStep",
    "check_schedule",
    "lateness_of",
    "lateness_s",
    "make_schedule",
    "run_from_dict",
    "run_to_dict",
    "schedule_from_dict",
    "schedule_to_dict",
    "time_under_voltage_s",
]
