"""Check whether a fitted curve is the sheet."""
