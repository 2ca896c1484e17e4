"""The program friction-bench, to which the package is compared; FRICTION_BENCH names it."""

import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
REFERENCE = ROOT / "bench/tests/data/reference"


def run(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [os.environ["FRICTION_BENCH"], *map(str, arguments)]
    environment = {**os.environ, "LC_ALL": "C.UTF-8"}
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
