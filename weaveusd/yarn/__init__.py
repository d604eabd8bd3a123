"""Yarns and recipes: counts, diameters, twist, optics, and presets with sources."""
