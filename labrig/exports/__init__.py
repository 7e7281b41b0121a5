"""Export formats: one a module, each a way to write a session for other programs."""
