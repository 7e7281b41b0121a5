"""Run a schedule on a clock: scheduler, run loop, readings, events."""
