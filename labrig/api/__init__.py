"""The commands as functions: arguments instead of options, objects instead of printed tables."""
