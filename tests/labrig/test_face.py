"""What `import labrig` offers to other people's code."""

from __future__ import annotations

import subprocess
import sys

import pytest

import labrig


@pytest.mark.parametrize("name", labrig.__all__)
def test_every_public_name_is_there(name: str) -> None:
    assert getattr(labrig, name) is not None


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = labrig.nothing


def test_importing_labrig_loads_nothing_slow() -> None:
    code = (
        "import sys, labrig, labrig.cli; "
        "slow = {'cv2', 'numba', 'nidaqmx', 'matplotlib', 'scipy', 'h5py'} & set(sys.modules); "
        "assert not slow, slow"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
