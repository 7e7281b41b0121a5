"""`python -m sim_hardware serve ...`."""

import sys

from sim_hardware.serve import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
