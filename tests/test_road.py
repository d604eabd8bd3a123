"""The whole road: drafts become assets that can be moved, opened, read and rendered."""

from __future__ import annotations

import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

import weaveusd
from weaveusd import contract, pipeline
from weaveusd.draft.make import make_draft
from weaveusd.draft.write import write_wif
from weaveusd.patch import Patch
from weaveusd.yarn.recipe import preset_names, read_preset

ROOT = Path(__file__).parents[1]
DRAFTS = ROOT / "examples" / "drafts"
CORPUS = ROOT.parent / "shared" / "corpus"
TWILL = DRAFTS / "twill_2_2.wif"


def drafts() -> list[Path]:
    ours = sorted(DRAFTS.glob("*.wif"))
    theirs = [CORPUS / f"ThunderLoom__{n}.wif" for n in ("8452", "16")]
    return ours + [p for p in theirs if p.is_file()]


@pytest.mark.parametrize("draft", drafts(), ids=lambda p: p.stem)
@pytest.mark.parametrize("preset", ["linen", "silk"])
def test_a_draft_is_published_without_a_fault_and_survives_a_move(
    draft, preset, tmp_path, monkeypatch
):
    done = weaveusd.publish(draft, preset=preset, root=tmp_path / "root", resolution=256)
    assert done.asset.status == "published"
    assert done.findings == []

    moved = tmp_path / "elsewhere"
    shutil.move(done.asset.folder, moved)
    (tmp_path / "cwd").mkdir()
    monkeypatch.chdir(tmp_path / "cwd")
    report = weaveusd.validate(moved / done.asset.entry.name)
    assert report.passed
    assert {f.status.name for f in report.findings} <= {"PASS", "SKIP"}
    usd = [f for f in report.findings if f.check.startswith("usd/")]
    assert usd
    assert all(f.status.name == "PASS" for f in usd)


@pytest.mark.parametrize("preset", preset_names())
def test_every_preset_is_published_without_a_fault(preset, tmp_path):
    """Slubs, hairs and uneven colors break no check, in a fabric's own weave."""
    draft = tmp_path / "own.wif"
    draft.write_bytes(write_wif(make_draft(read_preset(preset).weave or "plain")))
    done = weaveusd.publish(draft, preset=preset, root=tmp_path / "root", resolution=256)
    assert done.findings == []


def test_a_reader_without_our_schema_sees_every_value(tmp_path):
    done = weaveusd.publish(TWILL, preset="wool", root=tmp_path, resolution=64)
    script = textwrap.dedent(
        f"""
        from pxr import Usd, UsdShade
        stage = Usd.Stage.Open({str(done.asset.entry)!r})
        prim = stage.GetPrimAtPath({done.asset.material!r})
        assert not Usd.SchemaRegistry().FindAppliedAPIPrimDefinition("WeaveClothAPI")
        print(prim.GetPrimTypeInfo().GetAppliedAPISchemas())
        for attribute in prim.GetAttributes():
            if attribute.GetName().startswith("weave:"):
                assert attribute.HasAuthoredValue(), attribute
                print(attribute.GetName(), attribute.Get())
        """
    )
    out = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    ).stdout
    for attribute in contract.CLOTH_ATTRIBUTES:
        assert f"{contract.CLOTH_NAMESPACE}:{attribute.name} " in out
    for attribute in contract.YARN_ATTRIBUTES:
        assert f"{contract.YARN_NAMESPACE}:warp_1:{attribute.name} " in out
    assert contract.CLOTH_API in out
    assert f"{contract.YARN_API}:warp_1" in out


def test_with_our_schema_the_attributes_are_documented(tmp_path):
    from weaveusd.stage import open_stage

    done = weaveusd.publish(TWILL, preset="wool", root=tmp_path, resolution=64)
    stage = open_stage(done.asset.entry)
    prim = stage.GetPrimAtPath(done.asset.material)
    assert prim.HasAPI(contract.CLOTH_API)
    sett = prim.GetAttribute("weave:endsPerCm")
    assert "1/cm" in sett.GetDocumentation()
    assert sett.Get() == pytest.approx(26.8)


