"""The binary glTF says in glTF's words what the asset says, and lies the right way up."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.export.cloths import FIT, REPEAT_MM, cloth
from tests.web.tools import browser, run_node
from weaveusd.contract import VECTOR_PNG_LEVELS
from weaveusd.errors import InputError, WeaveusdError
from weaveusd.export import gltf
from weaveusd.export.asset import write_asset
from weaveusd.export.files import CLOTH_ITSELF
from weaveusd.export.gltf import write_gltf
from weaveusd.export.gltf_pictures import gltf_lobe
from weaveusd.export.images import read_image, write_png8
from weaveusd.shading.material import StandardFit


class Glb:
    """A binary glTF taken apart by its specification (glTF 2.0, 4.4)."""

    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        assert data[:4] == b"glTF"
        version, length = np.frombuffer(data[4:12], "<u4").tolist()
        assert (version, length) == (2, len(data))
        size = int.from_bytes(data[12:16], "little")
        assert data[16:20] == b"JSON"
        self.json = json.loads(data[20 : 20 + size])
        binary = data[20 + size :]
        assert binary[4:8] == b"BIN\0"
        self.binary = binary[8:]
        assert len(self.binary) == int.from_bytes(binary[:4], "little")

    def view(self, index: int) -> bytes:
        view = self.json["bufferViews"][index]
        assert view["byteOffset"] % 4 == 0
        return self.binary[view["byteOffset"] :][: view["byteLength"]]

    def array(self, name: str) -> np.ndarray:
        (primitive,) = self.json["meshes"][0]["primitives"]
        accessor = self.json["accessors"][primitive["attributes"][name]]
        return np.frombuffer(self.view(accessor["bufferView"]), "<f4").reshape(4, -1)

    def picture(self, texture: dict, folder: Path) -> np.ndarray:
        image = self.json["images"][self.json["textures"][texture["index"]]["source"]]
        path = folder / f"{image['name']}.png"
        path.write_bytes(self.view(image["bufferView"]))
        return read_image(path)

    @property
    def material(self) -> dict:
        return self.json["materials"][0]


def assert_the_right_way_up(pixels: list[int]) -> None:
    """The cloth is redder to the right and greener to the top; the first row is the lowest."""
    drawn = np.array(pixels).reshape(64, 64, 4)[..., :3].astype(float)
    there = drawn.max(-1) > 30
    y, x = np.nonzero(there)
    assert there.mean() > 0.8
    assert np.corrcoef(x, drawn[there][:, 0])[0, 1] > 0.8
    assert np.corrcoef(y, drawn[there][:, 1])[0, 1] > 0.8


@pytest.fixture(scope="module")
def asset(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("asset")
    write_asset(cloth(), path)
    return path


@pytest.fixture(scope="module")
def glb(asset) -> Glb:
    path = asset.with_name("plain.glb")
    write_gltf(cloth(), asset, CLOTH_ITSELF, path)
    return Glb(path)


def across(asset: Path) -> np.ndarray:
    """Normal × fibre of the asset's 16-bit pictures."""
    normal, tangent = (
        read_image(asset / "textures" / f"{name}.png").astype(float) * 65535
        / (VECTOR_PNG_LEVELS / 2) - 1 for name in ("normal", "tangent")
    )  # fmt: skip
    return np.cross(normal, tangent)


def test_texture_coordinates_are_metres_down_from_the_upper_left_corner(glb):
    position, uv = glb.array("POSITION"), glb.array("TEXCOORD_0")
    left, top = position[:, 0].min(), position[:, 1].max()
    np.testing.assert_allclose(uv[:, 0], position[:, 0] - left, atol=1e-7)
    np.testing.assert_allclose(uv[:, 1], top - position[:, 1], atol=1e-7)
    for name in ("baseColorTexture", "metallicRoughnessTexture"):
        transform = glb.material["pbrMetallicRoughness"][name]["extensions"]
        scale = transform["KHR_texture_transform"]["scale"]
        assert scale == [1000 / length for length in REPEAT_MM]
    assert glb.json["extensionsRequired"] == ["KHR_texture_transform"]


def test_tangent_and_bitangent_are_those_of_the_cloth_frame(glb):
    normal, tangent = glb.array("NORMAL"), glb.array("TANGENT")
    assert np.all(tangent[:, :3] == [1, 0, 0])
    bitangent = np.cross(normal, tangent[:, :3]) * tangent[:, 3:]
    assert np.all(bitangent == [0, 1, 0])


def test_the_top_row_of_each_picture_is_that_of_the_textures(glb, asset, tmp_path):
    textures = asset / "textures"
    color = glb.picture(glb.material["pbrMetallicRoughness"]["baseColorTexture"], tmp_path)
    assert np.array_equal(color[..., :3], read_image(textures / "base_color.png"))
    assert np.array_equal(color[..., 3:], read_image(textures / "opacity.png"))
    surface = glb.picture(glb.material["occlusionTexture"], tmp_path)
    assert np.array_equal(surface[..., :1], read_image(textures / "ambient_occlusion.png"))
    normal = glb.picture(glb.material["normalTexture"], tmp_path)
    exact = read_image(textures / "normal.png") * 65535 / VECTOR_PNG_LEVELS
    assert np.abs(normal / 255 - exact).max() <= 0.5 / 255 + 1e-6


