"""rig.toml, sheet.toml, protocol.toml, about.toml and calibrations as validated objects."""

from labrig.config.about import About, load_about, parse_about, recorded_about
from labrig.config.base import parse_json, parse_toml, read_bytes, read_text
from labrig.config.load_cell import load_load_cell, parse_load_cell, recorded_calibration
from labrig.config.protocol import EXTRAS, PROTOCOLS, ProtocolConfig, parse_protocol
from labrig.config.rig import (
    OutputConfig,
    ReplayConfig,
    RigConfig,
    load_output,
    load_rig,
    parse_rig,
    with_paths_from,
)
from labrig.config.sheet import load_sheet, parse_sheet

__all__ = [
    "EXTRAS",
    "PROTOCOLS",
    "About",
    "OutputConfig",
    "ProtocolConfig",
    "ReplayConfig",
    "RigConfig",
    "load_about",
    "load_load_cell",
    "load_output",
    "load_rig",
    "load_sheet",
    "parse_about",
    "parse_json",
    "parse_load_cell",
    "parse_protocol",
    "parse_rig",
    "parse_sheet",
    "parse_toml",
    "read_bytes",
    "read_text",
    "recorded_about",
    "recorded_calibration",
    "with_paths_from",
]
