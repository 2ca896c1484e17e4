"""Contact stiffness, levitation gap and friction of a finger on an ultrasonically vibrating plate."""

from friction_bench._native import FrictionBenchError, __version__

__all__ = ["FrictionBenchError", "__version__"]
