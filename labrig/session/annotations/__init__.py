"""Annotations: notes, photographs and marks that are added to a session; nothing is taken back."""
