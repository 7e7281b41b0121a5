"""The rig: its devices as interfaces, wired from rig.toml, real or simulated."""
