"""Batch tasks, one a module: each defines TASK, see `labrig.batch.contract`."""
