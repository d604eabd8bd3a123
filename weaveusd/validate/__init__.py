"""Validate: checks on published files, and their report.

The package can be called: `weaveusd.validate(stage)` is `weaveusd.validate.run.validate`.
"""

from weaveusd._package import make_callable

make_callable(__name__, "run", "validate")
