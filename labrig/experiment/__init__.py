"""Protocol + rig + session file = one recorded experiment."""
