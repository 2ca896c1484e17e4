"""Packs the library that cargo built into a wheel as maturin does, without another build: LIBRARY VERSION FOLDER."""

import shutil
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1]


def lay_out(library: Path, version: str, folder: Path) -> None:
    project = tomllib.loads((SOURCE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    name, platform = project["name"], sysconfig.get_platform().replace("-", "_").replace(".", "_")
    package, info = folder / name, folder / f"{name}-{version}.dist-info"
    shutil.copytree(SOURCE / name, package, ignore=shutil.ignore_patterns("__pycache__", "*.so"))
    shutil.copy(library, package / "_native.abi3.so")
    info.mkdir()
    metadata = [
        "Metadata-Version: 2.1", f"Name: {name}", f"Version: {version}", f"Summary: {project['description']}",
        f"Requires-Python: {project['requires-python']}", *(f"Requires-Dist: {other}" for other in project["dependencies"]),
    ]
    wheel = ["Wheel-Version: 1.0", "Generator: pack_wheel", "Root-Is-Purelib: false", f"Tag: cp310-abi3-{platform}"]
    for file, lines in [("METADATA", metadata), ("WHEEL", wheel)]:
        (info / file).write_text("\n".join(lines) + "\n", encoding="utf-8")


def main() -> None:
    library, version, destination = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        lay_out(Path(library), version, Path(folder))
        subprocess.run([sys.executable, "-m", "wheel", "pack", folder, "--dest-dir", destination], check=True, capture_output=True)


main()
