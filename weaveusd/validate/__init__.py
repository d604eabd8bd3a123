"""Validate: checks on published files, and their report."""