def test_the_direction_of_anisotropy_is_across_the_fibre(glb, asset, tmp_path):
    picture = glb.picture(
        glb.material["extensions"]["KHR_materials_anisotropy"]["anisotropyTexture"], tmp_path
    )
    direction = picture[..., :2] / 255 * 2 - 1
    wanted = across(asset)[..., :2]
    length = np.linalg.norm(wanted, axis=-1)
    clear = length > 0.1
    cosine = np.sum(direction * wanted, -1)[clear] / length[clear]
    assert cosine.min() > 0.99


def test_roughness_and_strength_are_those_of_each_yarn_and_none_in_gaps(glb, asset, tmp_path):
    strength = glb.picture(
        glb.material["extensions"]["KHR_materials_anisotropy"]["anisotropyTexture"], tmp_path
    )[..., 2]
    roughness = glb.picture(
        glb.material["pbrMetallicRoughness"]["metallicRoughnessTexture"], tmp_path
    )[..., 1]
    yarn = read_image(asset / "textures" / "opacity.png")[..., 0] == 255
    lobe = gltf_lobe(FIT)
    assert set(strength[~yarn]) == {0}
    assert set(roughness[~yarn]) == {255}
    assert set(strength[yarn]) == {round(255 * lobe.strength)}
    assert set(roughness[yarn]) == {round(255 * lobe.roughness)}


@pytest.mark.parametrize("along", [0.01, 0.2, 0.7, 1.0])
@pytest.mark.parametrize("across", [0.01, 0.5, 1.0])
def test_a_lobe_has_the_roughnesses_of_its_fit_by_the_formula_of_the_extension(along, across):
    if along > across:
        return
    lobe = gltf_lobe(StandardFit(alpha_along=along, alpha_across=across, f0=0.04))
    alpha = lobe.roughness**2
    assert alpha == pytest.approx(along)
    assert alpha + (1 - alpha) * lobe.strength**2 == pytest.approx(across)


def test_gaps_are_cut_out_and_stay_cloth_from_afar(glb, asset):
    opacity = read_image(asset / "textures" / "opacity.png") / 255
    assert glb.material["alphaMode"] == "MASK"
    assert 0.3 * opacity.mean() < glb.material["alphaCutoff"] <= 0.5
    assert glb.material["doubleSided"] is True


def test_a_cloth_without_gaps_is_opaque(asset, tmp_path):
    whole = tmp_path / "whole"
    shutil.copytree(asset, whole)
    path = whole / "textures" / "opacity.png"
    write_png8(path, np.full_like(read_image(path), 255))
    write_gltf(cloth(), whole, CLOTH_ITSELF, tmp_path / "whole.glb")
    found = Glb(tmp_path / "whole.glb")
    assert "alphaMode" not in found.material
    color = found.picture(found.material["pbrMetallicRoughness"]["baseColorTexture"], tmp_path)
    assert color.shape[2] == 3


def test_the_dielectric_reflects_as_the_fit_does(glb):
    ior = glb.material["extensions"]["KHR_materials_ior"]["ior"]
    assert ((ior - 1) / (ior + 1)) ** 2 == pytest.approx(FIT.f0)
    assert glb.material["pbrMetallicRoughness"]["metallicFactor"] == 0
    assert glb.material["pbrMetallicRoughness"]["baseColorFactor"] == [FIT.base] * 3 + [1]
    used = set(glb.json["extensionsUsed"])
    assert used == {"KHR_materials_anisotropy", "KHR_materials_ior", "KHR_texture_transform"}


def test_the_same_asset_gives_the_same_bytes(glb, asset, tmp_path):
    write_gltf(cloth(), asset, CLOTH_ITSELF, tmp_path / "again.glb")
    assert Glb(tmp_path / "again.glb").binary == glb.binary
    assert (tmp_path / "again.glb").read_bytes() == asset.with_name("plain.glb").read_bytes()


def test_more_than_a_binary_gltf_can_count_is_refused(asset, tmp_path, monkeypatch):
    monkeypatch.setattr(gltf, "MAX_BYTES", 1000)
    with pytest.raises(WeaveusdError, match="expected at most 1000 in a binary glTF"):
        write_gltf(cloth(), asset, CLOTH_ITSELF, tmp_path / "large.glb")


def test_a_missing_texture_is_named(tmp_path):
    with pytest.raises(InputError, match=r"textures/opacity\.png: not a readable image"):
        write_gltf(cloth(), tmp_path, CLOTH_ITSELF, tmp_path / "none.glb")


def test_khronos_finds_no_error_and_nothing_to_warn_of(glb, asset):
    (report,) = run_node("gltf.mjs", asset.with_name("plain.glb"))
    assert (report["numErrors"], report["numWarnings"]) == (0, 0), report["messages"]
    # The draft decides how many texels there are, and it is seldom a power of two.
    assert {m["code"] for m in report["messages"]} <= {"IMAGE_NPOT_DIMENSIONS"}
    assert report["info"]["totalVertexCount"] == 4


def test_three_js_shows_it_with_every_texture(glb, asset):
    shown = run_node("page.mjs", browser(), "panel.mjs", asset.with_name("plain.glb"))["result"]
    assert_the_right_way_up(shown["pixels"])
    assert shown["meshes"] == 1
    for name in ("map", "normalMap", "roughnessMap", "aoMap", "anisotropyMap"):
        assert shown["maps"][name]["width"] == 32, name
        assert shown["maps"][name]["wrap"], name
    assert shown["maps"]["map"]["srgb"]
    assert shown["material"]["alphaTest"] == glb.material["alphaCutoff"]
