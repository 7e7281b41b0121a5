"""How well a curve is known, and what may pull it aside."""
