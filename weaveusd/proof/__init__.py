"""Proof of the cloth BSDF: what it must keep to, checked and drawn, for every preset."""
