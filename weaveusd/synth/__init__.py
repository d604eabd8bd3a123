"""Synthesis: textures from the real geometry of the yarns."""
