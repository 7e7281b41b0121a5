"""How often a wrong datum is told rightly: `python -m benchmarks.data_mistakes`."""
