"""`python -m labrig` is `labrig`."""

from labrig.cli import main

if __name__ == "__main__":
    main()
