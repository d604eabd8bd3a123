"""Cloth: drawdown, floats and the physical layout of threads."""
