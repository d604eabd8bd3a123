"""The lobe maps: each yarn's fit at the finest level, the tile's at the coarsest, means between."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenImageIO as oiio  # noqa: N813
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.export.cloths import FIT, ROUND, cloth, texture_set
from tests.weaves import satin, woven
from weaveusd.contract import LOBE_MAPS, lobe_file
from weaveusd.export import textures as writing
from weaveusd.export.asset import write_asset
from weaveusd.export.images import read_image
from weaveusd.export.lobe_maps import _Level, lobe_maps
from weaveusd.export.lobe_texels import MOMENTS
from weaveusd.export.lobes import Matrix, geometric_mean, yarn_lobes
from weaveusd.export.textures import write_textures
from weaveusd.export.tiled import TiledWriter, level_sizes
from weaveusd.shading.fits import fit_standard
from weaveusd.shading.material import ClothMaterial
from weaveusd.shading.measured import measured, texels_of
from weaveusd.synth.model import Band
from weaveusd.synth.textures import synthesize


def written(material: ClothMaterial, folder: Path, jobs: int | None = None) -> Path:
    folder.mkdir(exist_ok=True)
    with lobe_maps(material, folder) as add:
        lobes = yarn_lobes(material.fits)
        write_textures(material.textures, folder, lobes, also=[add], jobs=jobs)
    return folder


def levels(folder: Path, name: str) -> list[np.ndarray]:
    """Return every level of a map, (h, w, components), the finest first."""
    source = oiio.ImageInput.open(str(folder / lobe_file(name)))
    found: list[np.ndarray] = []
    while source.seek_subimage(0, len(found)):
        spec = source.spec()
        pixels = source.read_image(0, len(found), 0, spec.nchannels, oiio.FLOAT)
        found.append(np.asarray(pixels).reshape(spec.height, spec.width, spec.nchannels))
    source.close()
    return found


def alphas(roughness: np.ndarray, rotation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return α across the fibre and along it, as OpenPBR has them of what the networks read."""
    stretch = np.linalg.norm(rotation, axis=-1)
    ratio = 1 - 2 * stretch / (1 + stretch)
    across = roughness[..., 0] ** 2 * np.sqrt(2 / (1 + ratio**2))
    return across, across * ratio


def of_texels(texel: Callable[[np.ndarray, np.ndarray], dict[str, np.ndarray]]) -> ClothMaterial:
    """Return the cloth of 32 × 48 texels that `texel` tells by row and column."""
    shape = (48, 32)
    whole = {n: np.empty((*shape, v.shape[-1]), np.float32) for n, v in BARE.items()}
    for name, value in (BARE | texel(*np.mgrid[0:48, 0:32])).items():
        whole[name][:] = value

    def band(first: int, last: int) -> Band:
        return {name: rows[first:last] for name, rows in whole.items()}

    return replace(cloth(), textures=replace(texture_set(), band=band))


BARE = {
    name: np.array(value, np.float32)
    for name, value in {
        "base_color": (0.5, 0.5, 0.5), "normal": (0, 0, 1), "tangent": (0, 1, 0), "height": (0,),
        "opacity": (1,), "yarn_id": (0,), "system": (0,), "fibre_angle": (-1, 0),
        "ambient_occlusion": (1,),
    }.items()
}  # fmt: skip
"""A texel of a flat warp."""


@pytest.fixture(scope="module")
def silk(tmp_path_factory) -> tuple[ClothMaterial, Path]:
    """A satin of charmeuse with its own fit, and the folder of its maps."""
    weave = woven(satin(), "charmeuse")
    textures = synthesize(weave, resolution=100)
    texels = texels_of(weave, textures)
    gains = measured(weave, texels)
    fits = fit_standard(weave, texels, gains)
    material = replace(cloth(), weave=weave, textures=textures, measured=gains, fits=fits)
    return material, written(material, tmp_path_factory.mktemp("silk") / "textures")


