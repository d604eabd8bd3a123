"""One reading of the textures serves every check."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.validate.assets import publish
from tests.validate.faults import FAULTS, rewrite
from weaveusd.validate import textures as module
from weaveusd.validate.model import Status
from weaveusd.validate.open_asset import TEXTURE_FILES
from weaveusd.validate.run import validate
from weaveusd.validate.sweep import sweep
from weaveusd.validate.textures import Band, Reader, TextureFolder

SMALL = 64 * 16  # texels of a band, four bands in all


@pytest.fixture(scope="module")
def entry(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return publish(tmp_path_factory.mktemp("asset") / "v001")


@pytest.fixture
def folder(entry: Path, tmp_path: Path) -> Path:
    shutil.copytree(entry.parent, tmp_path / "v001")
    return tmp_path / "v001" / "textures"


@pytest.fixture(autouse=True)
def _small_bands(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "BAND_TEXELS", SMALL)


@pytest.mark.parametrize("jobs", [1, 2, 5])
def test_every_look_sees_every_row_once_from_the_top_down(folder: Path, jobs: int) -> None:
    seen: dict[str, list[int]] = {"a": [], "b": []}
    shares: list[float] = []

    def look(name: str):
        return lambda band: seen[name].extend(
            range(band.first, band.first + len(band.pixels["height.exr"]))
        )

    found = sweep(
        TextureFolder(folder),
        tuple(TEXTURE_FILES),
        {name: look(name) for name in seen},
        jobs=jobs,
        progress=shares.append,
    )
    assert seen == {"a": [*range(64)], "b": [*range(64)]}
    assert not found.faults
    assert not found.broken
    assert shares == [0.25, 0.5, 0.75, 1.0]


def test_each_row_of_each_file_is_decoded_once_for_all_checks(
    entry: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[tuple[Reader, int]] = []
    decode = Reader.read

    def counted(self: Reader, first: int, last: int):
        read.extend((self, row) for row in range(first, last))
        return decode(self, first, last)

    monkeypatch.setattr(Reader, "read", counted)
    assert validate(entry).passed
    assert len(read) == len(set(read))
    # The ids and the opacity are read beforehand, to find the borders of yarns.
    moment_maps = 2 * 4 * 16
    assert len(read) == 64 * (len(TEXTURE_FILES) + 2) + moment_maps


def test_a_look_that_raises_gets_no_more_and_disturbs_no_other(folder: Path) -> None:
    calls = {"bad": 0, "good": 0}

    def bad(band: Band) -> None:
        calls["bad"] += 1
        raise RuntimeError("dropped a stitch")

    def good(band: Band) -> None:
        calls["good"] += 1

    found = sweep(TextureFolder(folder), tuple(TEXTURE_FILES), {"bad": bad, "good": good}, jobs=2)
    assert calls == {"bad": 1, "good": 4}
    assert str(found.broken["bad"]) == "dropped a stitch"


def test_a_check_that_breaks_down_over_texels_is_an_error(
    entry: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from weaveusd.validate.checks.cover import Cover

    def look(self: Cover, band: Band) -> None:
        raise RuntimeError("dropped a stitch")

    monkeypatch.setattr(Cover, "look", look)
    report = validate(entry, checks=["agreement"])
    status = {finding.check: finding.status for finding in report.findings}
    assert status.pop("agreement/cover") is Status.ERROR
    assert set(status.values()) == {Status.PASS}


def test_a_file_that_ends_early_is_named_and_the_others_are_read_to_their_end(
    folder: Path,
) -> None:
    for name in ("height.exr", "tangent.exr"):
        data = (folder / name).read_bytes()
        (folder / name).write_bytes(data[: len(data) * 2 // 3])
    report = validate(folder.parent / "shot_twill.usda", checks=["texture/files"])
    assert {finding.code for finding in report.findings} == {"texture-unreadable"}
    where = [finding.where for finding in report.findings]
    assert where == ["textures/tangent.exr", "textures/height.exr"]


def test_textures_of_several_sizes_are_decoded_but_shown_to_no_check(folder: Path) -> None:
    rewrite(folder / "height.exr", lambda pixels: pixels[:-3])
    shown: list[Band] = []
    found = sweep(TextureFolder(folder), tuple(TEXTURE_FILES), {"a": shown.append}, jobs=2)
    assert not found.faults
    assert not shown


@pytest.mark.parametrize("jobs", [1, 3])
def test_bands_and_jobs_change_no_word_of_a_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, jobs: int
) -> None:
    names = ("gamma_encoded_normals", "fibres_turned_in_the_surface", "six_rows_cut_off")
    for fault in (fault for fault in FAULTS if fault.name in names):
        entry = fault.plant(tmp_path / fault.name)
        in_bands = validate(entry, jobs=jobs)
        with monkeypatch.context() as patch:
            patch.setattr(module, "BAND_TEXELS", 1 << 19)
            at_once = validate(entry, jobs=2)
        assert in_bands == at_once


def test_a_fault_between_two_bands_is_seen(folder: Path) -> None:
    """Rows 14 to 17 lie on both sides of a border between bands."""

    def change(pixels):
        pixels[14:18] = np.nan

    rewrite(folder / "height.exr", change)
    report = validate(folder.parent / "shot_twill.usda", checks=["texture/finite"])
    (finding,) = report.findings
    assert finding.message.startswith("256 texels are not finite; the first at column 0, row 14")
