"""Run, record and understand force and shape experiments on ionic-polymer actuator sheets.

The names below are what other people's code may rely on. Each is loaded when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from labrig.lazy_imports import lazily
from labrig.own_packages import require_own_packages

if TYPE_CHECKING:
    from labrig.analysis import analyze as analyze
    from labrig.cli.command import Command as Command
    from labrig.model_file import load_model as load_model
    from labrig.model_file import save_model as save_model
    from labrig.session import load_measurements as load_measurements
    from labrig.session import open_session as open_session
    from labrig.session import read_tables as read_tables
    from labrig.vision import NeutralCurve as NeutralCurve
    from labrig.vision import Optics as Optics
    from labrig.vision import StripGeometry as StripGeometry
    from labrig.vision import Tracker as Tracker
    from labrig.vision import neutral_curve as neutral_curve
    from model import FitOptions as FitOptions
    from model import Measurements as Measurements
    from model import SheetModel as SheetModel
    from model import fit as fit
    from model import predict as predict

_HOMES = {
    "labrig.analysis": ("analyze",),
    "labrig.cli.command": ("Command",),
    "labrig.model_file": ("load_model", "save_model"),
    "labrig.session": ("load_measurements", "open_session", "read_tables"),
    "labrig.vision": ("NeutralCurve", "Optics", "StripGeometry", "Tracker", "neutral_curve"),
    "model": ("FitOptions", "Measurements", "SheetModel", "fit", "predict"),
}
__getattr__, __dir__, __all__ = lazily(__name__, _HOMES, before=require_own_packages)
