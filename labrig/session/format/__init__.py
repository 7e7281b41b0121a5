"""The session file's layout, its setup group and its channels."""
