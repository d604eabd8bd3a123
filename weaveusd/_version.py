"""The version of weaveusd, written into every asset that it publishes."""

__version__ = "0.1.0"
