"""Analysis of arrays and of folders."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from friction_bench import _native
from friction_bench._native import Analysis, FrictionBenchError, Settings
from friction_bench.inputs import Pickup, Plate, description, interval_tables

__all__ = ["analyze", "as_samples", "envelopes", "impedance"]

Readings: TypeAlias = tuple[npt.ArrayLike, npt.ArrayLike]
Folder: TypeAlias = str | os.PathLike[str]


def analyze(
    drive: npt.ArrayLike | Folder | Sequence[Folder],
    pickup: npt.ArrayLike | None = None,
    rate_hz: float | None = None,
    *,
    carrier_hz: float | str | None = None,
    modulation_hz: float | None = None,
    modulation_index: float | None = None,
    plate: Plate | Mapping[str, Any] | None = None,
    normal: Readings | None = None,
    lateral: Readings | None = None,
    position: Readings | None = None,
    intervals: Iterable[Sequence[Any] | Mapping[str, Any]] | None = None,
    drive_volts_per_unit: float = 1.0,
    pickup_scale: Pickup | Mapping[str, Any] | None = None,
    participant: Mapping[str, Any] | None = None,
    standard_errors: Mapping[str, Any] | None = None,
    room: Mapping[str, Any] | None = None,
    manifest: Mapping[str, Any] | None = None,
    protocol: str | None = None,
    settings: Settings | Mapping[str, Any] | None = None,
    simulated: bool = False,
    uncalibrated: bool = False,
    practice: bool = False,
    include_rejected: bool = False,
    include_excluded: bool = False,
    exclude: Sequence[Folder] = (),
    progress: Callable[[int, int], object] | None = None,
) -> Analysis:
    """Estimate contact, gap and friction from the samples of drive and pickup, or from folders of recordings.

    ``analyze(drive, pickup, rate_hz, …)`` analyses one recording in memory; its numbers are those of the same recording in a folder,
    to the last bit. ``analyze(path)`` analyses a recording, participant, session or study on the disk, or a list of them, as
    ``friction-bench analyze`` does. Arrays of any real dtype, stride and byte order are accepted; contiguous ones of 32- or 64-bit
    floats are not copied. Do not change them during the call.

    Parameters
    ----------
    drive : array_like, shape (n,)
        Samples of the voltage across the actuators, `drive_volts_per_unit` V for a value of 1; NaN is a lost sample. Or folders.
    pickup : array_like, shape (n,)
        Samples of the plate's displacement at the same times; `pickup_scale` has their scale and phase.
    rate_hz : float
        Sampling rate of drive and pickup, Hz.
    carrier_hz : float or "follows"
        Frequency of the carrier, Hz, or "follows" for one that moves.
    modulation_hz, modulation_index : float
        Frequency of the amplitude modulation, Hz, and its index, 0 to 1; found in the drive if absent.
    plate : Plate or dict
        Constants of the plate.
    normal, lateral : (array_like, array_like), optional
        Times, s from sample 0, ascending, and forces on the plate, N. Each may have its own times: the lateral force is
        interpolated at the times of the normal force.
    position : (array_like, array_like), optional
        Times, s, and position of the finger along the plate, m.
    intervals : list
        ``("unloaded", start_s, end_s)``, ``("exploration", start_s, end_s, "left_to_right")``: at least an unloaded interval and
        an exploration are needed for estimates.
    participant, standard_errors, room : dict, optional
        Tables of `recording.toml` with these names.
    manifest : dict, optional
        Further content of `recording.toml`, such as `Recording.manifest`; arguments have priority.
    protocol : str, optional
        Text of the protocol that the recording followed, which has the rules that select instances.
    settings : Settings or dict, optional
        Assumed numbers, by the names of ``friction-bench analyze --assume``.
    simulated : bool
        Whether the arrays are simulated, or recorded from simulated hardware: results, tables and figures say so.
    uncalibrated : bool
        Whether the constants were not measured, which results, tables and figures say likewise. `Simulation.arguments` and
        `Recording.arguments` state both where they are true.
    practice, include_rejected, include_excluded, exclude
        Recordings of folders that are analysed; see ``friction-bench analyze --help``.
    progress : callable, optional
        Called with the number of recordings done and the total; an exception of it ends the analysis.

    Returns
    -------
    Analysis
        Results, tables, figures, report and warnings.

    Raises
    ------
    FrictionBenchError
        An argument, or a file, cannot be used; the message names it.

    Notes
    -----
    Demodulation and contact model: Huloux, Bernard, Wiertlewski, IEEE Trans. Haptics 14(2), 2021; estimation: docs/SCIENCE.md.
    """
    samples = {"pickup": pickup, "rate_hz": rate_hz}
    keys = {
        "carrier_hz": carrier_hz, "modulation_hz": modulation_hz, "modulation_index": modulation_index, "plate": plate,
        "participant": participant, "standard_errors": standard_errors, "room": room,
        "intervals": None if intervals is None else interval_tables(intervals),
    }
    streams = {"normal": normal, "lateral": lateral, "position": position, "manifest": manifest, "protocol": protocol}
    stated = {"simulated": simulated, "uncalibrated": uncalibrated}
    folders = _folders(drive)
    if folders is not None:
        flags = {name: flag or None for name, flag in stated.items()}
        for name, value in {**samples, **keys, **streams, **flags}.items():
            if value is not None:
                raise FrictionBenchError(f"`{name}` is of arrays, but `drive` is a folder: leave it out, or pass an array as `drive`")
        return _native.analyze_folders(
            folders, settings=settings, practice=practice, include_rejected=include_rejected,
            include_excluded=include_excluded, exclude=list(exclude), progress=progress,
        )
    if pickup is None or rate_hz is None:
        name = "pickup" if pickup is None else "rate_hz"
        raise FrictionBenchError(f"`{name}` is missing: pass drive, pickup and rate_hz, or the path of a folder")
    content = description(manifest or {}, drive_volts_per_unit=drive_volts_per_unit, pickup_scale=pickup_scale, **keys)
    return _native.analyze_arrays(
        cast("npt.ArrayLike", drive), pickup, rate_hz, content, normal=normal, lateral=lateral, position=position, protocol=protocol,
        settings=settings, progress=progress, **stated,
    )


def impedance(
    drive: npt.ArrayLike,
    pickup: npt.ArrayLike,
    rate_hz: float,
    *,
    carrier_hz: float,
    plate: Plate | Mapping[str, Any] | None = None,
    drive_volts_per_unit: float = 1.0,
    pickup_scale: Pickup | Mapping[str, Any] | None = None,
) -> tuple[npt.NDArray[np.complex128], npt.NDArray[np.float64]]:
    """Return the impedance Z_m of the plate with all that touches it, from the samples of drive and pickup.

    It is that of the analysis. With `plate` it is corrected for the plate's response to a changing envelope; without, it is
    F/(iωx) as published (Huloux 2021, Eq. 20), and `drive` is the force on the plate in N.

    Parameters
    ----------
    drive, pickup : array_like, shape (n,)
        Samples, as in `analyze`.
    rate_hz : float
        Sampling rate, Hz.
    carrier_hz : float
        Frequency of the carrier, Hz.
    plate : Plate or dict, optional
        Constants of the plate.
    drive_volts_per_unit, pickup_scale
        Scales of the samples, as in `analyze`.

    Returns
    -------
    z_m : numpy.ndarray of complex128, shape (m,)
        Impedance, N·s/m, in exp(+iωt), about 2000 a second; NaN where samples were lost or the plate does not vibrate.
    time_s : numpy.ndarray of float64, shape (m,)
        Times, s from sample 0.

    Raises
    ------
    FrictionBenchError
        An argument cannot be used; the message names it.
    """
    has_plate = plate is not None
    unit_plate = {"resonance_hz": carrier_hz, "modal_mass_kg": 1.0, "force_factor_n_per_v": 1.0, "centre_m": 0.0}
    content = description(
        {}, drive_volts_per_unit=drive_volts_per_unit, pickup_scale=pickup_scale, carrier_hz=carrier_hz, modulation_hz=0.0,
        modulation_index=0.0, plate=plate if has_plate else unit_plate,
    )
    return _native.impedance_of_arrays(drive, pickup, rate_hz, content, corrected=has_plate)


def envelopes(
    signal: npt.ArrayLike, rate_hz: float, *, carrier_hz: float
) -> tuple[npt.NDArray[np.complex128], npt.NDArray[np.float64]]:
    """Return the complex envelope of a signal about its carrier, by the demodulator of the bench.

    Parameters
    ----------
    signal : array_like, shape (n,)
        Samples; NaN is a lost one.
    rate_hz : float
        Sampling rate, Hz.
    carrier_hz : float
        Frequency of the carrier, Hz.

    Returns
    -------
    envelope : numpy.ndarray of complex128, shape (m,)
        Peak values in the unit of the samples, in exp(+iωt), about 2000 a second; NaN where samples were lost.
    time_s : numpy.ndarray of float64, shape (m,)
        Times, s from sample 0.

    Raises
    ------
    FrictionBenchError
        An argument cannot be used; the message names it.
    """
    return _native.envelopes(signal, rate_hz, carrier_hz)


def as_samples(values: npt.ArrayLike) -> npt.NDArray[np.float32] | npt.NDArray[np.float64]:
    """Return samples as the analysis reads them: contiguous 32- or 64-bit floats.

    Samples that are such already are returned as they are. Others are copied at each call of `analyze`, `impedance` and `envelopes`:
    convert once what you pass several times.

    Parameters
    ----------
    values : array_like, shape (n,)
        Samples of any real dtype, stride and byte order.

    Returns
    -------
    numpy.ndarray of float32 or float64, shape (n,)

    Raises
    ------
    FrictionBenchError
        The values are no samples.
    """
    return _native.as_samples(values)


def _folders(value: object) -> list[Folder] | None:
    """Return the paths that a value is or lists, or None if it is an array."""
    values = list(value) if isinstance(value, (list, tuple)) else [value]
    folders = [item for item in values if isinstance(item, (str, os.PathLike))]
    return folders if folders and len(folders) == len(values) else None
