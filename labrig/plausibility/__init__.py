"""Plausibility checks: values that are allowed and can hardly be meant.

A limit that must hold stands in the configuration models and in `protocols.planning.limits`. Here a
check yields a sentence, or a `Check`: a warning for what is unusual, a fault for what nobody can
mean, such as lengths in metres. Asked by imports of tables, `check`, `plan`, and before a run.
"""

from labrig.plausibility.calibration import calibration_age
from labrig.plausibility.set_up import SetUp, set_up_checks
from labrig.plausibility.tables import field_warnings, table_warnings

__all__ = ["SetUp", "calibration_age", "field_warnings", "set_up_checks", "table_warnings"]
