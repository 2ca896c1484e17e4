"""Contact stiffness, levitation gap and friction of a finger on an ultrasonically vibrating plate."""

from friction_bench._native import Analysis, FrictionBenchError, Recording, Settings, Table, __version__
from friction_bench.analysis import analyze, envelopes, impedance
from friction_bench.inputs import Pickup, Plate
from friction_bench.recordings import import_map, read

__all__ = [
    "Analysis",
    "FrictionBenchError",
    "Pickup",
    "Plate",
    "Recording",
    "Settings",
    "Table",
    "__version__",
    "analyze",
    "envelopes",
    "impedance",
    "import_map",
    "read",
]
