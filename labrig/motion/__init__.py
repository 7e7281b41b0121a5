"""The motion of a modelled sheet: what drives it, what comes of it, and the file of it."""
