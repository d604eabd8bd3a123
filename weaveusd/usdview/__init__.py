"""A plugin for usdview: the draft, yarns, size and origin of the selected cloth.

usdview finds it by `plugInfo.json` in this folder; `weaveusd env` prints the environment for that.
What is shown is gathered by `card` and `drawing`, which know nothing of usdview; `plugin` and
`window` need a usdview around them.
"""
