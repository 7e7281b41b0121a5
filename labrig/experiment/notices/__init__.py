"""Who is told of a session while it runs: hooks, and subscribers of its documents."""
