"""Read a recorded session: open it safely, its runs, its values."""
