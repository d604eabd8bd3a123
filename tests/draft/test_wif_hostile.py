"""Files made to hurt: every limit holds before memory is taken, every number is a number."""

from __future__ import annotations

import time
import tracemalloc
from pathlib import Path

import pytest

from tests.draft.wif_text import read, rows, wif
from weaveusd.draft.scan import MAX_BYTES, MAX_LINE, MAX_LINES, MAX_SECTIONS, MAX_WARNINGS
from weaveusd.draft.wif import read_wif
from weaveusd.errors import DraftError


@pytest.mark.parametrize("threads", [2147483647, 10**15, 2**26 + 1])
def test_a_tiny_file_that_claims_many_threads_is_refused_at_once(threads: int) -> None:
    data = wif({"WARP": f"Threads={threads}\nColor=1"}).encode()
    read(wif())
    tracemalloc.start()
    start = time.perf_counter()
    with pytest.raises(DraftError, match=r"found .* threads"):
        read(data)
    seconds = time.perf_counter() - start
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert seconds < 0.05
    assert peak < 50 * 2**20


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"WARP": "Threads=65536\nColor=1", "WEFT": "Threads=65536\nColor=2"}, "ends by picks"),
        ({"WEAVING": "Shafts=2147483647"}, "found 2147483647 shafts"),
        ({"TIEUP": "1=999999999"}, "found 999999999 shafts"),
        ({"WEFT": "Threads=1000000\nColor=2", "WEAVING": "Shafts=1000"}, "picks by shafts"),
    ],
)
def test_the_size_is_judged_before_memory_is_taken(changes: dict[str, str], what: str) -> None:
    tracemalloc.start()
    with pytest.raises(DraftError, match=what):
        read(wif(changes))
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 50 * 2**20


def test_a_treadle_or_row_of_any_number_costs_nothing() -> None:
    draft = read(
        wif({"TIEUP": "1=1,2\n2=2,3\n3=3,4\n4=1,4\n999999999=1", "WARP COLORS": "9999999=1"})
    )
    assert draft.picks == 4


@pytest.mark.parametrize(
    "number",
    ["nan", "inf", "-inf", "1e309", "1_000", "١٢", "²", "0x10", "-1", "1e", "", "9" * 5000, "½"],
)
@pytest.mark.parametrize("place", ["Threads", "Spacing", "row", "color", "range"])
def test_only_plain_numbers_are_numbers(number: str, place: str) -> None:
    changes = {
        "Threads": {"WARP": f"Threads={number}\nColor=1"},
        "Spacing": {"WARP": f"Threads=4\nColor=1\nUnits=cm\nSpacing={number}"},
        "row": {"THREADING": f"1={number}"},
        "color": {"COLOR TABLE": f"1={number},0,0\n2=0,0,0"},
        "range": {"COLOR PALETTE": f"Range=0,{number}"},
    }[place]
    if number == "" and place in ("Threads", "Spacing", "row", "range"):
        assert read(wif(changes)).picks == 4
        return
    with pytest.raises(DraftError) as caught:
        read(wif(changes))
    assert len(str(caught.value)) < 300
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("key", ["١", "1_0", "-3", "1.5", "9" * 5000])
def test_a_row_number_is_a_plain_number_too(key: str) -> None:
    with pytest.raises(DraftError, match="numbered"):
        read(wif({"THREADING": f"{key}=1"}))


def test_a_word_for_a_row_number_is_ignored() -> None:
    assert any("is no row number" in str(w) for w in read(wif({"WARP COLORS": "all=1"})).warnings)


def test_a_file_beyond_8_mib_is_refused_without_reading_it_all(tmp_path: Path) -> None:
    path = tmp_path / "large.wif"
    with path.open("wb") as file:
        file.truncate(2**33)
    with pytest.raises(DraftError, match=f"more than {MAX_BYTES} bytes"):
        read_wif(path)


def test_a_device_without_end_is_refused() -> None:
    with pytest.raises(DraftError, match="more than"):
        read_wif("/dev/zero")


def test_a_long_line_is_refused_with_its_number() -> None:
    with pytest.raises(DraftError, match=r"test\.wif:2: found a line of more than 65536"):
        read(f"[WIF]\nSource Program={'x' * MAX_LINE}\n")


def test_a_line_of_just_64_kib_is_read() -> None:
    assert read(wif({"TEXT": "Title=" + "x" * (MAX_LINE - 6)})).title.startswith("xxx")


def test_too_many_sections_and_lines_are_refused() -> None:
    assert rows(read(wif() + "[X]\n" * (MAX_SECTIONS - 9)))
    with pytest.raises(DraftError, match="more than 512 sections"):
        read(wif() + "[X]\n" * (MAX_SECTIONS - 8))
    with pytest.raises(DraftError, match=f"more than {MAX_LINES} lines"):
        read("\n" * MAX_LINES)


def test_warnings_are_counted_when_they_become_too_many() -> None:
    text = wif({"THREADING": "1=1\n" + "".join(f"w{n}=1\n" for n in range(1000))})
    warnings = read(text).warnings
    assert len(warnings) == MAX_WARNINGS + 1
    assert str(warnings[-1]).endswith("more warnings")


def test_a_name_with_line_breaks_stays_on_one_line_of_the_message() -> None:
    from weaveusd.draft.wif import parse_wif

    with pytest.raises(DraftError) as caught:
        parse_wif(b"", "evil\nname\x1b[31m.wif")
    assert str(caught.value).startswith("evil name [31m.wif: ")


def test_a_megabyte_is_read_in_a_moment() -> None:
    threads = 50_000
    listed = "".join(f"{n}={n % 24 + 1}\n" for n in range(1, threads + 1))
    colors = "".join(f"{n}={n % 2 + 1}\n" for n in range(1, threads + 1))
    text = wif(
        {
            "WARP": f"Threads={threads}\nColor=1",
            "WEAVING": "Shafts=24\nTreadles=4\nRising Shed=1",
            "THREADING": listed,
            "WARP COLORS": colors,
        }
    )
    assert len(text) > 800_000
    start = time.perf_counter()
    assert read(text).ends == threads
    assert time.perf_counter() - start < 1.5  # 0.3 s on an idle machine


def test_a_thousand_presses_of_a_thousand_ties_are_resolved_at_once() -> None:
    tied = "1=" + "1," * 30_000
    start = time.perf_counter()
    draft = read(wif({"TIEUP": tied, "TREADLING": tied}))
    assert rows(draft)[0] == "#..."
    assert time.perf_counter() - start < 2.0  # 0.05 s on an idle machine


def test_treadles_by_shafts_are_judged_before_memory_is_taken() -> None:
    ties = "".join(f"{n}=1\n" for n in range(1, 5001))
    presses = ",".join(map(str, range(1, 5001)))
    weaving = "Shafts=16000\nRising Shed=1"
    with pytest.raises(DraftError, match="treadles by shafts"):
        read(wif({"WEAVING": weaving, "TIEUP": ties, "TREADLING": f"1={presses}"}))
