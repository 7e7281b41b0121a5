"""The beam in equilibrium: compiled kernel, NumPy reference, free shape, tip load."""
