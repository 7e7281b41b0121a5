"""`labrig batch`: a command for each batch task, with the task's own options."""
