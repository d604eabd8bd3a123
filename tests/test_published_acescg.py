"""An asset in ACEScg says so everywhere and shows the cloth that Rec.709 shows."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

import weaveusd
from weaveusd.contract import COLOR_SPACES
from weaveusd.draft.make import make_draft
from weaveusd.draft.write import write_wif
from weaveusd.errors import InputError, RendererUnavailableError, StageError

LINEN = Path(weaveusd.__file__).parent / "yarn" / "presets" / "linen.toml"
TURQUOISE = '{ lab = [60, -45, -30], illuminant = "D65" }'
"""Outside Rec.709, inside ACEScg."""


@pytest.fixture
def publish(tmp_path):
    """Publish a small twill whose yarns are of `color`."""
    draft = tmp_path / "twill.wif"
    draft.write_bytes(write_wif(make_draft("twill:2/2")))

    def publish(color: str, space: str) -> weaveusd.pipeline.Publication:
        text = LINEN.read_text(encoding="utf-8")
        plain = 'spine = "circle"'
        assert plain in text
        recipe = tmp_path / "recipe.toml"
        recipe.write_text(text.replace(plain, f"{plain}\ncolor = {color}"), encoding="utf-8")
        root = tmp_path / space
        return weaveusd.publish(draft, recipe=recipe, root=root, resolution=64, color_space=space)

    return publish


def authored(folder: Path, name: str) -> tuple[object, str]:
    """Return value and color space of an attribute of the material, as the look states them."""
    look = Sdf.Layer.FindOrOpen(str(folder / "look.usda"))
    spec = look.GetAttributeAtPath(f"/{look.defaultPrim}/Material{name}")
    return spec.default, spec.colorSpace or ""


def image(file: Path) -> oiio.ImageBuf:
    return oiio.ImageBuf(str(file))


def test_both_spaces_pass_their_checks_and_say_what_they_are(publish):
    for space in COLOR_SPACES:
        done = publish('"#b04020"', space)
        assert done.findings == []
        entry = done.asset.folder / done.asset.entry.name
        assert weaveusd.validate(entry).passed
        assert authored(entry.parent, ".weave:colorSpace") == (space, "")
        _, stated = authored(entry.parent, "/MitsubaSurface.inputs:base_color_file")
        assert stated == ("acescg" if space == "acescg" else "")
        spec = image(entry.parent / "textures" / "base_color.exr").spec()
        name = "lin_ap1_scene" if space == "acescg" else "lin_rec709_scene"
        assert spec.get_string_attribute("oiio:ColorSpace") == name
        primaries = spec.getattribute("chromaticities")
        assert (primaries is not None) == (space == "acescg")


def test_the_display_png_is_the_same_in_both_spaces(publish):
    pngs = []
    for space in COLOR_SPACES:
        file = publish('"#b04020"', space).asset.folder / "textures" / "base_color.png"
        pngs.append(image(file).get_pixels(oiio.UINT8).astype(int))
    assert np.ptp(pngs[0]) > 20
    assert np.abs(pngs[0] - pngs[1]).max() <= 1


def test_a_gray_asset_has_the_same_colors_in_both_spaces(publish):
    linears, attributes = [], []
    for space in COLOR_SPACES:
        folder = publish('"#808080"', space).asset.folder
        linears.append(image(folder / "textures" / "base_color.exr").get_pixels(oiio.FLOAT))
        attributes.append(authored(folder, ".weave:yarn:warp_1:color"))
    np.testing.assert_allclose(linears[0], linears[1], rtol=2e-3)
    assert attributes[0] == attributes[1]


def test_a_saturated_color_is_reported_in_rec709_and_kept_in_acescg(publish):
    narrow, wide = (publish(TURQUOISE, space) for space in COLOR_SPACES)
    (finding,) = narrow.findings
    assert finding["code"] == "recipe-not-kept"
    assert "is outside Rec.709" in finding["message"]
    assert wide.findings == []
    assert json.dumps(wide.as_dict())


def test_an_unknown_space_is_refused(publish):
    with pytest.raises(InputError, match="found 'rec2020', expected lin_rec709 or acescg"):
        publish('"#808080"', "rec2020")


def card(asset: Path, path: Path) -> Path:
    """Write a stage with a square of the cloth, seen from above under a dome and a sun."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    mesh = UsdGeom.Mesh.Define(stage, "/Card")
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    mesh.CreatePointsAttr([Gf.Vec3f(x, y, 0) for x, y in corners])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying
    )
    st.Set([Gf.Vec2f(0.001 * (x + 1), 0.001 * (y + 1)) for x, y in corners])
    camera = UsdGeom.Camera.Define(stage, "/Camera")
    camera.AddTranslateOp().Set((0, 0, 10))
    camera.CreateHorizontalApertureAttr(20.0)
    camera.CreateVerticalApertureAttr(20.0)
    camera.CreateFocalLengthAttr(60.0)
    UsdLux.DomeLight.Define(stage, "/Dome").CreateIntensityAttr(0.5)
    sun = UsdLux.DistantLight.Define(stage, "/Sun")
    sun.AddRotateYOp().Set(40.0)
    sun.CreateAngleAttr(0.0)
    sun.CreateIntensityAttr(2.0)
    cloth = stage.DefinePrim("/Cloth")
    cloth.GetReferences().AddReference(str(asset))
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(
        UsdShade.Material(stage.GetPrimAtPath("/Cloth/Material"))
    )
    stage.Save()
    return path


def rendered(done: weaveusd.pipeline.Publication, path: Path, change: str = "") -> tuple:
    stage = card(done.asset.folder / done.asset.entry.name, path)
    if change:
        opened = Usd.Stage.Open(str(stage))
        attribute = opened.GetAttributeAtPath(
            "/Cloth/Material/MitsubaSurface.inputs:base_color_file"
        )
        attribute.SetColorSpace(change)
        opened.Save()
    try:
        result = weaveusd.render(stage, None, width=24, spp=256)
    except RendererUnavailableError as error:
        pytest.skip(str(error))
    return result.image, [str(loss) for loss in result.losses]


def test_both_spaces_render_as_one(publish, tmp_path):
    narrow, wide = (
        rendered(publish('"#b04020"', space), tmp_path / f"{space}.usda") for space in COLOR_SPACES
    )
    assert narrow[1] == wide[1] == []
    assert np.ptp(narrow[0]) > 0.05
    np.testing.assert_allclose(wide[0], narrow[0], rtol=0.01, atol=1e-4)


def test_what_a_render_clips_is_a_loss(publish, tmp_path):
    wide = publish(TURQUOISE, "acescg")
    (loss,) = rendered(wide, tmp_path / "wide.usda")[1]
    assert "texels of base_color_file are outside Rec.709, in which Mitsuba renders" in loss
    narrow, losses = rendered(publish(TURQUOISE, "lin_rec709"), tmp_path / "narrow.usda")
    assert losses == []
    assert narrow.min() >= 0


def test_a_space_that_no_renderer_knows_is_refused(publish, tmp_path):
    done = publish('"#808080"', "lin_rec709")
    with pytest.raises(StageError, match="has color space 'rec2020', expected lin_rec709 or aces"):
        rendered(done, tmp_path / "odd.usda", "rec2020")
