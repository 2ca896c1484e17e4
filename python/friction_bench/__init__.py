"""Contact stiffness, levitation gap and friction of a finger on an ultrasonically vibrating plate."""

from friction_bench import model
from friction_bench._native import Contact, FrictionBenchError, __version__
from friction_bench.simulation import Simulation, simulate

__all__ = [
    "Contact",
    "FrictionBenchError",
    "Simulation",
    "__version__",
    "model",
    "simulate",
]
