"""How often the intervals of `model.dynamics.identification` hold the truth of the moving world."""
