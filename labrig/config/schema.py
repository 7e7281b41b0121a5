"""The JSON Schemas of the configuration files, made from the models that read them."""

from __future__ import annotations

from typing import Any

from pydantic import create_model

from labrig.config.about import About
from labrig.config.base import ClosedModel
from labrig.config.load_cell import LoadCellConfig
from labrig.config.protocol import protocol_model
from labrig.config.rig import rig_model
from labrig.config.sheet import ArcConfig, Sheet


def schemas() -> dict[str, dict[str, Any]]:
    """One schema for each kind of file, by its name."""
    return {
        "rig": rig_model().model_json_schema(),
        "sheet": _sheet_schema(),
        "protocol": protocol_model().model_json_schema(),
        "load_cell": LoadCellConfig.model_json_schema(),
        "about": About.model_json_schema(),
    }


def _sheet_schema() -> dict[str, Any]:
    # Its tables are named by the user, so it is no model of fixed keys.
    model = create_model(
        "SheetFile", __base__=ClosedModel, arc=(ArcConfig, ArcConfig()), long=(Sheet, ...)
    )
    schema = model.model_json_schema()
    schema["additionalProperties"] = schema["properties"].pop("long")
    schema.pop("required", None)
    schema["title"] = "sheet.toml"
    return schema
