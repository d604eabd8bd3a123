"""Render: the Mitsuba BSDF and the translator from USD stages.

The package can be called: `weaveusd.render(stage, output)` is `weaveusd.render.run.render`.
"""

from weaveusd._package import make_callable

make_callable(__name__, "run", "render")
