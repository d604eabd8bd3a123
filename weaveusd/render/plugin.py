"""The side of our BSDFs that Mitsuba sees: a plugin hands its calls on to what scatters.

Import this module after `weaveusd.render.variant.prepare`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import mitsuba as mi


class Scattering(Protocol):
    """What a plugin hands its calls to: the BSDF's mathematics, in Mitsuba's terms."""

    def sample(self, ctx: Any, si: Any, choice: Any, point: Any, active: Any) -> tuple[Any, Any]:
        """Return a sample's record and its weight."""

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any) -> tuple[Any, Any]:
        """Return value times cosine, and density."""

    def through(self, si: Any, active: Any) -> Any:
        """Return the share of light that goes straight on."""


def plugin_base() -> Any:
    """Return the base class of our plugins, which derives from the BSDF of the active variant."""

    class Plugin(mi.BSDF):  # type: ignore[misc]
        """A BSDF by a `Scattering`; a subclass adds what it is called and what can be traversed."""

        def __init__(self, props: Any, scattering: Scattering, components: Sequence[int]) -> None:
            """Hand calls on to `scattering`, which has lobes of the flags `components`."""
            mi.BSDF.__init__(self, props)
            self.scattering = scattering
            self.m_components = [int(component) for component in components]
            self.m_flags = 0
            for component in self.m_components:
                self.m_flags |= component

        def sample(
            self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True
        ) -> tuple[Any, Any]:
            return self.scattering.sample(ctx, si, sample1, sample2, active)

        def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.scattering.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
            return self.scattering.eval_pdf(ctx, si, wo, active)[1]

        def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> tuple[Any, Any]:
            return self.scattering.eval_pdf(ctx, si, wo, active)

        def eval_null_transmission(self, si: Any, active: Any = True) -> Any:
            return self.scattering.through(si, active)

    return Plugin
