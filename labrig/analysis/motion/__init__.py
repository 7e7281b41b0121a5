"""From a recorded session to runs from which the sheet in time is identified."""

from labrig.analysis.motion.frames import CURVE_POINTS
from labrig.analysis.motion.record import MotionRecord, motion_record, recorded_runs

__all__ = ["CURVE_POINTS", "MotionRecord", "motion_record", "recorded_runs"]
