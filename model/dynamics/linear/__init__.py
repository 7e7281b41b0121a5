"""Linear models of the sheet for control: in closed form, about any state at rest, and loops."""
