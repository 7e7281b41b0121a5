"""Answer what a sheet can do, and which sheet a task needs."""
