"""One method a file: NAME.py with `answer(measurements) -> Answer`; see `contract`."""
