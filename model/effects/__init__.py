"""The catalogue of effects that the base model lacks, one object and one file each."""

from model.effects.catalogue import catalogue, effect, origins, title
from model.effects.interface import Effect, EffectParameter

__all__ = ["Effect", "EffectParameter", "catalogue", "effect", "origins", "title"]
