"""From one image to the neutral curve: search, fit, check and report it."""
