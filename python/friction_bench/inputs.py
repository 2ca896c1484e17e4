"""Constants of a recording in arrays, by the names of `recording.toml`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from friction_bench._native import FrictionBenchError

__all__ = ["Pickup", "Plate"]


@dataclass(frozen=True, kw_only=True)
class Plate:
    """Constants of the plate, as `[plate]` of `recording.toml` states them.

    Parameters
    ----------
    resonance_hz : float
        Resonance frequency of the driven mode, Hz.
    modal_mass_kg : float
        Modal mass m_p, kg.
    force_factor_n_per_v : float
        Force factor γ of the actuators, N/V: the force on the plate is γ times the voltage.
    centre_m : float
        Position of the plate's centre on the scale of `position`, m.
    profile : dict, optional
        Amplitude along the plate, as `[plate.profile]`.
    across : dict, optional
        Amplitude across the plate, as `[plate.across]`.
    """

    resonance_hz: float
    modal_mass_kg: float
    force_factor_n_per_v: float
    centre_m: float
    profile: Mapping[str, Any] | None = None
    across: Mapping[str, Any] | None = None


@dataclass(frozen=True, kw_only=True)
class Pickup:
    """Scale of the pickup: displacement = metres_per_unit · sample · exp(i · phase_rad).

    Parameters
    ----------
    metres_per_unit : float
        Displacement of the plate per sample value at the carrier, m.
    phase_rad : float
        Phase of the displacement relative to the samples, rad.
    clip_units : float, optional
        Magnitude of a sample from which on the input clipped, if it is known.
    """

    metres_per_unit: float = 1.0
    phase_rad: float = 0.0
    clip_units: float | None = None


def table(value: object) -> Any:
    """Return constants as a dict without those that are absent; a value that has none is returned as it is."""
    if isinstance(value, (Plate, Pickup)):
        value = asdict(value)
    if isinstance(value, Mapping):
        return {key: item for key, item in value.items() if item is not None}
    return value


def interval_tables(intervals: object) -> list[Any]:
    """Return intervals as a list of tables of `intervals`."""
    if isinstance(intervals, (str, Mapping)) or not isinstance(intervals, Iterable):
        raise FrictionBenchError('`intervals` is no list of intervals: pass one, as intervals=[("unloaded", 0.2, 1.0)]')
    return [interval_table(interval) for interval in intervals]


def interval_table(interval: object) -> Any:
    """Return an interval of the form (kind, start_s, end_s[, direction]) as a table of `intervals`."""
    if isinstance(interval, Mapping) or isinstance(interval, str) or not isinstance(interval, Sequence):
        return interval
    return dict(zip(("kind", "start_s", "end_s", "direction"), interval, strict=False))


def description(
    tables: Mapping[str, Any], *, drive_volts_per_unit: float, pickup_scale: Pickup | Mapping[str, Any] | None, **keys: Any
) -> dict[str, Any]:
    """Return the content that the `recording.toml` of drive and pickup would have."""
    for name, value, remedy in [
        ("manifest", tables, "the content of recording.toml, as `Recording.manifest` has it"),
        ("pickup_scale", table(pickup_scale or {}), "friction_bench.Pickup(metres_per_unit=…), or a dict"),
    ]:
        if not isinstance(value, Mapping):
            raise FrictionBenchError(f"`{name}` is of type {type(value).__name__}: pass {remedy}")
    stated = {key: table(value) for key, value in keys.items() if value is not None}
    drive = {"index": 0, "volts_per_unit": drive_volts_per_unit}
    channels = tables.get("channels")
    stated_drive = channels.get("drive") if isinstance(channels, Mapping) else None
    clip_units = stated_drive.get("clip_units") if isinstance(stated_drive, Mapping) else None
    pickup = {**table(Pickup()), **table(pickup_scale or Pickup()), "index": 1}
    channels = {"drive": table({**drive, "clip_units": clip_units}), "pickup": pickup}
    return {**tables, "format": 1, **stated, "channels": channels}
