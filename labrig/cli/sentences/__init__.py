"""What the user is told beside the output of a command."""
