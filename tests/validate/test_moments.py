"""Moment maps under judgement: as the makers make them, of older assets, and hostile ones."""

from __future__ import annotations

import re
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.validate.assets import PROVENANCE, TWILL, cloth, drawn, publish
from tests.validate.faults import LOOK, in_levels, rewrite
from tests.weaves import satin, twill, woven
from weaveusd.cloth.model import Weave
from weaveusd.contract import MAX_MOMENT_TEXELS, SYSTEMS
from weaveusd.export.asset import write_asset
from weaveusd.export.doors import write_doors
from weaveusd.export.images import ImageWriter
from weaveusd.export.moments import pictures
from weaveusd.pipeline import validate as validate_and_report
from weaveusd.shading.shade import shade
from weaveusd.synth.moments import moment_maps, sections
from weaveusd.synth.textures import synthesize
from weaveusd.validate.checks.moment_agreement import TOLERANCE
from weaveusd.validate.model import Status
from weaveusd.validate.moments import OTHER_SYSTEM, Remainder
from weaveusd.validate.open_asset import OpenAsset
from weaveusd.validate.report import moments as report
from weaveusd.validate.run import validate
from weaveusd.validate.textures import Band

CHECKS = ("shader/moments", "texture/moments", "agreement/moments")


def codes(entry: Path, *checks: str) -> set[str]:
    findings = validate(entry, checks=checks or CHECKS).findings
    return {finding.code for finding in findings if finding.status > Status.PASS}


def published(folder: Path, weave: Weave, resolution: int = 96) -> Path:
    source = replace(PROVENANCE, draft_wif=drawn(weave.warp_up))
    return publish(folder, shade("cloth", weave, synthesize(weave, resolution=resolution), source))


def of_kinds(*gammas: float) -> Weave:
    """A twill whose ends in turn have lobes so wide."""
    cloth = woven(twill(), "shot_silk")
    warp, weft = cloth.yarns
    ends = tuple(
        replace(warp, name=f"end_{k}", optics=replace(warp.optics, gamma_s=gamma))
        for k, gamma in enumerate(gammas)
    )
    turn = np.arange(cloth.ends, dtype=np.int32) % len(gammas)
    picks = np.full(cloth.picks, len(gammas), np.int32)
    return replace(cloth, yarns=(*ends, weft), warp_yarn=turn, weft_yarn=picks)


def without_maps(folder: Path) -> Path:
    """Make the asset in `folder` one of a version that knew no moment maps."""
    (entry,) = folder.glob("shot_twill.usda")
    text = (folder / LOOK).read_text()
    text = re.sub(r".*(warp|weft)_(slopes|along|across|albedo|kinds|section).*\n", "", text)
    text = re.sub(r".*weave:moment(Maps|Width|Height).*\n", "", text)
    (folder / LOOK).write_text(text)
    for path in (folder / "textures").glob("w*_*.exr"):
        path.unlink()
    return entry


@pytest.mark.parametrize("size", [(12, 8), (7, 5), (20, 60)], ids=str)
@pytest.mark.parametrize("preset", ["linen", "charmeuse"])
def test_what_is_left_of_the_makers_maps_is_rounding(preset: str, size: tuple[int, int]) -> None:
    weave = woven(satin(), preset)
    textures = synthesize(weave, resolution=60, seed=3)
    texels = textures.band(0, textures.height)
    maps = moment_maps(weave, textures, width=size[0], height=size[1])
    for weft, (of_system, section) in enumerate(zip(maps, sections(weave), strict=True)):
        members = np.full(256, OTHER_SYSTEM, np.int64)
        of_yarns = [0 if yarn.system == SYSTEMS[weft] else OTHER_SYSTEM for yarn in weave.yarns]
        members[1 : 1 + len(of_yarns)] = of_yarns
        values = pictures(of_system) | {"kinds": np.zeros((*size[::-1], 4))}
        values["kinds"][..., 0] = values["albedo"][..., 3]
        remainder = Remainder(
            np.concatenate([*values.values()], axis=-1)[::-1],
            is_weft=bool(weft),
            section=(section.flatness, section.curvature),
            members=members,
            gains=np.ones(256),
        )
        for first in range(0, textures.height, 16):
            remainder.take_off(stored(texels, first, first + 16), textures.height)
        assert (np.abs(remainder.left) - remainder.loose[..., None]).max() < TOLERANCE / 2
        assert remainder.loose.mean() < 0.02


