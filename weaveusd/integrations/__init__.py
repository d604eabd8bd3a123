"""weaveusd in the tools of a pipeline: a render farm, a publishing framework."""
