"""`python -m sim_hardware serve ...`."""

import gc
import sys

from sim_hardware.serve import main

if __name__ == "__main__":
    gc.set_threshold(10_000, 10, 10)  # for the reasons that labrig/garbage.py gives
    sys.exit(main(sys.argv[1:]))