def test_the_coarsest_texel_is_the_fit_of_the_whole_tile(silk):
    material, folder = silk
    afar = material.fits.afar
    roughness, rotation, preview = (levels(folder, name)[-1] for name in LOBE_MAPS)
    across, along = alphas(roughness, rotation)
    assert across == pytest.approx(afar.openpbr.alpha_across, rel=0.01)
    assert along == pytest.approx(afar.openpbr.alpha_along, rel=0.01)
    assert np.sign(rotation[0, 0, 0]) == (1 if afar.fibres == "warp" else -1)
    assert rotation[0, 0, 1] == pytest.approx(0, abs=1e-3)
    assert preview[0, 0, 0] ** 2 == pytest.approx(afar.preview.alpha_along, rel=0.01)


def test_every_level_is_half_of_the_one_above_down_to_one_texel(silk):
    material, folder = silk
    expected = level_sizes(material.textures.width, material.textures.height)
    for name, lobe_map in LOBE_MAPS.items():
        found = levels(folder, name)
        assert [(a.shape[1], a.shape[0]) for a in found] == expected
        assert {a.shape[2] for a in found} == {lobe_map.components}
        assert all(np.isfinite(a).all() for a in found)
    for roughness in (*levels(folder, "roughness"), *levels(folder, "preview_roughness")):
        assert roughness.min() > 0
        assert roughness.max() <= 1


def test_no_level_has_a_sharper_lobe_than_the_sharpest_fit(silk):
    material, folder = silk
    fits = material.fits
    least = min(fit.alpha_along for fit in (*fits.yarns, fits.afar.openpbr))
    for roughness, rotation in zip(
        levels(folder, "roughness"), levels(folder, "rotation"), strict=True
    ):
        assert alphas(roughness, rotation)[1].min() > 0.97 * least


def test_the_finest_level_says_what_the_png_files_say(silk):
    _, folder = silk
    for name, low in (("roughness", 0.0), ("rotation", -1.0)):
        png = read_image(folder / f"{name}.png") / 255 * (1 - low) + low
        np.testing.assert_allclose(read_image(folder / lobe_file(name)), png, atol=0.0045)


def test_a_reader_without_levels_and_tiles_finds_each_yarn_s_lobe(tmp_path):
    folder = written(of_texels(lambda row, column: {}), tmp_path)
    assert read_image(folder / "roughness.exr").shape == (48, 32, 1)
    across, along = alphas(
        read_image(folder / "roughness.exr"), read_image(folder / "rotation.exr")
    )
    np.testing.assert_allclose(across, FIT.alpha_across, rtol=0.005)
    np.testing.assert_allclose(along, FIT.alpha_along, rtol=0.01)


def test_a_flat_cloth_of_one_yarn_has_the_same_lobe_at_every_level(tmp_path):
    folder = written(of_texels(lambda row, column: {}), tmp_path)
    for name in LOBE_MAPS:
        finest, *coarser = levels(folder, name)
        for level in coarser:
            expected = np.broadcast_to(finest[:1, :1], level.shape)
            np.testing.assert_allclose(level, expected, atol=2e-3)


def test_between_a_warp_and_a_weft_the_lobe_is_round_and_no_diagonal(tmp_path):
    """Averaged directions, (0, 1) and (1, 0), would be a sharp lobe along the diagonal."""

    def chess(row: np.ndarray, column: np.ndarray) -> dict[str, np.ndarray]:
        weft = ((row + column) % 2)[..., None]
        return {"tangent": np.where(weft, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))}

    folder = written(of_texels(chess), tmp_path)
    roughness, rotation = (levels(folder, name)[1] for name in ("roughness", "rotation"))
    across, along = alphas(roughness, rotation)
    mean = (FIT.alpha_across + FIT.alpha_along) / 2
    np.testing.assert_allclose(across, mean, rtol=0.01)
    np.testing.assert_allclose(along, mean, rtol=0.01)


@pytest.mark.parametrize(("fibre", "doubled"), [
    ((0.0, 1.0, 0.0), (1, 0)), ((1.0, 0.0, 0.0), (-1, 0)), ((0.6, 0.8, 0.0), (0.28, -0.96)),
    ((-0.6, -0.8, 0.0), (0.28, -0.96)),
])  # fmt: skip
def test_the_angle_is_that_across_the_fibre_and_has_no_sign(tmp_path, fibre, doubled):
    """Across (0.6, 0.8) lies (-0.8, 0.6); twice its angle has the cosine 0.64 − 0.36."""
    folder = written(of_texels(lambda row, column: {"tangent": np.array(fibre)}), tmp_path)
    for level in levels(folder, "rotation"):
        unit = level[..., :2] / np.linalg.norm(level[..., :2], axis=-1, keepdims=True)
        np.testing.assert_allclose(unit, np.broadcast_to(doubled, unit.shape), atol=0.004)