def test_personal_fields_of_a_draft_stay_out_of_the_asset(tmp_path):
    draft = tmp_path / "private.wif"
    secrets = b"Author=Ada\nAddress=1 Loom Street\nEMail=ada@example.org\nTelephone=5550199\n"
    head, mark, tail = TWILL.read_bytes().partition(b"[TEXT]")
    draft.write_bytes(
        head + mark + b"\n" + secrets + tail if mark else head + b"[TEXT]\n" + secrets
    )
    done = weaveusd.publish(draft, preset="linen", root=tmp_path / "root", resolution=64)
    everything = b"".join(
        p.read_bytes() for p in sorted(done.asset.folder.rglob("*")) if p.is_file()
    )
    for secret in (b"Loom Street", b"ada@example.org", b"5550199"):
        assert secret not in everything


def test_a_patch_of_several_repeats_is_one_tile(tmp_path):
    one = weaveusd.publish(TWILL, preset="wool", root=tmp_path, name="one", resolution=64)
    four = weaveusd.publish(
        TWILL, preset="wool", root=tmp_path, name="four", repeats=(2, 2), texels_per_mm=40
    )
    assert four.findings == []
    values = []
    for done in (one, four):
        stage = Usd.Stage.Open(str(done.asset.entry))
        prim = stage.GetPrimAtPath(done.asset.material)
        names = ("ends", "repeatWidth", "endsPerCm", "textureHeight")
        values.append([prim.GetAttribute(f"weave:{name}").Get() for name in names])
    (ends, width, sett, _), (all_ends, patch, same_sett, texels) = values
    assert (all_ends, patch) == (2 * ends, pytest.approx(2 * width))
    assert same_sett == pytest.approx(sett)
    assert texels == round(40 * 2 * 4 * 10 / 23.6)
    assert (four.asset.folder / "draft.wif").read_bytes() == (
        one.asset.folder / "draft.wif"
    ).read_bytes()


def test_a_patch_is_cut_to_the_nearest_repeats():
    from weaveusd.draft.wif import read_wif
    from weaveusd.yarn.recipe import read_preset

    draft, recipe = read_wif(TWILL), read_preset("linen")
    width, height = (10 * n / s for n, s in ((4, 18.9), (4, 17.3)))
    cut, resolution = Patch(size_mm=(3.2 * width, 0.2 * height)).cut(draft, recipe)
    assert (cut.ends, cut.picks, resolution) == (12, 4, 1024)


STAGE = """#usda 1.0
(
    upAxis = "Y"
    metersPerUnit = 1
)
def Scope "Cloth" ( references = @{entry}@ ) {{ }}
def Mesh "Sheet" ( prepend apiSchemas = ["MaterialBindingAPI"] )
{{
    rel material:binding = </Cloth/Material>
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-.004, -.004, 0), (.004, -.004, 0), (.004, .004, 0), (-.004, .004, 0)]
    texCoord2f[] primvars:st = [(0, 0), (.008, 0), (.008, .008), (0, .008)] (
        interpolation = "vertex" )
}}
def Camera "Eye" {{
    float focalLength = 50
    float horizontalAperture = 20
    float verticalAperture = 20
    float2 clippingRange = (.001, 10)
    double3 xformOp:translate = (.006, 0, .017)
    float3 xformOp:rotateXYZ = (0, 19.44, 0)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]
}}
def DistantLight "Sun" {{
    float inputs:intensity = 2
    float3 xformOp:rotateXYZ = (-25, -20, 0)
    uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]
}}
def DomeLight "Sky" {{
    float inputs:intensity = 0.3
}}
"""


FACE_ON = """#usda 1.0
(
    upAxis = "Y"
    metersPerUnit = 1
)
def Scope "Cloth" ( references = @{entry}@ )
{{
    over "Material"
    {{
        float2 inputs:uv_scale = (1, 1)
    }}
}}
def Mesh "Sheet" ( prepend apiSchemas = ["MaterialBindingAPI"] )
{{
    rel material:binding = </Cloth/Material>
    uniform token subdivisionScheme = "none"
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = "vertex" )
}}
def Camera "Eye" {{
    token projection = "orthographic"
    float horizontalAperture = 10
    float verticalAperture = 10
    float2 clippingRange = (.1, 10)
    double3 xformOp:translate = (.5, .5, 3)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}}
def DomeLight "Sky" {{
    float inputs:intensity = 1
}}
"""


