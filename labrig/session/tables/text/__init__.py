"""What a table's text file looks like: its letters, separators, decimals and columns' names."""
