"""One run: edges at their times, or a controller, and everything else in between."""
