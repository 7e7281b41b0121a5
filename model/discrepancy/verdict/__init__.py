"""From the candidates to a verdict, with its parameters, prediction errors and messages."""
