"""The commands inspect and draft, run as the command line runs them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from tests.draft.wif_text import TWILL_ROWS, rows, wif
from weaveusd.cli_draft import register
from weaveusd.draft.make import make_draft
from weaveusd.draft.model import drawdown_sha256
from weaveusd.draft.transform import repeat, rotate
from weaveusd.draft.wif import read_wif
from weaveusd.errors import DraftError, InputError, WeaveusdError
from weaveusd.export.images import read_image, write_png8

app = typer.Typer()
register(app)


def run(*arguments: str | Path, status: int = 0) -> tuple[str, str]:
    """Run the command line and return what it wrote; errors of ours pass through."""
    result = CliRunner().invoke(app, [str(a) for a in arguments])
    if isinstance(result.exception, WeaveusdError):
        raise result.exception
    assert result.exit_code == status, result.output
    return result.stdout, result.stderr


@pytest.fixture
def twill(tmp_path: Path) -> Path:
    path = tmp_path / "twill.wif"
    path.write_text(wif({"WIF": "Version=1.2"}))
    return path


def test_inspect_prints_one_json_object(twill: Path) -> None:
    out, err = run("inspect", twill, "--json")
    record = json.loads(out)
    assert (record["ends"], record["picks"], record["shafts"]) == (4, 4, 4)
    assert record["drawdown_sha256"] == drawdown_sha256(read_wif(twill))
    assert record["longest_float"] == 2
    assert record["colors"] == ["#000000", "#ffffff"]
    assert record["structure"] == "twill 2/2 Z 45°"
    assert record["warnings"] == ["line 2: [WIF] Version is '1.2'; read as 1.1"]
    assert err == ""


def test_inspect_tells_people_the_same_and_warns_on_stderr(twill: Path) -> None:
    out, err = run("inspect", twill)
    assert "4 ends × 4 picks on 4 shafts" in out
    assert "twill 2/2 Z 45°" in out
    assert err == "warning: line 2: [WIF] Version is '1.2'; read as 1.1\n"


def test_inspect_draws_the_draft(twill: Path, tmp_path: Path) -> None:
    run("inspect", twill, "--image", tmp_path / "twill.png")
    assert read_image(tmp_path / "twill.png").shape == (11 * 12, 11 * 12, 3)


def test_inspect_names_a_broken_draft(tmp_path: Path) -> None:
    path = tmp_path / "broken.wif"
    path.write_text(wif({"TIEUP": None}))
    with pytest.raises(DraftError, match=r"broken\.wif: \[TIEUP\] is missing"):
        run("inspect", path)


def test_draft_writes_a_notation(tmp_path: Path) -> None:
    out, _ = run("draft", "satin:5:2", "-o", tmp_path / "s.wif")
    assert read_wif(tmp_path / "s.wif") == make_draft("satin:5:2")
    assert out.endswith("5 ends, 5 picks, 5 shafts\n")


def test_draft_writes_three_lists(tmp_path: Path) -> None:
    lists = ("--threading", "1-4", "--tieup", "1+2 2+3 3+4 4+1", "--treadling", "1-4")
    run("draft", *lists, "-o", tmp_path / "t.wif")
    assert rows(read_wif(tmp_path / "t.wif")) == TWILL_ROWS


def test_draft_weaves_an_image_in_the_colors_of_another(tmp_path: Path) -> None:
    drawdown = np.array([[255, 0], [0, 255]], np.uint8)[:, :, None]
    write_png8(tmp_path / "d.png", drawdown)
    colors = np.where(drawdown == 0, [255, 0, 0], [0, 0, 255]).astype(np.uint8)
    write_png8(tmp_path / "c.png", colors)
    run(
        "draft", "--image", tmp_path / "d.png", "--color-image", tmp_path / "c.png",
        "-o", tmp_path / "t.wif",
    )  # fmt: skip
    draft = read_wif(tmp_path / "t.wif")
    assert rows(draft) == ["#.", ".#"]
    assert draft.palette[draft.warp_color[0]].tolist() == [1.0, 0.0, 0.0]
    assert draft.palette[draft.weft_color[0]].tolist() == [0.0, 0.0, 1.0]
    assert draft.title == "d"
    assert json.loads(run("inspect", tmp_path / "d.png", "--json")[0])["structure"] == "plain"


def test_a_bitmap_of_bmp_is_read(tmp_path: Path) -> None:
    import struct

    # A BMP of 1 bit a pixel, 2 × 2, rows from the bottom up: #. then .#
    pixels = bytes([0b01 << 6, 0, 0, 0, 0b10 << 6, 0, 0, 0])
    palette = bytes([0, 0, 0, 0, 255, 255, 255, 0])
    info = struct.pack("<IiiHHIIiiII", 40, 2, 2, 1, 1, 0, len(pixels), 2835, 2835, 2, 2)
    start = 14 + len(info) + len(palette)
    head = struct.pack("<2sIHHI", b"BM", start + len(pixels), 0, 0, start)
    (tmp_path / "d.bmp").write_bytes(head + info + palette + pixels)
    run("draft", "--image", tmp_path / "d.bmp", "-o", tmp_path / "t.wif")
    assert rows(read_wif(tmp_path / "t.wif")) == ["#.", ".#"]


def test_draft_turns_and_repeats_another(twill: Path, tmp_path: Path) -> None:
    run("draft", "--from", twill, "--rotate", "--repeat", "3x2", "-o", tmp_path / "r.wif")
    assert read_wif(tmp_path / "r.wif") == repeat(rotate(read_wif(twill)), 3, 2)
    run("draft", "--from", twill, "--mirror", "--invert", "-o", tmp_path / "m.wif")
    flipped = ~read_wif(twill).drawdown()[:, ::-1]
    np.testing.assert_array_equal(read_wif(tmp_path / "m.wif").drawdown(), flipped)


@pytest.mark.parametrize(
    "arguments",
    [
        [], ["plain", "--from", "x.wif"], ["--threading", "1"], ["plain", "--repeat", "0x2"],
        ["plain", "--repeat", "2"], ["--color-image", "c.png"],
    ],
)  # fmt: skip
def test_a_contradiction_in_the_arguments_is_a_usage_error(
    arguments: list[str], tmp_path: Path
) -> None:
    run("draft", *arguments, "-o", tmp_path / "x.wif", status=2)
    assert not (tmp_path / "x.wif").exists()


@pytest.mark.parametrize("arguments", [["velvet"], ["--image", "none.png"], ["--from", "none.wif"]])
def test_a_failure_leaves_the_output_as_it_was(arguments: list[str], tmp_path: Path) -> None:
    output = tmp_path / "x.wif"
    output.write_text("before")
    with pytest.raises(InputError):
        run("draft", *arguments, "-o", output)
    assert output.read_text() == "before"


def test_an_output_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    with pytest.raises(WeaveusdError, match=r"x\.wif: cannot be written: No such file"):
        run("draft", "plain", "-o", tmp_path / "none" / "x.wif")
