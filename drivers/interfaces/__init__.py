"""What the rest of labrig may expect of a piece of hardware, and of time.

Each interface is a `typing.Protocol`: it says when a method is called, how long it may block and
what it may raise. Drivers of real devices fulfil them; the simulator stands behind the drivers, at
the wire, so nothing here knows of it. All quantities are SI: V, N, m, s, rad.
"""

from drivers.interfaces.camera import (
    FREE,
    HARDWARE,
    SOFTWARE,
    AcquisitionSettings,
    Camera,
    CameraCounts,
    Frame,
    FrameTrigger,
    GreyImage,
    TriggerPulse,
    TriggersFrames,
)
from drivers.interfaces.clock import (
    Clock,
    RealClock,
    ThreadHandle,
)
from drivers.interfaces.errors import (
    DeviceError,
    DeviceNotFoundError,
    DeviceTimeoutError,
    LimitError,
    LostSamplesError,
    OverloadError,
    OvervoltageError,
    behind,
    in_words,
    is_mistake,
)
from drivers.interfaces.identity import (
    DeviceIdentity,
    Identified,
)
from drivers.interfaces.inputs import (
    FORCE_GAP_S,
    FloatArray,
    ForceSensor,
    InterpolatedForce,
    SampleClock,
    SignalBlock,
    SignalInput,
)
from drivers.interfaces.operator import (
    LimitedTravel,
    Operator,
    Positioner,
    Prompt,
)
from drivers.interfaces.output import (
    Interlock,
    TimedOutput,
    TimedVoltage,
    VoltageOutput,
    VoltageWrite,
)
from drivers.interfaces.reserved_names import is_reserved

__all__ = [
    "FORCE_GAP_S",
    "FREE",
    "HARDWARE",
    "SOFTWARE",
    "AcquisitionSettings",
    "Camera",
    "CameraCounts",
    "Clock",
    "DeviceError",
    "DeviceIdentity",
    "DeviceNotFoundError",
    "DeviceTimeoutError",
    "FloatArray",
    "ForceSensor",
    "Frame",
    "FrameTrigger",
    "GreyImage",
    "Identified",
    "Interlock",
    "InterpolatedForce",
    "LimitError",
    "LimitedTravel",
    "LostSamplesError",
    "Operator",
    "OverloadError",
    "OvervoltageError",
    "Positioner",
    "Prompt",
    "RealClock",
    "SampleClock",
    "SignalBlock",
    "SignalInput",
    "ThreadHandle",
    "TimedOutput",
    "TimedVoltage",
    "TriggerPulse",
    "TriggersFrames",
    "VoltageOutput",
    "VoltageWrite",
    "behind",
    "in_words",
    "is_mistake",
    "is_reserved",
]
