"""The installed package: its version, and the libraries of the system that it needs."""

import re
import subprocess
import sys
from importlib.metadata import requires, version
from pathlib import Path

import pytest

import friction_bench as fb
from friction_bench import _native


def test_the_installed_package_states_its_version_and_needs_numpy_alone() -> None:
    assert fb.__version__ == version("friction_bench")
    assert [re.split(r"\W", need)[0] for need in requires("friction_bench") or []] == ["numpy"]


@pytest.mark.skipif(sys.platform != "linux", reason="ldd lists libraries of Linux")
def test_the_library_needs_no_sound_card_and_no_display() -> None:
    listing = subprocess.run(["ldd", str(Path(_native.__file__))], check=True, capture_output=True, text=True).stdout
    names = {Path(line.split()[0]).name for line in listing.splitlines() if line.strip()}
    allowed = re.compile(r"(linux-vdso|linux-gate|ld-linux.*|libc|libm|libgcc_s|libpthread|libdl|librt)\.so\.\d+")
    assert names and not [name for name in names if not allowed.fullmatch(name)], names
