"""A process that can do one thing: STOP. `python -m labrig.panel.stop`, settings on its input."""
