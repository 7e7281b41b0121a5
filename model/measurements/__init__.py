"""`Measurements`: the one table between the rig and the model, and how it is shown and exported."""

from model.measurements.checked_values import (
    is_number,
    require_number,
    require_truth,
    require_whole_number,
)
from model.measurements.columns import Columns, MissingPandasError, dataframe
from model.measurements.data import (
    CameraUncertainty,
    Condition,
    Contact,
    Curve,
    FloatArray,
    Kind,
    Measurements,
    ModelError,
    Reading,
    SheetGeometry,
    TimeSeries,
    is_at,
)
from model.measurements.display import Displayed, Summary, in_decimals, in_digits, in_volts, signed
from model.measurements.geometry_difference import GeometryDifference, geometry_difference
from model.measurements.progress import Progress, silent
from model.measurements.rms import rms
from model.measurements.scale import (
    RigScale,
    length_scale,
    load_scale,
    scale_of,
    scale_of_measurements,
)
from model.measurements.well_formed import require_well_formed

__all__ = [
    "CameraUncertainty",
    "Columns",
    "Condition",
    "Contact",
    "Curve",
    "Displayed",
    "FloatArray",
    "GeometryDifference",
    "Kind",
    "Measurements",
    "MissingPandasError",
    "ModelError",
    "Progress",
    "Reading",
    "RigScale",
    "SheetGeometry",
    "Summary",
    "TimeSeries",
    "dataframe",
    "geometry_difference",
    "in_decimals",
    "in_digits",
    "in_volts",
    "is_at",
    "is_number",
    "length_scale",
    "load_scale",
    "require_number",
    "require_truth",
    "require_well_formed",
    "require_whole_number",
    "rms",
    "scale_of",
    "scale_of_measurements",
    "signed",
    "silent",
]
