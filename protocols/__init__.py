"""What happens when: a schedule is plain data, and the scheduler runs one on a clock."""

from protocols.errors import ScheduleError
from protocols.execution.channels import Channel
from protocols.execution.devices import Devices
from protocols.execution.event_bus import EventBus, SubscriberError
from protocols.execution.lateness import Lateness, lateness_of, lateness_s
from protocols.execution.operator import RecordedOperator
from protocols.execution.rules import Rules
from protocols.execution.scheduler import Scheduler
from protocols.execution.states import FinishReason, RunState, Status
from protocols.execution.stop import StopLevel, StopRequest
from protocols.extras.contract import Extra
from protocols.kinds.contract import ProtocolKind
from protocols.planning.description import (
    PlanRow,
    ScheduleDescription,
    Timeline,
    describe,
    free_shapes_in_words,
    timeline,
)
from protocols.planning.encoding import (
    run_from_dict,
    run_to_dict,
    schedule_from_dict,
    schedule_to_dict,
)
from protocols.planning.limits import (
    SafetyLimits,
    check_schedule,
    positions_m,
    time_under_voltage_s,
)
from protocols.planning.loop_timing import LoopTiming
from protocols.planning.schedule import (
    PlannedMove,
    PlannedReading,
    PlannedRun,
    Purpose,
    ReadingKind,
    Schedule,
    VoltageStep,
)
from protocols.session_schedule import Extras, Place, make_schedule

__all__ = [
    "Channel",
    "Devices",
    "EventBus",
    "Extra",
    "Extras",
    "FinishReason",
    "Lateness",
    "LoopTiming",
    "Place",
    "PlanRow",
    "PlannedMove",
    "PlannedReading",
    "PlannedRun",
    "ProtocolKind",
    "Purpose",
    "ReadingKind",
    "RecordedOperator",
    "Rules",
    "RunState",
    "SafetyLimits",
    "Schedule",
    "ScheduleDescription",
    "ScheduleError",
    "Scheduler",
    "Status",
    "StopLevel",
    "StopRequest",
    "SubscriberError",
    "Timeline",
    "VoltageStep",
    "check_schedule",
    "describe",
    "free_shapes_in_words",
    "lateness_of",
    "lateness_s",
    "make_schedule",
    "positions_m",
    "run_from_dict",
    "run_to_dict",
    "schedule_from_dict",
    "schedule_to_dict",
    "time_under_voltage_s",
    "timeline",
]
