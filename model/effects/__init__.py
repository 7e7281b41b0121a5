"""The catalogue of effects: what the base model leaves out, one object and one file each."""

from model.effects.catalogue import catalogue, effect
from model.effects.interface import SLOTS, Effect, Knob, Slot

__all__ = ["SLOTS", "Effect", "Knob", "Slot", "catalogue", "effect"]
