"""Find the published models: one a file of this folder, and those of other distributions.

A file of this folder adds one by its constant `MODEL`; another distribution by an entry point of
the group `labrig.dynamic_models`.
"""

from __future__ import annotations

from model.dynamics.models.contract import PublishedModel
from model.measurements import ModelError
from model.plugins import PluginFolder, UnknownPartError


def _faults(part: object) -> list[str]:
    from model.dynamics.models.conformance import faults

    return faults(part)


FOLDER: PluginFolder[PublishedModel] = PluginFolder(
    what="dynamic model",
    package="model.dynamics.models",
    constant="MODEL",
    group="labrig.dynamic_models",
    faults=_faults,
)


def models() -> dict[str, PublishedModel]:
    """Return all models by name."""
    return {name: found.part for name, found in FOLDER.parts().items()}


def model(name: str) -> PublishedModel:
    """Return the model of this name; a `ModelError` lists those there are."""
    try:
        return FOLDER.get(name)
    except UnknownPartError as error:
        raise ModelError(str(error)) from None


def origins() -> dict[str, str]:
    """Return "distribution version" by name of the models of other distributions."""
    return FOLDER.origins()
