"""Analysis as jobs of the panel: `python -m labrig.panel.analysis`, with an order on its input."""
