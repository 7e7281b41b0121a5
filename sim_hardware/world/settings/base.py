"""The base of the tables of a world.toml, and the types of their values."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Ratio = Annotated[float, Field(ge=0, le=1)]
Angle = Annotated[float, Field(ge=-1.5, le=1.5)]


class ClosedSettings(BaseModel):
    """A table in which an unknown key, or a value that is not a number, is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)
