"""What UsdPreviewSurface, OpenPBR, standard_surface and glTF say, in one vocabulary."""

from __future__ import annotations

from dataclasses import dataclass, fields

from weaveusd.render.fields import Field


@dataclass(frozen=True, slots=True, eq=False)
class Surface:
    """A surface of layers: a coat over a metal or a dielectric, which lies over diffuse light.

    Widths stand in brackets. Reflectances are linear Rec.709; `alpha` are GGX roughnesses along
    the tangent and across it, so a highlight is stretched along the tangent, where it is wide.
    `f0` and `f90` are the reflectance of the dielectric along its normal and along the surface.
    Directions are in tangent space and need no length. `clear_base` tells that what opacity
    takes away is the light below the highlights only, as glass is clear and shines.
    """

    base_color: Field  # (3) albedo of diffuse light, reflectance of metal
    metalness: Field  # (1)
    metal_f90: Field  # (3)
    f0: Field  # (3)
    f90: Field  # (3)
    alpha: Field  # (2)
    coat: Field  # (1)
    coat_f0: Field  # (1)
    coat_alpha: Field  # (1)
    coat_color: Field  # (3)
    opacity: Field  # (1)
    emission: Field  # (3) radiance
    transmission: Field  # (1) share of the dielectric's light that is refracted, not diffused
    transmission_color: Field  # (3)
    ior: float  # of what is refracted
    thin_walled: bool
    normal: Field | None = None  # (3)
    tangent: Field | None = None  # (3)
    clear_base: bool = False

    def key(self) -> tuple[object, ...]:
        """Return what is equal for surfaces that look the same."""
        values = (getattr(self, f.name) for f in fields(self))
        return tuple(id(v) if isinstance(v, Field) else v for v in values)
