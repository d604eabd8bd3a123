"""A usable renderer is chosen before any test can load one that aborts the process."""

from __future__ import annotations

import contextlib

from weaveusd.errors import RendererUnavailableError
from weaveusd.render import variant

with contextlib.suppress(RendererUnavailableError):
    variant.prepare()
