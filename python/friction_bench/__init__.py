"""Contact stiffness, levitation gap and friction of a finger on an ultrasonically vibrating plate."""

from friction_bench import model
from friction_bench._native import Analysis, Contact, FrictionBenchError, Recording, Settings, Table, __version__
from friction_bench.analysis import analyze, as_samples, envelopes, impedance
from friction_bench.inputs import Pickup, Plate
from friction_bench.recordings import import_map, read
from friction_bench.simulation import Simulation, simulate

__all__ = [
    "Analysis",
    "Contact",
    "FrictionBenchError",
    "Pickup",
    "Plate",
    "Recording",
    "Settings",
    "Simulation",
    "Table",
    "__version__",
    "analyze",
    "as_samples",
    "envelopes",
    "impedance",
    "import_map",
    "model",
    "read",
    "simulate",
]
