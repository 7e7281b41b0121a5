"""The mechanics of the sheet: equilibrium, identification, effects, discrepancy, design."""
