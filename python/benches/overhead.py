"""Compares analyses of arrays from Python with those from Rust: the time of one call, and the throughput of two threads.

PROGRAM, of bench/results/study-analysis/benches/arrays.rs, is the benchmark that cargo built: PROGRAM FOLDER THREADS CALLS.
"""

import statistics
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import friction_bench as fb

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "python/tests"))
FOLDER = ROOT / "bench/tests/data/reference/recording-a"
CALLS, ROUNDS = 6, 7


def from_rust(program: str, threads: int) -> float:
    done = subprocess.run([program, FOLDER, str(threads), str(CALLS)], check=True, capture_output=True, text=True)
    return float(done.stdout)


def from_python(threads: int) -> float:
    from conftest import arguments_of

    arguments = {key: fb.as_samples(value) if key in {"drive", "pickup"} else value for key, value in arguments_of(FOLDER).items()}
    fb.analyze(**arguments)
    started = time.perf_counter()
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(lambda _: fb.analyze(**arguments), range(threads * CALLS)))
    return time.perf_counter() - started


def main() -> None:
    (program,) = sys.argv[1:]
    for threads in (1, 2):
        # Alternately, so that a change of the machine's speed concerns both.
        ratios = [from_rust(program, threads) / from_python(threads) for _ in range(ROUNDS)]
        print(f"{threads} thread(s): throughput of Python / Rust = {statistics.median(ratios):.3f} (required: at least 0.95)")


main()
