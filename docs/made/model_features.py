"""The features of models of the sheet (the paper's tables 1 and 2), found by running the models."""

from __future__ import annotations

from collections.abc import Iterator

from labrig.analysis.features import FEATURES, ProbedModel, labrigs_models, respond_of
from model.dynamics.models import models

HEAD = """\
# Features of models

The paper names nine features of models of an ionic-polymer sheet (its table 1), and compares the
models of other authors by them (its table 2). The two tables here are labrig's own: the build runs
each model and tests its predictions.

Where the source leaves something open, labrig's form of a model has
[a reading of its own](../../explanation/dynamic_models.md). So a mark can differ from the paper's.
Most sources give the force in one place only; labrig's forms give it anywhere along the arc.

## The features
"""
SECOND = """\

## The models

The columns are the features above. `-`: no prediction of the model could show it. *held only*: in
contact with the load cell, but not the shape of the free sheet.
"""
END = """\

`python docs/made/model_features.py` prints this page. A model that another distribution adds
(entry points of the group `labrig.dynamic_models`) appears where that is installed.
"""


def page() -> str:
    """Return the page's text."""
    return "\n".join([HEAD, *_features(), SECOND, *_models(), END])


def marks(model: ProbedModel) -> list[str]:
    """Return a model's answers, in the order of the features."""
    return [str(feature.ask(model.respond)) for feature in FEATURES]


def _features() -> Iterator[str]:
    yield "| | feature | meaning | a model has it where the answer is yes |"
    yield "|---|---|---|---|"
    for number, one in enumerate(FEATURES, 1):
        yield f"| {number} | {one.name} | {one.meaning} | {one.asked} |"


def _models() -> Iterator[str]:
    yield f"| model | {' | '.join(str(number) for number in range(1, len(FEATURES) + 1))} |"
    yield "|---" * (len(FEATURES) + 1) + "|"
    others = [ProbedModel(one.title, respond_of(one)) for one in models().values()]
    for model in (*labrigs_models().values(), *sorted(others, key=lambda one: one.title)):
        yield f"| {model.title} | {' | '.join(marks(model))} |"


if __name__ == "__main__":
    import sys

    sys.stdout.write(page())
