"""What models of the sheet can describe, found by running them: the paper's tables 1 and 2."""

from labrig.analysis.features.features import FEATURES, Feature
from labrig.analysis.features.models import labrigs_models
from labrig.analysis.features.probe import FeatureMark, ProbedModel, respond_of

__all__ = ["FEATURES", "Feature", "FeatureMark", "ProbedModel", "labrigs_models", "respond_of"]
