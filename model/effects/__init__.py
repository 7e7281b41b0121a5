"""The catalogue of effects: what the base model leaves out, one object and one file each."""

from model.effects.catalogue import catalogue, effect
from model.effects.interface import LOCATIONS, Effect, EffectParameter, Location

__all__ = ["LOCATIONS", "Effect", "EffectParameter", "Location", "catalogue", "effect"]
