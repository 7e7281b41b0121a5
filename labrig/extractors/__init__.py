"""Curve extractors: one a module, each a way from an image to the sheet's neutral curve."""
