"""Make the verdict from the search: parameters, prediction errors and messages."""