def test_a_right_handed_twill_is_right_handed_in_every_picture(tmp_path, renderer):
    """Z: up to the right, in the texture files and in a render."""
    import OpenImageIO as oiio  # noqa: N813

    from weaveusd.draft.make import make_draft
    from weaveusd.draft.write import write_wif

    wif = tmp_path / "z.wif"
    wif.write_bytes(write_wif(make_draft("twill:2/2:Z@FFFFFF,101010")))
    done = weaveusd.publish(wif, preset="cotton", root=tmp_path, resolution=64)
    texture = oiio.ImageBuf(str(done.asset.folder / "textures" / "base_color.png")).get_pixels()
    assert climbs_to_the_right(texture[..., 0])
    stage = tmp_path / "face.usda"
    stage.write_text(FACE_ON.format(entry=f"./{done.asset.entry.relative_to(tmp_path)}"))
    assert climbs_to_the_right(weaveusd.render(stage, width=64, spp=64).image[..., 0])


def climbs_to_the_right(picture: np.ndarray) -> bool:
    """Whether a top-down picture of one repeat of four threads is alike one up, one right."""
    step = len(picture) // 4
    bright = picture > np.median(picture)

    def alike(across: int) -> float:
        return float(np.mean(np.roll(bright, (-step, across), (0, 1)) == bright))

    return alike(step) > 0.8 > alike(-step)


@pytest.mark.parametrize("preset", ["linen", pytest.param("silk", marks=pytest.mark.slow)])
def test_the_published_stage_looks_like_the_material_in_memory(
    preset, tmp_path, monkeypatch, renderer
):
    """Two-sample z-test over pixels: the pictures differ by noise and nothing else."""
    done = weaveusd.publish(TWILL, preset=preset, root=tmp_path, resolution=256)
    stage = tmp_path / "stage.usda"
    stage.write_text(STAGE.format(entry=f"./{done.asset.entry.relative_to(tmp_path)}"))

    def pictures(first_seed: int, count: int = 8) -> np.ndarray:
        return np.stack(
            [
                weaveusd.render(stage, width=24, height=24, spp=64, seed=first_seed + k).image
                for k in range(count)
            ]
        )

    published = pictures(100)

    material = pipeline.make_material(
        pipeline.read_draft(TWILL), read_preset(preset), done.asset.asset, patch=Patch(256)
    )
    optics = [yarn.optics for yarn in material.weave.yarns]
    inputs = {
        name: [getattr(o, name) for o in optics]
        for name in contract.SHADER_YARN_INPUTS
        if name != "normalization"
    }
    inputs["normalization"] = list(material.normalization)
    scale = tuple(1000 / mm for mm in material.weave.repeat_mm)
    from weaveusd.render.bsdf import cloth_bsdf_dict
    from weaveusd.render.gain import albedos

    arrays = dict(material.textures.whole())
    gains = [yarn.gain for yarn in material.measured]
    arrays["base_color"] = albedos(arrays["base_color"], arrays["yarn_id"], gains, len(gains))
    in_memory = cloth_bsdf_dict(arrays, inputs, scale)
    monkeypatch.setattr("weaveusd.render.cloth.translate", lambda *_, **__: (in_memory, "st"))
    remembered = pictures(500)

    difference = published.mean(0, dtype=float) - remembered.mean(0, dtype=float)
    variance = published.var(0, ddof=1, dtype=float) + remembered.var(0, ddof=1, dtype=float)
    assert (variance > 0).all()
    z = difference / np.sqrt(variance / len(published))
    overall = difference.mean() / np.sqrt(variance.mean() / len(published) / difference.size)
    assert abs(overall) < 4
    # Student's t with about 14 degrees of freedom has a standard deviation of 1.08.
    assert 0.9 < z.std() < 1.25
    assert np.abs(z.mean()) < 4 * 1.08 / np.sqrt(z.size / 3)  # the colors of a pixel are one
    assert published.mean() > 0.02
