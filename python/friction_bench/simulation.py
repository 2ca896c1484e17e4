"""Recordings of a simulated plate and finger, with their truth."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from friction_bench import _native
from friction_bench.inputs import Pickup, Plate

__all__ = ["Simulation", "simulate"]

Readings = tuple[NDArray[np.float64], NDArray[np.float64]]
Interval = tuple[str, float, float] | tuple[str, float, float, str]


@dataclasses.dataclass(frozen=True, eq=False)
class Simulation:
    """A recording of a simulated trial, with its truth; made by `simulate`.

    Times are seconds from the first sample, by the clock of drive and pickup.

    Attributes
    ----------
    drive : array of float32
        Voltage across the actuators, V.
    pickup : array of float32
        Sample values of the pickup, which `pickup_scale` converts to metres.
    rate_hz : float
        Sampling rate of drive and pickup, Hz.
    carrier_hz, modulation_hz, modulation_index : float
        Carrier and modulation of the drive.
    pickup_scale : Pickup
        Displacement per sample value of the pickup, and its phase.
    normal, lateral : tuple of arrays
        Times, s, and readings of the force sensor, N; the sensor has a rate of its own.
    position : tuple of arrays
        Times, s, and positions of the finger along the plate, m.
    plate : Plate
        Constants of the plate as the bench states them.
    room : dict
        Ambient pressure by a barometer: ``pressure_hpa``.
    intervals : list of tuples
        ``("unloaded", start_s, end_s)`` and ``("exploration", start_s, end_s, direction)``.
    uncalibrated : bool
        Whether the constants are those of the nominal bench: `calibrated` of `simulate` was False.
    truth : dict
        True constants of the finger by name: ``sigma_t_m``, ``z_t_n_s_per_m``, ``mu0``, ``contact_area_m2``, ``q0_rad_per_m``,
        ``loss_factor``, ``tau_s`` and others; ``scenario``, every constant of the simulation as drawn from the seed; and ``series``, arrays
        of a value per millisecond: ``time_s``, ``gap_m``, ``mu``, ``mu0``, ``sigma_t_m``, ``z_t_n_s_per_m``, ``stiffness_n_per_m``,
        ``normal_n``, ``lateral_n``, ``amplitude_m`` and others. Without contact gap, friction and time constant are NaN.
    """

    drive: NDArray[np.float32]
    pickup: NDArray[np.float32]
    rate_hz: float
    carrier_hz: float
    modulation_hz: float
    modulation_index: float
    pickup_scale: Pickup
    normal: Readings
    lateral: Readings
    position: Readings
    plate: Plate
    room: dict[str, float]
    intervals: list[Interval]
    uncalibrated: bool
    truth: dict[str, Any]

    def arguments(self) -> dict[str, Any]:
        """Return the arguments of `analyze` for this recording: ``fb.analyze(**simulation.arguments())``.

        Among them is ``simulated=True``, so that results, tables and figures say that nobody took part.
        """
        names = (
            "drive",
            "pickup",
            "rate_hz",
            "carrier_hz",
            "modulation_hz",
            "modulation_index",
            "plate",
            "normal",
            "lateral",
            "position",
            "intervals",
            "pickup_scale",
            "room",
            "uncalibrated",
        )
        return {**{name: getattr(self, name) for name in names}, "simulated": True}

    def __repr__(self) -> str:
        strokes = sum(interval[0] == "exploration" for interval in self.intervals)
        return f"Simulation({len(self.drive) / self.rate_hz:.1f} s at {self.rate_hz:.0f} Hz, {strokes} explorations)"


def simulate(
    scenario: str | os.PathLike[str] | Mapping[str, Any],
    seed: int = 1,
    *,
    participant_seed: int | None = None,
    strokes: int = 2,
    duration_s: float | None = None,
    rate_hz: int = 192_000,
    carrier_hz: float | None = None,
    mean_amplitude_v: float = 24.0,
    modulation_hz: float = 6.0,
    modulation_index: float = 0.95,
    calibrated: bool = True,
    progress: Callable[[int, int], object] | None = None,
) -> Simulation:
    """Simulate a trial: a virtual participant explores a vibrating plate, which is recorded together with the truth.

    The simulation integrates plate, film, skin, friction, sensors and person in time, and shares no code with the analysis: a method can
    be tried on it against a known truth. A trial has an unloaded stretch of the plate, strokes of 85 mm at 50 mm/s in alternating
    directions, each after a countdown of 3 s, and another unloaded stretch.

    Parameters
    ----------
    scenario : str, path or mapping
        Name of a built-in scenario, such as ``"steady"`` (no noise, no drift), ``"nominal"``, ``"population"`` (a person drawn by seed) or
        ``"population-unkind"`` (skin, plate and sensors depart from every assumption of the analysis); or the path or the text of a scenario
        file (TOML), or its keys as a mapping.
    seed : int, default 1
        Seed of all random numbers. The same arguments give the same samples.
    participant_seed : int, optional
        Seed of the participant; `seed` if omitted.
    strokes : int, default 2
        Number of strokes; with `duration_s`, the largest number.
    duration_s : float, optional
        Length of the recording, s, with as many whole strokes as fit; omitted, the strokes determine it, about 8 s each.
    rate_hz : int, default 192000
        Sampling rate of drive and pickup, Hz, 80000 to 250000.
    carrier_hz : float, optional
        Carrier of the drive, Hz; the stated resonance of the plate if omitted.
    mean_amplitude_v : float, default 24.0
        Mean of the drive's envelope, V peak.
    modulation_hz : float, default 6.0
        Frequency of the modulation, Hz.
    modulation_index : float, default 0.95
        Index of the modulation, 0 to 1.
    calibrated : bool, default True
        True for the plate, pickup and force constants of calibrations without error; False for those of the nominal bench, which are
        wrong where the scenario draws others, as ``"bench-unknown"`` does.
    progress : callable, optional
        Called as ``progress(done, total)`` with the simulated and the expected seconds; an exception in it ends the simulation.

    Returns
    -------
    Simulation
        The recording, with its truth.

    Raises
    ------
    FrictionBenchError
        The scenario cannot be read, or a value cannot be simulated.

    Notes
    -----
    A minute at 192 kHz takes about 6 s.

    Examples
    --------
    >>> import friction_bench as fb
    >>> trial = fb.simulate("steady", 1, strokes=1, rate_hz=96_000)
    >>> trial.truth["sigma_t_m"], trial.truth["z_t_n_s_per_m"]
    (1.7e-06, (0.47+3.16j))
    >>> [interval[0] for interval in trial.intervals]
    ['unloaded', 'exploration', 'unloaded']
    >>> softer = fb.simulate({"participant": {"sigma_t_m": 2.2e-6}}, duration_s=2.0)
    >>> softer.truth["sigma_t_m"], len(softer.drive)
    (2.2e-06, 384000)
    """
    if isinstance(scenario, Mapping):
        scenario = dict(scenario)
    streams = _native.simulate(
        scenario,
        seed,
        participant_seed,
        strokes,
        duration_s,
        rate_hz,
        carrier_hz,
        mean_amplitude_v,
        modulation_hz,
        modulation_index,
        calibrated,
        progress,
    )
    intervals: list[Interval] = [("unloaded", start_s, end_s) for start_s, end_s in streams.pop("unloaded_s")]
    intervals += [("exploration", *stroke) for stroke in streams.pop("strokes")]
    scale = Pickup(metres_per_unit=streams.pop("metres_per_unit"), phase_rad=streams.pop("phase_rad"))
    return Simulation(
        **{**streams, "plate": Plate(**streams["plate"])},
        pickup_scale=scale,
        uncalibrated=not calibrated,
        intervals=sorted(intervals, key=lambda interval: interval[1]),
    )
