"""Run an experiment: protocol, rig and session file together give one recorded session."""