def test_hairs_and_gaps_weigh_by_their_opacity(tmp_path):
    """A column of gaps beside one of yarn changes nothing; one half covered counts by a half."""

    def striped(share: float) -> ClothMaterial:
        return of_texels(lambda row, column: {
            "opacity": np.where(column % 2, 1.0, share)[..., None],
            "yarn_id": np.zeros((48, 32, 1)),
        })  # fmt: skip

    gaps, hairs = (written(striped(s), tmp_path / f"{s}") for s in (0.0, 0.5))
    even = ROUND.alpha_along
    np.testing.assert_allclose(levels(gaps, "preview_roughness")[1] ** 2, even, rtol=0.01)
    mixed = (even + 0.5) / 1.5
    np.testing.assert_allclose(levels(hairs, "preview_roughness")[1] ** 2, mixed, rtol=0.01)


@pytest.mark.parametrize("texels_in_a_band", [1, 32 * 5, 10**9])
def test_the_same_texels_give_the_same_bytes_for_any_bands_and_jobs(
    tmp_path, monkeypatch, texels_in_a_band
):
    first = written(cloth(), tmp_path / "first", jobs=1)
    monkeypatch.setattr(writing, "BAND_TEXELS", texels_in_a_band)
    again = written(cloth(), tmp_path / "again", jobs=3)
    for file in map(lobe_file, LOBE_MAPS):
        assert (first / file).read_bytes() == (again / file).read_bytes()
    assert sorted(p.name for p in again.iterdir()) == sorted(p.name for p in first.iterdir())


@given(st.integers(1, 23), st.integers(1, 23), st.randoms(use_true_random=False))
def test_a_level_is_the_mean_of_what_its_texels_cover(width, height, random):
    values = np.array([random.random() for _ in range(width * height)], np.float32)
    rows = np.repeat(values.reshape(height, width, 1), len(MOMENTS), -1)
    (below,) = level_sizes(width, height)[1:2] or [(1, 1)]
    with tempfile.TemporaryFile() as file:
        level = _Level((width, height), below, file)
        for row in rows:
            level.add(row[None])
        (found,) = level.bands()
    fine = np.kron(rows[..., 0], np.ones((below[1], below[0])))
    expected = fine.reshape(below[1], height, below[0], width).mean((1, 3))
    np.testing.assert_allclose(found[..., 0], expected, rtol=1e-5, atol=1e-30)


positive = st.floats(0.02, 1.0)


@given(positive, positive, st.floats(-0.95, 0.95), positive, positive, st.floats(-0.95, 0.95))
def test_the_geometric_mean_turns_one_lobe_into_the_other(a, b, c, d, e, f):
    start, end = Matrix(a, c * np.sqrt(a * b), b), Matrix(d, f * np.sqrt(d * e), e)
    g, first, last = (
        np.array([[m.xx, m.xy], [m.xy, m.yy]]) for m in (geometric_mean(start, end), start, end)
    )
    np.testing.assert_allclose(g @ np.linalg.inv(first) @ g, last, rtol=1e-6, atol=1e-9)


def test_a_writer_refuses_rows_that_are_not_of_its_level(tmp_path):
    def write(shape: tuple[int, int, int]) -> None:
        with TiledWriter(tmp_path / "x.exr", 8, 4, 1, {}) as out:
            out.write(np.zeros(shape, np.float16))

    with pytest.raises(ValueError, match="unexpected rows"):
        write((4, 7, 1))
    with pytest.raises(ValueError, match="levels written"):
        write((4, 8, 1))


def test_an_asset_that_fails_leaves_no_scratch_behind(tmp_path):
    material = cloth()

    def broken(first: int, last: int) -> Band:
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space left"):
        write_asset(replace(material, textures=replace(material.textures, band=broken)), tmp_path)
    names = {path.name for path in (tmp_path / "textures").iterdir()}
    assert all(name.endswith((".exr", ".png")) for name in names)
