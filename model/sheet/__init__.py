"""The sheet model: its parameters, the effects applied to it, and what it predicts."""
