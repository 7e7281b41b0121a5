"""Who may connect to the panel, and how much they may send. The STOP process uses it, too."""
