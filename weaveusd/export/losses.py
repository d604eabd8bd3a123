"""The loss report: which effects of the exact cloth each network carries, changes or drops."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Literal

from weaveusd.contract import CLOTH_SHADER_ID, GLSLFX_CONTEXT, MITSUBA_CONTEXT, MTLX_SURFACES

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from weaveusd.shading.material import ClothMaterial, StandardFit

Fate = Literal["carried", "approximated", "dropped"]

COLOR = "color of every yarn"
RELIEF = "normals of the yarns"
GAPS = "gaps between the yarns"
DIRECTION = "direction of the highlight, across the fibre"
REFLECTANCE = "reflectance in every direction"
OPTICS = "optics of each yarn"
AFAR = "yarns too small to be seen"
TRANSMISSION = "light through the fibres"
GAMUT = "colors outside Rec.709"


@dataclass(frozen=True, slots=True)
class Effect:
    """What becomes of one effect of the exact cloth.

    `how` says what stands in for it. `error` is measured where it can be: Σ |f̂ − f| / Σ f of the
    tile's reflectance, over pairs of directions that were not fitted.
    """

    effect: str
    fate: Fate
    how: str = ""
    error: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """Return the effect as JSON types, without the keys that say nothing."""
        return {key: value for key, value in asdict(self).items() if value not in (None, "")}


@dataclass(frozen=True, slots=True)
class NetworkLosses:
    """The effects of one network: its name, where it is and who reads it."""

    network: str
    where: str
    readers: str
    effects: tuple[Effect, ...]

    def as_dict(self) -> dict[str, Any]:
        """Return the losses as JSON types."""
        effects = [effect.as_dict() for effect in self.effects]
        return {"network": self.network, "where": self.where, "effects": effects}


def losses_of(material: ClothMaterial, also: Collection[str] = ()) -> tuple[NetworkLosses, ...]:
    """Return the losses of every network of the cloth's look and MaterialX document.

    `also` names those on request that it has: ``exact``, ``glslfx``, ``gltf`` and ``u3m``. An
    effect that the cloth does not have, such as transmission where no fibre transmits, is left
    out.
    """
    fits, errors = material.fits, material.fits.errors
    always = (
        NetworkLosses(
            "mitsuba",
            f"outputs:{MITSUBA_CONTEXT}:surface",
            f"weaveusd render, by its BSDF {CLOTH_SHADER_ID}",
            _exact(material),
        ),
        NetworkLosses(
            "openpbr",
            f"outputs:mtlx:surface, variant openPbr of {MTLX_SURFACES}; material.mtlx",
            "renderers of MaterialX 1.39",
            _lobe_a_yarn(material, errors.openpbr, _widened(errors.openpbr_afar)),
        ),
        NetworkLosses(
            "standard_surface",
            f"outputs:mtlx:surface, variant standardSurface of {MTLX_SURFACES}; material.mtlx",
            "renderers of older MaterialX",
            _standard(
                material, fits.together, _carried(DIRECTION), _dropped_optics(material),
                "one anisotropic lobe for all yarns over a diffuse base", errors.standard_surface,
                Effect(AFAR, "dropped"),
            ),
        ),
        NetworkLosses(
            "preview",
            "outputs:surface",
            "every renderer of USD",
            _standard(
                material, fits.isotropic, Effect(DIRECTION, "dropped"),
                _one_number_a_yarn(material, "a roughness for each yarn"),
                "a lobe without direction for each yarn over a diffuse base", errors.preview,
                _widened(errors.preview_afar),
            ),
        ),
    )  # fmt: skip
    return always + tuple(made for made in _on_request(material) if made.network in also)


def differing(
    losses: Sequence[NetworkLosses], default: Sequence[NetworkLosses]
) -> dict[str, tuple[Effect, ...]]:
    """Return by network the effects of `losses` that are not as in `default`, a colorway's.

    A network without any is left out.
    """
    known = {network.network: set(network.effects) for network in default}
    own = {n.network: tuple(e for e in n.effects if e not in known[n.network]) for n in losses}
    return {network: effects for network, effects in own.items() if effects}


def losses_as_json(
    losses: Sequence[NetworkLosses], others: Mapping[str, Sequence[NetworkLosses]] | None = None
) -> list[dict[str, Any]]:
    """Return `losses` as JSON types.

    Of `others`, the losses of more colorways by name, each network has under ``colorways`` the
    effects that are not as in `losses`, where there are any.
    """
    found = {network.network: network.as_dict() for network in losses}
    for colorway, own in (others or {}).items():
        for network, effects in differing(own, losses).items():
            listed = found[network].setdefault("colorways", {})
            listed[colorway] = [effect.as_dict() for effect in effects]
    return list(found.values())


def _on_request(material: ClothMaterial) -> tuple[NetworkLosses, ...]:
    """Return the losses of the exact BSDF in GLSL, where lights have no error, and other doors."""
    dome = "exact for lights; a dome by its irradiance and the directional albedo"
    return (
        NetworkLosses(
            "exact", "exact.mtlx", "renderers of MaterialX that run GLSL",
            _with(_exact(material), {
                REFLECTANCE: ("approximated", dome),
                GAMUT: ("approximated", "clipped to Rec.709"),
            }),
        ),
        NetworkLosses(
            "glslfx", f"outputs:{GLSLFX_CONTEXT}:surface", "Storm and usdview",
            _with(_exact(material), {
                REFLECTANCE: ("approximated", dome),
                AFAR: ("dropped", ""),
                GAPS: ("approximated", "cut out where less than half is covered"),
                OPTICS: ("approximated", "by a filtered yarn id, wrong between yarns"),
                GAMUT: ("approximated", "clipped to Rec.709"),
            }),
        ),
        NetworkLosses(
            "gltf", f"{material.name}.glb", "viewers of glTF with KHR_materials_anisotropy",
            _with(_lobe_a_yarn(material, material.fits.errors.openpbr), {
                GAPS: ("approximated", "cut out where less than half is covered"),
            }),
        ),
        NetworkLosses(
            "u3m", f"{material.name}.u3m", "programs for garments",
            _lobe_a_yarn(material, None),
        ),
    )  # fmt: skip


def _lobe_a_yarn(
    material: ClothMaterial, error: float | None, afar: Effect | None = None
) -> tuple[Effect, ...]:
    """Return the effects of a shader that has the lobe of every yarn in its textures."""
    return _standard(
        material,
        material.fits.yarns[0],
        _carried(DIRECTION),
        _one_number_a_yarn(material, "a roughness and an anisotropy for each yarn"),
        "an anisotropic lobe for each yarn over a diffuse base",
        error,
        afar or Effect(AFAR, "dropped"),
    )


def _widened(error: float) -> Effect:
    """Return what the mip levels of the lobe maps make of yarns; `error` is that of the tile."""
    how = "one lobe for all below a texel, in the mip levels of the files"
    return Effect(AFAR, "approximated", how, error)


def _one_number_a_yarn(material: ClothMaterial, how: str) -> Effect | None:
    return Effect(OPTICS, "approximated", how) if _several_optics(material) else None


def _dropped_optics(material: ClothMaterial) -> Effect | None:
    return Effect(OPTICS, "dropped") if _several_optics(material) else None


def _carried(effect: str) -> Effect:
    return Effect(effect, "carried")


def _with(effects: tuple[Effect, ...], changed: dict[str, tuple[Fate, str]]) -> tuple[Effect, ...]:
    """Return `effects`, those of the names in `changed` with that fate and reason."""
    return tuple(
        Effect(effect.effect, *changed[effect.effect]) if effect.effect in changed else effect
        for effect in effects
    )


def _exact(material: ClothMaterial) -> tuple[Effect, ...]:
    """Return the effects of the exact shader, which has all of them but unreachable colors."""
    color = _carried(COLOR)
    short = [
        yarn.name
        for yarn, measured in zip(material.weave.yarns, material.measured, strict=True)
        if measured.reached != yarn.color
    ]
    if short:
        how = f"darker in {len(short)} of {len(material.weave.yarns)} yarns: weave:colorReached"
        color = Effect(COLOR, "approximated", how)
    kept = [RELIEF, GAPS, DIRECTION, REFLECTANCE, AFAR]
    if _several_optics(material):
        kept.append(OPTICS)
    return (color, *map(_carried, (*kept, *_special(material))))


def _standard(
    material: ClothMaterial,
    fit: StandardFit,
    direction: Effect,
    optics: Effect | None,
    how: str,
    error: float | None,
    afar: Effect,
) -> tuple[Effect, ...]:
    color = _carried(COLOR)
    if fit.base < 1:
        weight = f"{fit.base:.0%} of it in the diffuse base, the rest left to the highlight"
        color = Effect(COLOR, "approximated", weight)
    effects = [
        color,
        _carried(RELIEF),
        _carried(GAPS),
        direction,
        Effect(REFLECTANCE, "approximated", how, error),
        afar,
    ]
    if optics is not None:
        effects.append(optics)
    special = _special(material)
    if TRANSMISSION in special:
        most = max(yarn.optics.tau for yarn in material.weave.yarns)
        effects.append(Effect(TRANSMISSION, "dropped", f"up to {most:.0%} of the volume lobe"))
    if GAMUT in special:
        effects.append(Effect(GAMUT, "approximated", "clipped to Rec.709"))
    return tuple(effects)


def _special(material: ClothMaterial) -> list[str]:
    """Return the effects that only some cloths have."""
    found = []
    if any(yarn.optics.tau > 0 for yarn in material.weave.yarns):
        found.append(TRANSMISSION)
    if material.color_space != "lin_rec709":
        found.append(GAMUT)
    return found


def _several_optics(material: ClothMaterial) -> bool:
    return len({yarn.optics for yarn in material.weave.yarns}) > 1
