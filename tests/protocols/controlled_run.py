"""A controlled run on the fake rig, whose force is 1 mN per volt."""

import numpy as np

from labrig.testing.fake_rig import FakeRig, short_schedule
from protocols.execution.runs.control_loop import FeedbackLaw
from protocols.planning.controlled import controlled
from protocols.planning.schedule import ForceStep

RATE_HZ = 100.0
STEP_N = 1e-3
# 1.5 s at rest, a step of 1 mN, back at 3 s
REFERENCE = (ForceStep(0.0, 0.0), ForceStep(1.5, STEP_N), ForceStep(3.0, 0.0))
DURATION_S = 4.0


def integrator(**changes):
    """u' = u + 100 (r - y) a period: closes a fifth of the error of 1 mN/V in two periods."""
    parts = {
        "A": np.eye(1),
        "B": np.array([[100.0, -100.0]]),
        "C": np.ones(1),
        "D": np.zeros(2),
        "anti_windup": np.ones(1),
        "rate_hz": RATE_HZ,
        "limit_V": 2.0,
        "saturated_s": 0.5,
    }
    return FeedbackLaw(**{**parts, **changes})


def controlled_schedule(reference=REFERENCE, duration_s=DURATION_S):
    return controlled(short_schedule(0.0), "long", 0.0, reference, duration_s)


def run_controlled(rig=None, law=None, reference=REFERENCE, duration_s=DURATION_S, **settings):
    """Return the rig after the run, and its scheduler."""
    rig = rig or FakeRig()
    scheduler = rig.scheduler(feedback=law or integrator(), **settings)
    scheduler.run(controlled_schedule(reference, duration_s))
    return rig, scheduler
