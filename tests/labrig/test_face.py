"""What `import labrig` offers to other people's code."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import labrig
from labrig import testing, vision
from labrig.version import version


@pytest.mark.parametrize("package", [labrig, vision, testing])
def test_every_public_name_is_there(package: ModuleType) -> None:
    assert package.__all__
    assert set(package.__all__) <= set(dir(package))
    for name in package.__all__:
        assert getattr(package, name) is not None, name


def test_what_a_curve_is_looked_for_with_is_read_from_files() -> None:
    data = Path(__file__).parents[2] / "docs/tutorials/data"
    strip = labrig.StripGeometry(free_length_m=0.03, thickness_m=0.6e-3)
    image, optics = (
        labrig.read_image(data / "strip.png"),
        labrig.load_optics(data / "strip.optics.json"),
    )
    assert labrig.neutral_curve(image, optics, strip).ok


def test_the_version_is_that_of_the_command() -> None:
    assert labrig.__version__ == version()


@pytest.mark.parametrize("package", [labrig, vision, testing])
def test_an_unknown_name_is_an_attribute_error(package: ModuleType) -> None:
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = package.nothing


@pytest.mark.slow
def test_the_optics_wait_for_no_compiler() -> None:
    code = "import sys, labrig.vision.calibration.optics; assert 'numba' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.slow
def test_importing_labrig_loads_nothing_slow() -> None:
    code = (
        "import sys, labrig, labrig.cli; "
        "slow = {'cv2', 'numba', 'nidaqmx', 'matplotlib', 'scipy', 'h5py'} & set(sys.modules); "
        "assert not slow, slow"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
