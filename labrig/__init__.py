"""Run, record and understand force and shape experiments on ionic-polymer actuator sheets.

The names below are what other people's code may rely on: what evaluates a session, and the contract
of each kind of part that can be added. Each is loaded when it is first used; `labrig.testing` has
what tests of such parts need.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig.lazy_imports import lazily
from labrig.own_packages import require_own_packages

if TYPE_CHECKING:
    from drivers.boards.contract import BoardConnection as BoardConnection
    from drivers.boards.contract import BoardFamily as BoardFamily
    from drivers.cameras.contract import CameraKind as CameraKind
    from drivers.force_sensors.contract import ForceSensorKind as ForceSensorKind
    from drivers.interfaces import Camera as Camera
    from drivers.interfaces import ForceSensor as ForceSensor
    from drivers.interfaces import Positioner as Positioner
    from drivers.interfaces import SignalInput as SignalInput
    from drivers.interfaces import VoltageOutput as VoltageOutput
    from drivers.plugins import Part as Part
    from drivers.plugins import PluginFolder as PluginFolder
    from drivers.plugins import PluginWarning as PluginWarning
    from drivers.plugins import UnknownPartError as UnknownPartError
    from drivers.positioners.contract import PositionerKind as PositionerKind
    from labrig import plot as plot
    from labrig.analysis import analyze as analyze
    from labrig.api.compare import ModelComparison as ModelComparison
    from labrig.api.compare import compare as compare
    from labrig.api.design import Design as Design
    from labrig.api.design import design as design
    from labrig.api.design import map_of_elongation as map_of_elongation
    from labrig.api.diagnose import diagnose as diagnose
    from labrig.api.fit import fit as fit
    from labrig.api.fit_in_time import FitInTime as FitInTime
    from labrig.api.fit_in_time import fit_in_time as fit_in_time
    from labrig.api.next_in_time import NextRuns as NextRuns
    from labrig.api.next_in_time import next_in_time as next_in_time
    from labrig.api.next_measurement import NextMeasurement as NextMeasurement
    from labrig.api.next_measurement import next_measurement as next_measurement
    from labrig.api.run import run as run
    from labrig.api.sheet import sheet as sheet
    from labrig.api.simulate import SimulatedConditions as SimulatedConditions
    from labrig.api.simulate import predict as predict
    from labrig.api.simulate import simulate as simulate
    from labrig.api.simulate import simulate_in_time as simulate_in_time
    from labrig.api.tables import measurements_of_tables as measurements_of_tables
    from labrig.cli.command import Command as Command
    from labrig.cli.command import CommandExample as CommandExample
    from labrig.errors import BadInputError as BadInputError
    from labrig.errors import LabrigError as LabrigError
    from labrig.errors import LabrigWarning as LabrigWarning
    from labrig.exports.choice import export as export
    from labrig.exports.contract import ExportFormat as ExportFormat
    from labrig.extractors.contract import CurveExtractor as CurveExtractor
    from labrig.model_file import load_model as load_model
    from labrig.model_file import save_model as save_model
    from labrig.panel.pages.interface import PanelPage as PanelPage
    from labrig.report.sections.interface import ReportSection as ReportSection
    from labrig.session import Note as Note
    from labrig.session import add_note as add_note
    from labrig.session import load_measurements as load_measurements
    from labrig.session import open_session as open_session
    from labrig.session import read_tables as read_tables
    from labrig.vision import NeutralCurve as NeutralCurve
    from labrig.vision import Optics as Optics
    from labrig.vision import StripGeometry as StripGeometry
    from labrig.vision import Tracker as Tracker
    from labrig.vision import load_optics as load_optics
    from labrig.vision import neutral_curve as neutral_curve
    from labrig.vision import read_image as read_image
    from labrig.vision.checks.contract import CurveCheck as CurveCheck
    from labrig.vision.facts.contract import StripFact as StripFact
    from model import Fit as Fit
    from model import FitOptions as FitOptions
    from model import Measurements as Measurements
    from model import ModelError as ModelError
    from model import Prediction as Prediction
    from model import PredictionArray as PredictionArray
    from model import SheetModel as SheetModel
    from model.discrepancy import DiagnoseOptions as DiagnoseOptions
    from model.discrepancy import Diagnosis as Diagnosis
    from model.discrepancy.criticism.contract import VerdictCheck as VerdictCheck
    from model.discrepancy.data_checks.contract import DataCheck as DataCheck
    from model.effects import Effect as Effect
    from model.effects import EffectParameter as EffectParameter
    from model.locations.contract import Location as Location
    from protocols import Extra as Extra
    from protocols import ProtocolKind as ProtocolKind
    from sim_hardware.ni.boards import BoardModel as BoardModel

_HOMES = {
    "drivers.boards.contract": (
        "BoardConnection",
        "BoardFamily",
    ),
    "drivers.cameras.contract": ("CameraKind",),
    "drivers.force_sensors.contract": ("ForceSensorKind",),
    "drivers.interfaces": (
        "Camera",
        "ForceSensor",
        "Positioner",
        "SignalInput",
        "VoltageOutput",
    ),
    "drivers.plugins": (
        "Part",
        "PluginFolder",
        "PluginWarning",
        "UnknownPartError",
    ),
    "drivers.positioners.contract": ("PositionerKind",),
    "labrig.analysis": ("analyze",),
    "labrig.api.compare": (
        "ModelComparison",
        "compare",
    ),
    "labrig.api.design": (
        "Design",
        "design",
        "map_of_elongation",
    ),
    "labrig.api.diagnose": ("diagnose",),
    "labrig.api.fit": ("fit",),
    "labrig.api.fit_in_time": (
        "FitInTime",
        "fit_in_time",
    ),
    "labrig.api.next_in_time": (
        "NextRuns",
        "next_in_time",
    ),
    "labrig.api.next_measurement": (
        "NextMeasurement",
        "next_measurement",
    ),
    "labrig.api.run": ("run",),
    "labrig.api.sheet": ("sheet",),
    "labrig.api.simulate": (
        "SimulatedConditions",
        "predict",
        "simulate",
        "simulate_in_time",
    ),
    "labrig.api.tables": ("measurements_of_tables",),
    "labrig.cli.command": (
        "Command",
        "CommandExample",
    ),
    "labrig.errors": (
        "BadInputError",
        "LabrigError",
        "LabrigWarning",
    ),
    "labrig.exports.choice": ("export",),
    "labrig.exports.contract": ("ExportFormat",),
    "labrig.extractors.contract": ("CurveExtractor",),
    "labrig.model_file": (
        "load_model",
        "save_model",
    ),
    "labrig.panel.pages.interface": ("PanelPage",),
    "labrig.report.sections.interface": ("ReportSection",),
    "labrig.session": (
        "Note",
        "add_note",
        "load_measurements",
        "open_session",
        "read_tables",
    ),
    "labrig.vision": (
        "NeutralCurve",
        "Optics",
        "StripGeometry",
        "Tracker",
        "load_optics",
        "neutral_curve",
        "read_image",
    ),
    "labrig.vision.checks.contract": ("CurveCheck",),
    "labrig.vision.facts.contract": ("StripFact",),
    "model": (
        "Fit",
        "FitOptions",
        "Measurements",
        "ModelError",
        "Prediction",
        "PredictionArray",
        "SheetModel",
    ),
    "model.discrepancy": (
        "DiagnoseOptions",
        "Diagnosis",
    ),
    "model.discrepancy.criticism.contract": ("VerdictCheck",),
    "model.discrepancy.data_checks.contract": ("DataCheck",),
    "model.effects": (
        "Effect",
        "EffectParameter",
    ),
    "model.locations.contract": ("Location",),
    "protocols": (
        "Extra",
        "ProtocolKind",
    ),
    "sim_hardware.ni.boards": ("BoardModel",),
}


def _command(name: str) -> str:
    """Return that a name is a command alone, where it is; the file tells without importing it."""
    file = Path(__file__).parent / "cli" / "commands" / f"{name}.py"
    is_one = not name.startswith("_") and file.is_file()
    return f"; on the command line it is `labrig {name}`" if is_one else ""


_load, __dir__, __all__ = lazily(
    __name__, _HOMES, modules=("plot",), before=require_own_packages, elsewhere=_command
)


def __getattr__(name: str) -> Any:
    if name == "__version__":  # as other packages have it; what is installed is read when asked for
        from labrig.version import version

        return version()
    return _load(name)
