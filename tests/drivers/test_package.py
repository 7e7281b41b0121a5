"""The package as a whole: light to import, and everything it hands on is there."""

import subprocess
import sys

import drivers

SLOW = ("nidaqmx", "grpc", "cv2", "serial", "scipy", "matplotlib")


def test_importing_touches_no_vendor_package():
    """Every module imports on a machine without drivers, and quickly."""
    script = f"import drivers, sys; print([name for name in {SLOW} if name in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def test_every_public_name_is_there():
    assert all(hasattr(drivers, name) for name in drivers.__all__)
