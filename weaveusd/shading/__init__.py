"""Shading: the reference of the cloth BSDF, fits to standard shaders, the material."""
