"""The catalogue of effects."""

from model.effects.page import page

__all__ = ["page"]
