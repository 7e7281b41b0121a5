"""Notes: texts and photographs that are added to a session; none is ever taken back."""
