"""Check whether a fitted curve is the sheet: one check a file of `kinds`."""
