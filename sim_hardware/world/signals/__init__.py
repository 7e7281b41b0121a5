"""The signals around the sheet: amplifier, its supply relay, load cell, noise."""
