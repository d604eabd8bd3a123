"""UsdPreviewSurface and its texture nodes as Mitsuba's `principled`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import mitsuba as mi
import numpy as np
from pxr import Usd, UsdShade

from weaveusd.errors import StageError
from weaveusd.render import textures
from weaveusd.render.model import Losses
from weaveusd.render.nodes import feeding_node, four_channels, node_value, transform_2d

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Doubles = NDArray[np.float64]

SHADER_ID = "UsdPreviewSurface"
TEXTURE_ID = "UsdUVTexture"
TRANSFORM_ID = "UsdTransform2d"
READER_ID = "UsdPrimvarReader_float2"

_FALLBACKS: dict[str, Any] = {
    "diffuseColor": (0.18, 0.18, 0.18),
    "emissiveColor": (0.0, 0.0, 0.0),
    "useSpecularWorkflow": 0,
    "metallic": 0.0,
    "roughness": 0.5,
    "clearcoat": 0.0,
    "clearcoatRoughness": 0.01,
    "opacity": 1.0,
    "opacityThreshold": 0.0,
    "ior": 1.5,
    "normal": (0.0, 0.0, 1.0),
    "displacement": 0.0,
    "occlusion": 1.0,
}
_CHANNELS = {"r": 0, "g": 1, "b": 2, "a": 3}
_WRAPS = {"repeat": "repeat", "mirror": "mirror", "clamp": "clamp", "useMetadata": "repeat"}
_SMOOTHEST, _LOWEST_ETA = 1e-3, 1.001


@dataclass(frozen=True, slots=True)
class Preview:
    """A translated surface: BSDF, primvar of its coordinates, emission, whether it is one-sided."""

    bsdf: dict[str, Any]
    uv: str | None
    emission: dict[str, Any] | None
    opaque: bool


def translate(shader: UsdShade.Shader, time: Usd.TimeCode, losses: Losses) -> Preview:
    """Return the surface as Mitsuba describes it.

    Raises
    ------
    StageError
        One line, when a texture is missing or broken.
    """
    return _Network(shader, time, losses).surface()


class _Network:
    """Reads the inputs of one surface and remembers which primvar its textures follow."""

    def __init__(self, shader: UsdShade.Shader, time: Usd.TimeCode, losses: Losses) -> None:
        self.shader, self.time, self.losses = shader, time, losses
        self.uv: str | None = None

    def surface(self) -> Preview:
        """Return the whole surface."""
        self._note_unsupported()
        base = self._color("diffuseColor")
        ior = self._number("ior")
        lambert = ior == 1.0 and self._number("metallic") == 0 and self._number("clearcoat") == 0
        bsdf: dict[str, Any]
        if lambert and not self._textured("metallic", "clearcoat"):
            bsdf = {"type": "diffuse", "reflectance": base}
        else:
            bsdf = {
                "type": "principled",
                "base_color": base,
                "metallic": self._scalar("metallic"),
                "roughness": self._scalar("roughness", _SMOOTHEST),
                "eta": max(ior, _LOWEST_ETA),
            }
            bsdf |= self._coat()
        bsdf = self._bumped(bsdf)
        opacity = self._opacity()
        if opacity is not None:
            # mask refuses to lie inside twosided, so the two-sided surface lies inside the mask.
            bsdf = {"type": "mask", "opacity": opacity, "bsdf": {"type": "twosided", "bsdf": bsdf}}
        return Preview(bsdf, self.uv, self._emission(), opacity is None)

    def _coat(self) -> dict[str, Any]:
        if not self._textured("clearcoat") and self._number("clearcoat") == 0:
            return {}
        if self._textured("clearcoatRoughness"):
            self.losses.approximated(
                self.shader.GetPrim(), "textured clearcoatRoughness is taken as its fallback"
            )
        gloss = 1 - min(max(self._number("clearcoatRoughness"), 0.0), 1.0)
        return {"clearcoat": self._scalar("clearcoat"), "clearcoat_gloss": gloss}

    def _bumped(self, bsdf: dict[str, Any]) -> dict[str, Any]:
        source = self._source("normal")
        if source is None:
            return bsdf
        # Normals are scaled and biased to -1…1 in USD; Mitsuba undoes 0…1 itself.
        encoded = self._bitmap(source, "normal", lambda pixels: pixels * 0.5 + 0.5)
        return {
            "type": "normalmap",
            "normalmap": encoded,
            "use_shadowing_function": False,  # UsdPreviewSurface knows none
            "bsdf": bsdf,
        }

    def _opacity(self) -> Any | None:
        """Return the opacity where it is not 1 everywhere."""
        threshold = self._number("opacityThreshold")
        source = self._source("opacity")
        if source is not None:
            cut = (lambda p: (p >= threshold).astype(np.float32)) if threshold > 0 else None
            return self._bitmap(source, "opacity", cut)
        opacity = min(max(self._number("opacity"), 0.0), 1.0)
        if threshold > 0:
            opacity = float(opacity >= threshold)
        return None if opacity == 1.0 else opacity

    def _emission(self) -> dict[str, Any] | None:
        if self._source("emissiveColor") is None and not any(self._value("emissiveColor")):
            return None
        return {"type": "area", "radiance": self._color("emissiveColor", bounded=False)}

    def _note_unsupported(self) -> None:
        prim = self.shader.GetPrim()
        if self._number("useSpecularWorkflow") != 0:
            self.losses.approximated(prim, "specular workflow is shown as a dielectric of its ior")
        if self._textured("displacement") or self._number("displacement") != 0:
            self.losses.dropped(prim, "displacement")
        if self._textured("occlusion"):
            self.losses.dropped(prim, "occlusion map: the picture has its own")
        if self._textured("ior"):
            self.losses.approximated(prim, "textured ior is taken as its fallback")
        if not self._textured("ior") and self._number("ior") < 1:
            self.losses.approximated(prim, "ior below 1 is taken as 1")

    # --- Inputs ---------------------------------------------------------------------------------

    def _textured(self, *names: str) -> bool:
        return any(self._source(name) is not None for name in names)

    def _source(self, name: str) -> tuple[UsdShade.Shader, str] | None:
        """Return the texture node and output that feed an input, or None."""
        given = self.shader.GetInput(name)
        if not given:
            return None
        for attribute in UsdShade.Utils.GetValueProducingAttributes(given):
            node = UsdShade.Shader(attribute.GetPrim())
            if UsdShade.Output.IsOutput(attribute) and node:
                if node.GetShaderId() == TEXTURE_ID:
                    return node, UsdShade.Output(attribute).GetBaseName()
                self.losses.dropped(node.GetPrim(), f"{node.GetShaderId()} feeding {name}")
        return None

    def _value(self, name: str) -> Any:
        """Return an input's own value, or the fallback that UsdPreviewSurface has for it."""
        value = node_value(self.shader, name, self.time)
        return _FALLBACKS[name] if value is None else value

    def _number(self, name: str) -> float:
        return float(self._value(name))

    def _scalar(self, name: str, low: float = 0.0) -> Any:
        source = self._source(name)
        if source is not None:
            return self._bitmap(source, name, lambda pixels: np.clip(pixels, low, 1))
        return min(max(self._number(name), low), 1.0)

    def _color(self, name: str, *, bounded: bool = True) -> Any:
        source = self._source(name)
        high = 1.0 if bounded else np.inf
        if source is not None:
            return self._bitmap(source, name, lambda pixels: np.clip(pixels, 0, high))
        value = [float(np.clip(v, 0, high)) for v in self._value(name)]
        return {"type": "rgb", "value": value}

    # --- Textures -------------------------------------------------------------------------------

    def _bitmap(self, source: tuple[UsdShade.Shader, str], name: str, change: Any) -> Any:
        """Return Mitsuba's texture of a UsdUVTexture's output, with `change` applied last."""
        node, output = source
        path = node.GetPath()
        where = f"{path}.inputs:file"
        image = textures.read_image(
            textures.resolved(node_value(node, "file", self.time), where), where
        )
        space = str(node_value(node, "sourceColorSpace", self.time) or "auto")
        pixels = four_channels(textures.linear(image, space))
        for kind, neutral in (("scale", 1.0), ("bias", 0.0)):
            given = node_value(node, kind, self.time)
            factor = np.array(given if given is not None else (neutral,) * 4, np.float32)
            pixels = pixels * factor if kind == "scale" else pixels + factor
        if output == "rgb":
            chosen = pixels[..., :3]
        elif output in _CHANNELS:
            chosen = pixels[..., _CHANNELS[output], None]
            if name in ("diffuseColor", "emissiveColor", "normal"):
                chosen = np.repeat(chosen, 3, axis=2)
        else:
            raise StageError(f"{path}: has no output {output}")
        if name not in ("diffuseColor", "emissiveColor", "normal"):
            chosen = chosen[..., :1]
        chosen = chosen if change is None else change(chosen)
        return {
            "type": "bitmap",
            "bitmap": mi.Bitmap(np.ascontiguousarray(chosen, np.float32)),
            "raw": True,
            "format": "variant",
            "wrap_mode": self._wrap(node),
            "to_uv": mi.ScalarTransform3f(self._coordinates(node)),
        }

    def _wrap(self, node: UsdShade.Shader) -> str:
        wrap_s, wrap_t = (
            str(node_value(node, name, self.time) or "useMetadata") for name in ("wrapS", "wrapT")
        )
        mode = _WRAPS.get(wrap_s, "clamp")
        if "black" in (wrap_s, wrap_t):
            self.losses.approximated(node.GetPrim(), "wrap mode black is shown as clamp")
        elif _WRAPS.get(wrap_t) != mode:
            self.losses.approximated(node.GetPrim(), f"wrapT {wrap_t} is shown as wrapS {wrap_s}")
        return mode

    def _coordinates(self, node: UsdShade.Shader) -> Doubles:
        """Return `to_uv` = F·T·R·S, F turning USD's t upwards into Mitsuba's v downwards."""
        matrix = np.array(((1.0, 0.0, 0.0), (0.0, -1.0, 1.0), (0.0, 0.0, 1.0)))
        feeding, attribute = node, "st"
        for _ in range(16):
            source = feeding_node(feeding, attribute)
            if source is None:
                break
            if source.GetShaderId() == TRANSFORM_ID:
                matrix = matrix @ transform_2d(source, self.time)
                feeding, attribute = source, "in"
                continue
            if source.GetShaderId() == READER_ID:
                self._follow(source)
            else:
                self.losses.dropped(source.GetPrim(), f"{source.GetShaderId()} feeding st")
            return matrix
        self.losses.dropped(node.GetPrim(), "texture follows no primvar: its coordinates are 0")
        return matrix

    def _follow(self, reader: UsdShade.Shader) -> None:
        name = str(node_value(reader, "varname", self.time) or "st")
        if self.uv is None:
            self.uv = name
        elif self.uv != name:
            self.losses.approximated(
                reader.GetPrim(), f"texture coordinates {name} are shown as {self.uv}"
            )
