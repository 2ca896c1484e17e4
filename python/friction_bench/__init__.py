"""Contact stiffness, levitation gap and friction of a finger on an ultrasonically vibrating plate."""

from friction_bench import model
from friction_bench._native import Analysis, Contact, FrictionBenchError, Settings, Table, __version__
from friction_bench.analysis import analyze, envelopes, impedance
from friction_bench.inputs import Pickup, Plate
from friction_bench.simulation import Simulation, simulate

__all__ = [
    "Analysis",
    "Contact",
    "FrictionBenchError",
    "Pickup",
    "Plate",
    "Settings",
    "Simulation",
    "Table",
    "__version__",
    "analyze",
    "envelopes",
    "impedance",
    "model",
    "simulate",
]
