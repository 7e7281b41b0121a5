"""Models of an IPMC sheet by other authors, in dynamic form, one file each."""

from model.dynamics.models.catalogue import model, models, origins
from model.dynamics.models.contract import DrivenSheet, ModelParameter, PublishedModel, Response

__all__ = [
    "DrivenSheet",
    "ModelParameter",
    "PublishedModel",
    "Response",
    "model",
    "models",
    "origins",
]
