"""Force sensors and their calibration."""
