"""Registers the schema and opens stages."""
