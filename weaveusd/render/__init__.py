"""Render: the Mitsuba BSDF and the translator from USD stages."""
