"""The catalogue of effects: what the base model leaves out, one object and one file each."""

from model.effects.catalogue import catalogue, effect, origins
from model.effects.interface import Effect, EffectParameter

__all__ = ["Effect", "EffectParameter", "catalogue", "effect", "origins"]
