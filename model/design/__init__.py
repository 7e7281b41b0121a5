"""Predict the abilities of a sheet, and choose the sheet for a task."""
