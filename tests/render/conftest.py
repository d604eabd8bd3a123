"""A renderer for every test of this folder that asks for one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from weaveusd.errors import RendererUnavailableError
from weaveusd.render import variant
from weaveusd.stage import require

require()
try:
    variant.prepare(variant.LLVM)
    _MISSING = ""
except RendererUnavailableError as error:
    _MISSING = str(error)


@pytest.fixture
def mi() -> Iterator[Any]:
    """Mitsuba with the LLVM variant active, whatever the test before it chose."""
    if _MISSING:
        pytest.skip(_MISSING)
    import mitsuba

    mitsuba.set_variant(variant.LLVM)
    yield mitsuba
    mitsuba.set_variant(variant.LLVM)
