"""What is assumed of parameters before the data, and how the data tell it."""
