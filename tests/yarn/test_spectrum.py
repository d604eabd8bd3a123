"""Spectra are read strictly, from beside the recipe and from nowhere else."""

from __future__ import annotations

import os

import pytest

from weaveusd.errors import RecipeError
from weaveusd.yarn.spectrum import MAX_BYTES, read_reflectance

ROWS = [f"{nm},0.4" for nm in range(380, 731, 10)]


@pytest.fixture
def read(tmp_path):
    def read(text: str | bytes, name: str = "a.csv"):
        data = text if isinstance(text, bytes) else text.encode()
        (tmp_path / "a.csv").write_bytes(data)
        return read_reflectance(tmp_path, name, "recipe.toml:9: color.reflectance")

    return read


def test_rows_are_wavelengths_and_reflectances(read):
    nm, reflectance = read("\n".join(ROWS))
    assert (nm[0], nm[-1], len(nm)) == (380, 730, 36)
    assert set(reflectance) == {0.4}


def test_headings_remarks_and_other_separators_are_passed_over(read):
    plain = read("\n".join(ROWS))
    assert read("﻿# spectro\r\nnm;R\r\n\r\n" + "\r\n".join(ROWS).replace(",", ";")) == plain
    assert read("nm\tR\n" + "\n".join(ROWS).replace(",", "\t") + "\n\n# end\n") == plain


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"a\.csv: found no rows, expected at least 380 to 730 nm"),
        ("\n".join(ROWS[1:]), r"a\.csv: found 390 to 730 nm"),
        ("\n".join(ROWS[:-1]), r"a\.csv: found 380 to 720 nm"),
        ("\n".join([*ROWS, "end"]), r"a\.csv:37: found 'end', expected a wavelength"),
        ("a,b\nc,d\n" + "\n".join(ROWS), r"a\.csv:2: found 'c,d'"),
        ("\n".join([*ROWS[:3], "410,0.4,0.5"]), r"a\.csv:4: found '410,0\.4,0\.5'"),
        ("\n".join([*ROWS[:3], "410,45.2"]), r"a\.csv:4: found a reflectance of 45\.2, expected 0"),
        ("\n".join([*ROWS[:3], "410,-0.1"]), r"a\.csv:4: found a reflectance of -0\.1"),
        ("\n".join([*ROWS[:3], "410,nan"]), r"a\.csv:4: found a reflectance of nan"),
        ("\n".join([*ROWS[:3], "400,0.4"]), r"a\.csv:4: found a step of 0 nm"),
        ("\n".join([*ROWS[:3], "390,0.4"]), r"a\.csv:4: found a step of -10 nm"),
        ("\n".join([*ROWS[:3], "405,0.4"]), r"a\.csv:4: found a step of 5 nm, expected 10 nm"),
        ("380,0.4\n410,0.4", r"a\.csv:2: found a step of 30 nm, expected one above 0 and at most"),
        ("0.38,0.4", r"a\.csv:1: found 0\.38 nm, expected 300 to 1100 nm"),
        ("inf,0.4", r"a\.csv:1: found inf nm"),
        (b"380,0.4\n\xff", "not UTF-8 at byte 8"),
        ("#" * (MAX_BYTES + 1), f"larger than {MAX_BYTES} bytes"),
    ],
)  # fmt: skip
def test_a_fault_is_named_with_its_line(read, text, message):
    with pytest.raises(RecipeError, match=message) as caught:
        read(text)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "name",
    ["../a.csv", "b/../../a.csv", "/etc/passwd", "C:\\a.csv", "..\\a.csv", "file:a.csv", "", "."],
)
def test_a_name_that_leads_elsewhere_is_refused(read, name):
    with pytest.raises(RecipeError, match=r"^recipe\.toml:9: color\.reflectance: "):
        read("\n".join(ROWS), name)


def test_a_link_that_leads_out_of_the_folder_is_refused(tmp_path):
    folder = tmp_path / "recipes"
    folder.mkdir()
    (tmp_path / "secret.csv").write_text("\n".join(ROWS))
    (folder / "a.csv").symlink_to(tmp_path / "secret.csv")
    with pytest.raises(RecipeError, match="beside the recipe or below"):
        read_reflectance(folder, "a.csv", "here")


def test_a_pipe_is_no_file(tmp_path):
    os.mkfifo(tmp_path / "a.csv")
    with pytest.raises(RecipeError, match="no such file"):
        read_reflectance(tmp_path, "a.csv", "here")


def test_a_name_that_no_file_system_takes_is_no_file(tmp_path):
    with pytest.raises(RecipeError, match="here: "):
        read_reflectance(tmp_path, "x" * 1000, "here")


def test_a_spectrum_may_lie_in_a_folder_below(tmp_path):
    (tmp_path / "lab").mkdir()
    (tmp_path / "lab" / "a.csv").write_text("\n".join(ROWS))
    assert read_reflectance(tmp_path, "lab/a.csv", "here")[0][0] == 380
