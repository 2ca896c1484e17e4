"""Recordings on the disk: as arrays, and imported from files of other programs."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

from friction_bench import _native
from friction_bench._native import FrictionBenchError, Recording

__all__ = ["import_map", "read"]

Folder: TypeAlias = str | os.PathLike[str]


def read(path: Folder) -> Recording:
    """Read a recording's folder as arrays.

    Parameters
    ----------
    path : str or path
        Folder of the recording, with its `recording.toml`.

    Returns
    -------
    Recording
        `drive` and `pickup` (float32, in the units of their channels), `rate_hz`, `carrier_hz`, Hz; `normal` and `lateral`, pairs of
        times, s, and forces, N; `position`, a pair of times, s, and positions, m; `intervals`; `plate`; `simulated`, whether
        the session's log says that the bench was; and `manifest`, a dict of all keys of `recording.toml`.
        ``analyze(**recording.arguments())`` has the numbers of ``analyze(path)``, bit for bit.

    Raises
    ------
    FrictionBenchError
        A file is missing, unreadable or breaks a rule of the format; the message names it, and the remedy.

    Notes
    -----
    The format of recordings is in docs/RECORDING.md.

    Examples
    --------
    >>> import friction_bench as fb
    >>> recording = fb.read("study/sub-01/ses-01/trial-001_attempt-1")  # doctest: +SKIP
    >>> z_m, time_s = fb.impedance(                                     # doctest: +SKIP
    ...     recording.drive, recording.pickup, recording.rate_hz, carrier_hz=recording.carrier_hz
    ... )
    """
    return _native.read_recording(path)


def import_map(
    map: Folder | Mapping[str, Any],
    *,
    study: Folder | None = None,
    folder: Folder | None = None,
    dry_run: bool = False,
    progress: Callable[[int, int], object] | None = None,
) -> list[dict[str, Any]]:
    """Import recordings of other programs into a study, as ``friction-bench import`` does.

    Files are independent: one that is refused stops no other. What an earlier import wrote stays as it is, unless the map or a
    file has changed since.

    Parameters
    ----------
    map : str, path or dict
        Map of the files (TOML): their arrays, units, clocks, names and intervals; or its content as a dict.
    study : str or path
        Folder of the study, which is made if it does not exist.
    folder : str or path, optional
        For a dict: folder of the files, to which its `files` are relative; by default the present one.
    dry_run : bool
        Whether the files are converted and nothing is written.
    progress : callable, optional
        Called with the number of files done and the total. Its exception ends the import: no further file is begun.

    Returns
    -------
    list of dict
        For each file its `path` relative to the map; `recording`, its place in the study; `status`: "written", "replaced",
        "unchanged", "checked" (dry run) or "refused"; `corrections`, values found in the data and applied; `flaws`, the refusal
        and other sentences about the file.

    Raises
    ------
    FrictionBenchError
        The map, the study or the table of participants cannot be read, or no file matches the map.

    Examples
    --------
    >>> import friction_bench as fb
    >>> for file in fb.import_map("lab/map.toml", study="study"):       # doctest: +SKIP
    ...     print(file["path"], file["status"], *file["flaws"])
    """
    if isinstance(map, Mapping):
        place = Path(folder or ".") / "friction_bench.import_map"
        return _native.import_by_map(place, map=dict(map), study=study, dry_run=dry_run, progress=progress)
    if folder is not None:
        raise FrictionBenchError("`folder` is of a map that is a dict: the files of a map on the disk are below its own folder")
    return _native.import_by_map(map, study=study, dry_run=dry_run, progress=progress)
