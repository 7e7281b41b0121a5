"""The kinds of fact: one file each, with its constant `FACT`."""
