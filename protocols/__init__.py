"""What happens when: a schedule is plain data, and the scheduler runs one on a clock."""

from protocols.asking import RecordedOperator
from protocols.description import Plan, PlanRow, Timeline, describe, timeline
from protocols.devices import Devices
from protocols.encoding import run_from_dict, run_to_dict, schedule_from_dict, schedule_to_dict
from protocols.errors import ScheduleError
from protocols.hold import Hold
from protocols.hub import EventHub, SubscriberError
from protocols.lateness import Lateness, lateness_of, lateness_s
from protocols.limits import SafetyLimits, check_schedule, time_under_voltage_s
from protocols.planning import Extras, Place, make_schedule
from protocols.pulse_train import PulseTrain
from protocols.rules import Rules, Timing
from protocols.schedule import (
    PlannedReading,
    PlannedRun,
    Purpose,
    ReadingKind,
    Schedule,
    VoltageStep,
)
from protocols.scheduler import Scheduler
from protocols.staircase import Staircase
from protocols.states import FinishReason, RunState, Status
from protocols.step_response import StepResponse
from protocols.stop import StopLevel, StopRequest

__all__ = [
    "Devices",
    "EventHub",
    "Extras",
    "FinishReason",
    "Hold",
    "Lateness",
    "Place",
    "Plan",
    "PlanRow",
    "PlannedReading",
    "PlannedRun",
    "PulseTrain",
    "Purpose",
    "ReadingKind",
    "RecordedOperator",
    "Rules",
    "RunState",
    "SafetyLimits",
    "Schedule",
    "ScheduleError",
    "Scheduler",
    "Staircase",
    "Status",
    "StepResponse",
    "StopLevel",
    "StopRequest",
    "SubscriberError",
    "Timeline",
    "Timing",
    "VoltageStep",
    "check_schedule",
    "describe",
    "lateness_of",
    "lateness_s",
    "make_schedule",
    "run_from_dict",
    "run_to_dict",
    "schedule_from_dict",
    "schedule_to_dict",
    "time_under_voltage_s",
    "timeline",
]
