"""Curves of the published contact model, without any measurement."""

from friction_bench._native import curves

__all__ = ["curves"]
