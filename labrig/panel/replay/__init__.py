"""A recorded session as it was shown while it was recorded: the same messages, at any speed."""

from labrig.panel.replay.player import Player
from labrig.panel.replay.recording import Recording

__all__ = ["Player", "Recording"]