def stored(texels: dict[str, np.ndarray], first: int, last: int) -> Band:
    """Rows `first` to `last` - 1 from the top, as files hold them."""
    rows = {name: values[::-1][first:last] for name, values in texels.items()}
    pixels = {f"{n}.exr": rows[n].astype(np.float16) for n in ("base_color", "normal", "tangent")}
    pixels["opacity.png"] = np.rint(rows["opacity"] * 255).astype(np.uint8)
    pixels["yarn_id.png"] = (rows["yarn_id"] + 1).astype(np.uint8)
    return Band(first, pixels)


def test_an_asset_of_an_older_version_passes_and_the_report_says_what_it_lacks(
    tmp_path: Path,
) -> None:
    publish(tmp_path / "v001")
    entry = without_maps(tmp_path / "v001")
    found = validate(entry, checks=["shader", "texture", "agreement", "attribute"])
    assert found.passed
    skipped = {f.code for f in found.findings if f.status is Status.SKIP}
    assert skipped == {"moments-none", "texture/moments/skip", "agreement/moments/skip"}
    assert max(f.status for f in found.findings) is Status.SKIP


@pytest.mark.parametrize("gammas", [(0.1, 0.3), (0.1, 0.2, 0.3, 0.4, 0.5)], ids=["two", "five"])
def test_yarns_that_scatter_in_several_ways_are_told_apart(
    gammas: Sequence[float], tmp_path: Path
) -> None:
    weave = of_kinds(*gammas)
    weave = replace(weave, warp_yarn=np.arange(weave.ends, dtype=np.int32) % len(gammas))
    entry = published(tmp_path / "v001", weave)
    assert codes(entry) == set()

    def exchange(pixels: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray(pixels[..., [1, 0, 2, 3]])

    rewrite(tmp_path / "v001" / "textures" / "warp_kinds.exr", exchange)
    assert codes(entry) == {"moments-disagree"}


@pytest.mark.parametrize(
    ("kinds", "wrong"),
    [
        ("[1]", {"kinds-wrong", "moments-file"}),
        ("[1, 1]", {"kinds-wrong"}),
        ("[2, 1]", {"moments-disagree"}),
        ("[1, 2, 3]", {"kinds-wrong"}),
        ("[1, -9]", {"kinds-wrong"}),
        ("[1, 2, 1, 2, 1, 2]", {"kinds-wrong"}),
        ("[]", {"kinds-wrong", "moments-file"}),
    ],
)
def test_kinds_that_do_not_cover_a_system_are_found(
    kinds: str, wrong: set[str], tmp_path: Path
) -> None:
    entry = published(tmp_path / "v001", of_kinds(0.1, 0.3), 48)
    look = tmp_path / "v001" / LOOK
    text = look.read_text()
    assert "int[] inputs:warp_kinds = [1, 2]" in text
    look.write_text(text.replace("inputs:warp_kinds = [1, 2]", f"inputs:warp_kinds = {kinds}"))
    assert codes(entry) == wrong


def test_maps_of_other_irregularities_are_those_of_another_cloth(tmp_path: Path) -> None:
    weave = woven(twill(), "linen")
    entry = published(tmp_path / "v001", weave)
    source = replace(PROVENANCE, draft_wif=drawn(weave.warp_up))
    other = shade("cloth", weave, synthesize(weave, resolution=96, seed=8), source)
    publish(tmp_path / "other", other)
    for path in (tmp_path / "other" / "textures").glob("w*_*.exr"):
        shutil.copy(path, tmp_path / "v001" / "textures" / path.name)
    assert codes(entry) == {"moments-disagree"}


def test_a_map_of_more_texels_than_any_is_refused_by_its_header(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entry = publish(tmp_path / "v001")
    path = tmp_path / "v001" / "textures" / "warp_along.exr"
    side = int(MAX_MOMENT_TEXELS**0.5) + 1
    with ImageWriter(path, side, side, 4, "float16", {}) as out:
        out.write(np.zeros((side, side, 4), np.float16))
    (finding,) = validate(entry, checks=["texture/moments"]).findings
    assert finding.code == "moments-unreadable"
    assert finding.message == f"{side} x {side} texels, expected at most {MAX_MOMENT_TEXELS}"
    assert "warp_along.exr" not in OpenAsset(entry).kept


@pytest.mark.parametrize("file", ["warp_slopes", "weft_along", "warp_across", "weft_albedo"])
def test_an_infinite_mean_is_found_and_disturbs_no_check(file: str, tmp_path: Path) -> None:
    entry = publish(tmp_path / "v001")

    def change(pixels: np.ndarray) -> None:
        pixels[2, 3] = np.inf, -np.inf, np.inf, np.inf

    rewrite(tmp_path / "v001" / "textures" / f"{file}.exr", change)
    assert codes(entry) == {"moments-range", "moments-disagree"}


def test_infinite_lobes_are_found_and_disturb_no_check(tmp_path: Path) -> None:
    entry = publish(tmp_path / "v001")
    for name in ("roughness", "rotation", "preview_roughness"):
        path = tmp_path / "v001" / "textures" / f"{name}.exr"
        in_levels(path, lambda level, p: p if level < 3 else np.full_like(p, np.inf))
    assert codes(entry, "texture/lobes") == {"lobes-range"}


def test_warp_and_weft_together_cover_no_more_than_all(tmp_path: Path) -> None:
    entry = publish(tmp_path / "v001")
    for path in (tmp_path / "v001" / "textures").glob("warp_*.exr"):
        shutil.copy(path, path.with_name(path.name.replace("warp", "weft")))
    found = validate(entry, checks=["texture/moments"]).findings
    assert [finding.code for finding in found] == ["moments-range"]
    assert "with the warp above 1" in found[0].message


def test_maps_of_warp_and_weft_are_of_one_size(tmp_path: Path) -> None:
    entry = publish(tmp_path / "v001")
    look = tmp_path / "v001" / LOOK
    look.write_text(re.sub(r".*weave:moment(Width|Height).*\n", "", look.read_text()))
    for path in (tmp_path / "v001" / "textures").glob("weft_*.exr"):
        rewrite(path, lambda pixels: np.ascontiguousarray(pixels[::2, ::2]))
    assert codes(entry, "texture/moments") == {"moments-format"}


def test_a_colorway_is_judged_by_its_own_maps(tmp_path: Path) -> None:
    one = cloth()
    warp, weft = one.weave.yarns
    blue = replace(one.weave, yarns=(replace(warp, color=(0.1, 0.2, 0.5)), weft))

    def recolored(first: int, last: int):
        band = one.textures.band(first, last)
        is_warp = band["yarn_id"] == 0
        color = np.where(is_warp, np.float32(blue.yarns[0].color), band["base_color"])
        return {**band, "base_color": color.astype(np.float32)}

    two = replace(one, weave=blue, textures=replace(one.textures, band=recolored))
    folder = tmp_path / "v001"
    folder.mkdir()
    entry = write_asset(one, folder, colorways={"ecru": one, "blue": two})
    assert codes(entry) == set()
    path = folder / "textures" / "blue" / "warp_albedo.exr"
    rewrite(path, lambda pixels: pixels * np.array([0.5, 0.5, 0.5, 1], np.float16))
    (finding,) = (f for f in validate(entry, checks=CHECKS).findings if f.status > Status.PASS)
    assert finding.code == "moments-disagree"
    assert finding.message.startswith("in the colorway blue: ")
    assert finding.where == "textures/blue/warp_albedo.exr"


def test_a_tx_of_a_map_holds_means_on_every_level(tmp_path: Path) -> None:
    entry = publish(tmp_path / "v001")
    write_doors(cloth(), tmp_path / "v001", ("tx",))
    assert codes(entry, "texture/mip-chains") == set()
    path = tmp_path / "v001" / "textures" / "warp_albedo.tx"
    assert path.is_file()
    in_levels(path, lambda level, pixels: pixels * np.float16(1 + (level > 0)))
    assert codes(entry, "texture/mip-chains") == {"mip-range"}


def test_the_report_shows_every_map(tmp_path: Path) -> None:
    publish(tmp_path / "v001", cloth(TWILL))
    shown = report.moment_pictures(OpenAsset(tmp_path / "v001" / "shot_twill.usda"))
    assert len(shown) == 8
    assert {exhibit.group for exhibit in shown} == {report.GROUP}
    assert re.fullmatch(
        r"warp_slopes\.exr, 16 × 16: a flat to [\d.e-]+, a rising to 1, a falling to 1, "
        r"a X to 0\.\d+",
        shown[0].text,
    )
    assert max(len(exhibit.source) for exhibit in shown) < 64_000


def test_the_page_of_an_asset_without_maps_has_no_pictures_of_them(tmp_path: Path) -> None:
    publish(tmp_path / "v001")
    validate_and_report(without_maps(tmp_path / "v001"), report=tmp_path / "report")
    page = (tmp_path / "report" / "report.html").read_text(encoding="utf-8")
    assert "<h2>Moment maps</h2>" not in page
    assert "moments-none" in page
