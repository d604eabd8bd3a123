"""One small file for every rule that real WIFs taught."""

from __future__ import annotations

import numpy as np
import pytest

from tests.draft.wif_text import TWILL_ROWS, read, rows, warned, wif
from weaveusd.draft.statistics import describe
from weaveusd.draft.wif import read_wif
from weaveusd.errors import DraftError


def test_a_clean_file_is_read_without_a_warning() -> None:
    draft = read(wif())
    assert rows(draft) == TWILL_ROWS
    assert (draft.ends, draft.picks, draft.shafts) == (4, 4, 4)
    assert draft.warnings == ()


def test_row_0_is_the_first_pick_and_column_0_the_first_end() -> None:
    draft = read(wif({"TIEUP": "1=1\n2=2", "TREADLING": "1=1\n2=2", "WEFT": "Threads=2\nColor=2"}))
    assert rows(draft) == ["#...", ".#.."]


# --- Lines, sections, encodings -----------------------------------------------------------------


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends_do_not_matter(end: str) -> None:
    assert read(wif().replace("\n", end).encode()) == read(wif())


def test_mixed_line_ends_keep_line_numbers() -> None:
    text = wif({"THREADING": "1=1\r\n2=2\r\n3=3\r\n4=x"})
    with pytest.raises(DraftError, match=r"test\.wif:23: \[THREADING\] row 4 is 'x'"):
        read(text)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16"])
def test_the_title_survives_every_encoding(encoding: str) -> None:
    text = wif({"TEXT": "Title=Käthes Köper 100 %"})
    assert read(text.encode(encoding)).title == "Käthes Köper 100 %"


def test_latin_1_behind_a_byte_order_mark_is_read() -> None:
    data = b"\xef\xbb\xbf" + wif({"TEXT": "Title=Köper"}).encode("latin-1")
    assert read(data).title == "Köper"


def test_a_file_may_start_without_the_header_of_its_first_section() -> None:
    draft = read(wif().removeprefix("[WIF]\n"))
    assert rows(draft) == TWILL_ROWS
    assert not draft.warnings


def test_lines_of_garbage_before_the_first_section_are_warned_about() -> None:
    draft = read("saved by my loom\n" + wif())
    assert rows(draft) == TWILL_ROWS
    assert warned(draft, "line 1", "no keys")


def test_sections_come_in_any_order_and_case_with_blanks_around_everything() -> None:
    parts = wif().split("[")[1:]
    text = "".join(f" [ {p.lower()}" for p in reversed(parts)).replace("=", " = ")
    assert rows(read(text)) == TWILL_ROWS


def test_contents_that_lie_are_not_believed() -> None:
    contents = "THREADING=no\nLIFTPLAN=yes\nWARP COLORS=yes"
    assert read(wif({"CONTENTS": contents})) == read(wif())


def test_private_and_unknown_sections_are_passed_over() -> None:
    private = "1=0,20,32\nTHREADING=x"
    assert not read(wif({"PRIVATE WEAVEIT YARNS": private, "DESIGN": "1=?"})).warnings


def test_symbol_palettes_are_passed_over() -> None:
    symbols = {"WARP SYMBOL PALETTE": "Entries=2", "WARP SYMBOL TABLE": "1='X'\n2=#219"}
    assert read(wif(symbols)) == read(wif())


def test_a_section_that_occurs_twice_is_joined_and_the_last_row_stays() -> None:
    draft = read(wif() + "[THREADING]\n4=1\n")
    assert rows(draft) == ["##.#", ".##.", "..#.", "#..#"]
    assert warned(draft, "[THREADING] occurs twice")
    assert warned(draft, "'4' stands on line 23 too", "line 35 holds")


def test_an_empty_row_does_not_replace_a_filled_one() -> None:
    draft = read(wif() + "[THREADING]\n4=\n")
    assert rows(draft) == TWILL_ROWS
    assert warned(draft, "line 23 holds")


def test_an_empty_section_is_an_absent_one() -> None:
    assert rows(read(wif({"LIFTPLAN": ""}))) == TWILL_ROWS


def test_comments_stand_alone_or_behind_numbers_but_not_behind_text() -> None:
    draft = read(
        wif(
            {
                "TEXT": "; by hand\nTitle=A; B",
                "THREADING": "1=1 ; first\n ;-2=9\n2=2;\n3=3\n4=4",
                "WEAVING": "Shafts=4 ; of 8\nTreadles=4\nRising Shed=yes ; jack",
            }
        )
    )
    assert draft.title == "A; B"
    assert rows(draft) == TWILL_ROWS


def test_pixelooms_marks_of_length_and_name_are_comments() -> None:
    draft = read(wif({"THREADING": "; [2]Border\n1=1 [2]Border\n[2]\n2=2\n[2]Middle\n3=3\n4=4"}))
    assert rows(draft) == TWILL_ROWS


def test_a_row_without_an_equals_sign_is_empty() -> None:
    draft = read(wif({"THREADING": "1=1\n2=2\n3\n4=4"}))
    assert rows(draft) == ["##..", ".#..", "...#", "#..#"]
    assert warned(draft, "row 3 has no equals sign")
    assert warned(draft, "1 of 4 ends are on no shaft")


def test_version_1_2_is_read_with_its_yarns() -> None:
    draft = read(wif({"WIF": "Version=1.2", "YARNS": "1=Peacock, cotton, 8/2\n2=Ash, wool, 2/60"}))
    assert rows(draft) == TWILL_ROWS
    assert draft.yarns == ("Peacock, cotton, 8/2", "Ash, wool, 2/60")
    assert describe(draft).yarns == list(draft.yarns)
    assert warned(draft, "Version is '1.2'")
    assert warned(draft, "[YARNS]", "2 yarns")


def test_a_date_or_program_of_any_form_does_not_matter() -> None:
    head = f"Version=1.1\nDate=yesterday\nSource Program={'x' * 5000}\nDevelopers=a@b.c"
    assert read(wif({"WIF": head})) == read(wif())


# --- Threading, treadling, liftplan -------------------------------------------------------------


def test_an_end_may_be_on_several_shafts_and_a_pick_on_several_treadles() -> None:
    draft = read(wif({"THREADING": "1=1,3\n2=2\n3=3\n4=4", "TREADLING": "1=1, 3\n2=2\n3=3\n4=4"}))
    assert rows(draft) == ["####", "###.", "#.##", "#..#"]


def test_zeros_and_empty_values_mean_no_shaft_and_no_treadle() -> None:
    draft = read(wif({"THREADING": "1=0\n2=2\n3=\n4=4", "TREADLING": "1=0,1\n2=0\n3=\n4=4"}))
    assert rows(draft) == [".#..", "....", "....", "...#"]


def test_ends_that_the_threading_leaves_out_stay_down() -> None:
    draft = read(wif({"WARP": "Threads=6\nColor=1"}))
    assert rows(draft) == [row + ".." for row in TWILL_ROWS]
    assert warned(draft, "2 of 6 ends are on no shaft")


def test_rows_beyond_the_threads_are_ignored_with_a_warning() -> None:
    draft = read(wif({"THREADING": "1=1\n2=2\n3=3\n4=4\n5=0\n6=1"}))
    assert rows(draft) == TWILL_ROWS
    assert warned(draft, "row 5", "2 rows ignored")


def test_rows_may_be_sparse_and_unordered() -> None:
    assert rows(read(wif({"THREADING": "4=4\n2=2\n1=1\n3=3"}))) == TWILL_ROWS


def test_a_liftplan_does_without_tie_up_and_treadling() -> None:
    liftplan = "1=1,2\n2=2,3\n3=3,4\n4=1,4"
    draft = read(wif({"TIEUP": None, "TREADLING": None, "LIFTPLAN": liftplan}))
    assert rows(draft) == TWILL_ROWS
    assert not draft.warnings


def test_a_liftplan_that_agrees_with_the_treadling_is_not_mentioned() -> None:
    assert not read(wif({"LIFTPLAN": "1=1,2\n2=2,3\n3=3,4\n4=1,4"})).warnings


def test_of_a_liftplan_and_a_complete_treadling_that_disagree_the_treadling_holds() -> None:
    draft = read(wif({"LIFTPLAN": "1=1\n2=2\n3=3\n4=4"}))
    assert rows(draft) == TWILL_ROWS
    assert warned(draft, "weave different cloths; [TREADLING] holds")


def test_a_liftplan_holds_against_a_treadling_that_is_not_complete() -> None:
    draft = read(wif({"LIFTPLAN": "1=1\n2=2\n3=3\n4=4", "TREADLING": "1=1\n2=0\n3=0\n4=0"}))
    assert rows(draft) == ["#...", ".#..", "..#.", "...#"]
    assert warned(draft, "[LIFTPLAN], which lifts on more picks, holds")


def test_a_liftplan_replaces_a_treadling_without_tie_up_or_out_of_its_range() -> None:
    liftplan = "1=1,2\n2=2,3\n3=3,4\n4=1,4"
    without = read(wif({"LIFTPLAN": liftplan, "TIEUP": None}))
    beyond = read(wif({"LIFTPLAN": liftplan, "TREADLING": "1=9"}))
    assert rows(without) == rows(beyond) == TWILL_ROWS
    assert warned(without, "[TIEUP] is missing")
    assert warned(beyond, "gives way to [LIFTPLAN]")


def test_treadles_beside_a_liftplan_do_not_matter() -> None:
    liftplan = {"TIEUP": None, "TREADLING": None, "LIFTPLAN": "1=1\n2=2\n3=3\n4=4"}
    weaving = "Shafts=4\nTreadles=14\nRising Shed=1"
    assert rows(read(wif({**liftplan, "WEAVING": weaving})))[0] == "#..."


def test_the_tie_up_may_list_more_treadles_than_stated() -> None:
    draft = read(wif({"WEAVING": "Shafts=4\nTreadles=2\nRising Shed=yes"}))
    assert rows(draft) == TWILL_ROWS
    assert warned(draft, "ties 4 treadles, but [WEAVING] states 2")


def test_treadles_without_a_tie_lift_nothing() -> None:
    weaving = "Shafts=4\nTreadles=9\nRising Shed=yes"
    draft = read(wif({"WEAVING": weaving, "TREADLING": "1=1\n2=9\n3=3\n4=4"}))
    assert rows(draft)[1] == "...."


def test_shafts_beyond_those_stated_are_there_when_something_lifts_them() -> None:
    draft = read(
        wif(
            {
                "THREADING": "1=1\n2=2\n3=18\n4=4",
                "TIEUP": None,
                "TREADLING": None,
                "LIFTPLAN": "1=1,18\n2=2\n3=18\n4=4",
            }
        )
    )
    assert draft.shafts == 18
    assert rows(draft) == ["#.#.", ".#..", "..#.", "...#"]
    assert warned(draft, "lifts shaft 18, but [WEAVING] states 4")


def test_weaving_may_be_missing_altogether() -> None:
    draft = read(wif({"WEAVING": None}))
    assert rows(draft) == TWILL_ROWS
    assert warned(draft, "states no Shafts; 4 are in use")
    assert warned(draft, "read as rising")


def test_threads_that_are_not_stated_are_counted() -> None:
    draft = read(wif({"WARP": "Color=1", "WEFT": "Threads=0\nColor=2"}))
    assert rows(draft) == TWILL_ROWS
    assert warned(draft, "[WARP] states no Threads; 4")
    assert warned(draft, "[WEFT] states no Threads; 4")


def test_treadles_may_be_missing() -> None:
    assert rows(read(wif({"WEAVING": "Shafts=4\nRising Shed=yes"}))) == TWILL_ROWS


@pytest.mark.parametrize("word", ["no", "false", "0", "off", "FALSE"])
def test_a_sinking_shed_gives_the_complement(word: str) -> None:
    draft = read(wif({"WEAVING": f"Shafts=4\nTreadles=4\nRising Shed={word}"}))
    assert rows(draft) == [r.translate(str.maketrans("#.", ".#")) for r in TWILL_ROWS]


@pytest.mark.parametrize("shed", ["", "Rising Shed=", "Rising Shed=perhaps"])
def test_a_shed_that_is_not_stated_rises_with_a_warning(shed: str) -> None:
    draft = read(wif({"WEAVING": f"Shafts=4\nTreadles=4\n{shed}"}))
    assert rows(draft) == TWILL_ROWS
    assert warned(draft, "read as rising")


# --- Counting from 0 ----------------------------------------------------------------------------


def test_a_row_0_shows_that_a_file_counts_from_0() -> None:
    draft = read(
        wif(
            {
                "THREADING": "0=0\n1=1\n2=2\n3=3",
                "TIEUP": "0=0,1\n1=1,2\n2=2,3\n3=0,3",
                "TREADLING": "0=0\n1=1\n2=2\n3=3",
                "COLOR TABLE": "0=0,0,0\n1=255,255,255",
                "WARP": "Threads=4\nColor=0",
                "WEFT": "Threads=4\nColor=1",
                "WARP COLORS": "1=1",
            }
        )
    )
    assert rows(draft) == TWILL_ROWS
    assert draft.warp_color.tolist() == [0, 1, 0, 0]
    assert draft.weft_color.tolist() == [1, 1, 1, 1]
    assert warned(draft, "[THREADING] has a row 0")


def test_a_liftplan_from_0_may_stand_beside_a_threading_from_1() -> None:
    draft = read(wif({"TIEUP": None, "TREADLING": None, "LIFTPLAN": "0=0,1\n1=1,2\n2=2,3\n3=0,3"}))
    assert rows(draft) == TWILL_ROWS


def test_threads_from_0_may_stand_beside_shafts_and_colors_from_1() -> None:
    draft = read(wif({"THREADING": "0=1\n1=2\n2=3\n3=4", "TREADLING": "0=1\n1=2\n2=3\n3=4"}))
    assert rows(draft) == TWILL_ROWS
    assert draft.weft_color.tolist() == [1, 1, 1, 1]


def test_colors_from_0_may_name_a_table_from_1_in_a_file_from_0() -> None:
    draft = read(
        wif(
            {
                "THREADING": "0=0\n1=1\n2=2\n3=3",
                "WARP": "Threads=4\nColor=0",
                "WEFT": "Threads=4\nColor=1",
            }
        )
    )
    assert draft.warp_color.tolist() == [0, 0, 0, 0]
    assert draft.weft_color.tolist() == [1, 1, 1, 1]


def test_an_unused_row_0_before_all_threads_from_1_means_nothing() -> None:
    draft = read(wif({"THREADING": "0=0\n1=1\n2=2\n3=3\n4=4"}))
    assert rows(draft) == TWILL_ROWS


# --- Colors -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("limits", "color", "value"),
    [
        ("0,255", "51,255,0", (0.2, 1.0, 0.0)),
        ("0,999", "333,999,0", (1 / 3, 1.0, 0.0)),
        ("0,65535", "13107,65535,0", (0.2, 1.0, 0.0)),
        ("20,1200", "20,1200,610", (0.0, 1.0, 0.5)),
    ],
)
def test_any_range_of_the_palette_is_scaled_from_its_minimum(
    limits: str, color: str, value: tuple[float, float, float]
) -> None:
    palette = {
        "COLOR PALETTE": f"Entries=2\nRange={limits}",
        "COLOR TABLE": f"1={color}\n2={color}",
    }
    assert read(wif(palette)).palette[0].tolist() == list(value)


@pytest.mark.parametrize(("top", "white"), [(255, 255), (999, 999), (65535, 65535)])
def test_a_range_that_is_not_stated_is_the_usual_one_that_fits(top: int, white: int) -> None:
    table = {"COLOR PALETTE": None, "COLOR TABLE": f"1=0,0,0\n2={top},{top},{top}"}
    draft = read(wif(table))
    assert draft.palette[1].tolist() == [top / white] * 3
    assert warned(draft, f"states no Range; 0 to {white}")


def test_colors_listed_for_some_threads_leave_the_default_to_the_rest() -> None:
    draft = read(wif({"WARP COLORS": "2=2", "WEFT COLORS": "1=1\n4=1"}))
    assert draft.warp_color.tolist() == [0, 1, 0, 0]
    assert draft.weft_color.tolist() == [0, 1, 1, 0]


def test_threads_without_any_color_get_the_first_and_the_second_with_a_warning() -> None:
    draft = read(wif({"WARP": "Threads=4", "WEFT": "Threads=4", "WARP COLORS": "1=2"}))
    assert draft.warp_color.tolist() == [1, 0, 0, 0]
    assert draft.weft_color.tolist() == [1, 1, 1, 1]
    assert warned(draft, "[WARP] states no Color")


def test_a_default_color_outside_the_palette_that_no_thread_takes_is_a_warning() -> None:
    draft = read(wif({"WARP": "Threads=4\nColor=7", "WARP COLORS": "1=1\n2=1\n3=1\n4=2"}))
    assert warned(draft, "[WARP] Color is not in the palette")


def test_a_color_may_be_followed_by_its_components() -> None:
    draft = read(wif({"WARP": "Threads=4\nColor=2,255,255,255", "WARP COLORS": "1=1,0,0,0"}))
    assert draft.warp_color.tolist() == [0, 1, 1, 1]


def test_components_behind_colors_serve_where_the_table_is_missing() -> None:
    draft = read(
        wif(
            {
                "COLOR TABLE": None,
                "COLOR PALETTE": None,
                "WARP": "Threads=4\nColor=1,255,0,0",
                "WEFT": "Threads=4\nColor=2,0,0,255",
            }
        )
    )
    assert draft.palette.tolist() == [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]


def test_colors_are_made_up_where_there_is_no_palette() -> None:
    draft = read(wif({"COLOR TABLE": None, "COLOR PALETTE": None}))
    assert rows(draft) == TWILL_ROWS
    assert draft.palette[draft.warp_color[0]].sum() < draft.palette[draft.weft_color[0]].sum()
    assert warned(draft, "[COLOR TABLE] is missing; the colors are made up")


def test_entries_keep_their_numbers_where_the_table_has_gaps() -> None:
    table = "1=0,0,0\n4=255,255,255"
    draft = read(wif({"COLOR TABLE": table, "WEFT": "Threads=4\nColor=4"}))
    assert draft.weft_color.tolist() == [3, 3, 3, 3]
    assert len(draft.palette) == 4


def test_a_component_outside_the_range_is_moved_to_its_border() -> None:
    draft = read(wif({"COLOR TABLE": "1=0,0,0\n2=300,255,0"}))
    assert draft.palette[1].tolist() == [1.0, 1.0, 0.0]
    assert warned(draft, "leaves the palette's Range")


def test_a_name_behind_a_color_is_ignored() -> None:
    draft = read(wif({"COLOR TABLE": "1=0,0,0, Raven\n2=255,255,255,Snow, 2"}))
    assert draft.palette.tolist() == [[0.0] * 3, [1.0] * 3]
    assert warned(draft, "color 2 has more than R, G, B")


# --- Lengths ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("units", "spacing", "pitch_mm"),
    [
        ("Centimeters", "0.212", 2.12),
        ("centimetres", ".05", 0.5),
        ("Inches ", "0.04167", 1.058418),
        ("Decipoints", "30", 25.4 * 30 / 720),
        ("mm", "5e-1", 0.5),
    ],
)
def test_spacing_is_the_pitch_in_any_unit(units: str, spacing: str, pitch_mm: float) -> None:
    draft = read(wif({"WARP": f"Threads=4\nColor=1\nUnits={units}\nSpacing={spacing}"}))
    np.testing.assert_array_equal(draft.warp_pitch_mm, np.full(4, pitch_mm))
    assert draft.warp_thickness_mm is None
    assert draft.weft_pitch_mm is None


def test_lengths_of_single_threads_stand_over_the_default() -> None:
    warp = "Threads=4\nColor=1\nUnits=centimeters\nSpacing=0.2\nThickness=0.1"
    draft = read(wif({"WARP": warp, "WARP SPACING": "2=0.3", "WARP THICKNESS": "4=0.05"}))
    assert draft.warp_pitch_mm is not None
    assert draft.warp_thickness_mm is not None
    assert draft.warp_pitch_mm.tolist() == [2.0, 3.0, 2.0, 2.0]
    assert draft.warp_thickness_mm.tolist() == [1.0, 1.0, 1.0, 0.5]


def test_lengths_of_some_threads_without_a_default_give_the_rest_their_middle_one() -> None:
    weft = "Threads=4\nColor=2\nUnits=centimeters"
    draft = read(wif({"WEFT": weft, "WEFT SPACING": "1=0.1\n2=0.2\n3=0.4"}))
    assert draft.weft_pitch_mm is not None
    assert draft.weft_pitch_mm.tolist() == [1.0, 2.0, 4.0, 2.0]
    assert warned(draft, "Spacing is stated for some threads only")


def test_weaveits_decipoints_are_inches() -> None:
    draft = read(wif({"WARP": "Threads=4\nColor=1\nUnits=Decipoints\nSpacing=0.05"}))
    assert draft.warp_pitch_mm is not None
    assert draft.warp_pitch_mm[0] == 1.27
    assert warned(draft, "read as inches")


def test_handweavings_placeholder_is_not_taken_for_a_sett() -> None:
    lengths = "Units=Centimeters\nSpacing=0.0185\nThickness=0.0213"
    draft = read(wif({"WARP": f"Threads=4\nColor=1\n{lengths}"}))
    assert draft.warp_pitch_mm is None
    assert draft.warp_thickness_mm is None
    assert warned(draft, "placeholder")


def test_lengths_without_units_borrow_those_of_the_other_system_or_count_for_nothing() -> None:
    warp = "Threads=4\nColor=1\nSpacing=0.1"
    borrowed = read(wif({"WARP": warp, "WEFT": "Threads=4\nColor=2\nUnits=inches"}))
    assert borrowed.warp_pitch_mm is not None
    assert borrowed.warp_pitch_mm[0] == 2.54
    alone = read(wif({"WARP": warp}))
    assert alone.warp_pitch_mm is None
    assert warned(alone, "without Units; taken as not stated")


@pytest.mark.parametrize("stated", ["Units=furlongs\nSpacing=1", "Units=cm\nSpacing=0"])
def test_lengths_that_say_nothing_are_not_stated(stated: str) -> None:
    draft = read(wif({"WARP": f"Threads=4\nColor=1\n{stated}"}))
    assert draft.warp_pitch_mm is None
    assert warned(draft, "taken as not stated")


@pytest.mark.parametrize("spacing", ["1e9", "1e-9"])
def test_a_length_that_no_yarn_has_is_not_stated(spacing: str) -> None:
    draft = read(wif({"WARP": f"Threads=4\nColor=1\nUnits=cm\nSpacing={spacing}"}))
    assert draft.warp_pitch_mm is None
    assert warned(draft, "Spacing leaves")


def test_a_decimal_comma_is_read_with_a_warning() -> None:
    draft = read(wif({"WARP": "Threads=4\nColor=1\nUnits=cm\nSpacing=0,05"}))
    assert draft.warp_pitch_mm is not None
    assert draft.warp_pitch_mm[0] == 0.5
    assert warned(draft, "decimal comma")


def test_zooms_are_for_the_screen() -> None:
    warp = "Threads=4\nColor=1\nUnits=cm\nSpacing=0.1\nSpacing Zoom=3"
    draft = read(wif({"WARP": warp, "WARP SPACING ZOOM": "1=2"}))
    assert draft.warp_pitch_mm is not None
    assert draft.warp_pitch_mm.tolist() == [1.0] * 4
    assert warned(draft, "Spacing Zoom is for the screen")
    assert warned(draft, "[WARP SPACING ZOOM]")


# --- Text and privacy ---------------------------------------------------------------------------


def test_notes_are_joined_in_the_order_of_their_numbers() -> None:
    draft = read(wif({"NOTES": "2=second; still second\n1=first\n3=\nloose\n4="}))
    assert draft.notes == "first\nsecond; still second\n\nloose"


def test_personal_fields_never_enter_the_draft() -> None:
    person = "Title=T\nAuthor=Jane\nAddress=1 Mill Lane\nEMail=j@x.org\nTelephone=555\nFAX=556"
    draft = read(wif({"TEXT": person, "WIF": "Version=1.1\nDevelopers=dev@x.org"}))
    said = repr(draft)
    for private in ("Jane", "Mill Lane", "j@x.org", "555", "556", "dev@x.org"):
        assert private not in said


def test_a_title_stays_one_line_without_control_characters() -> None:
    assert read(wif({"TEXT": "Title= a\tb\x00c\x1b[31m "})).title == "a b c [31m"


# --- Faults -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"WARP": "Threads=4\nColor=3"}, r"test.wif:9: \[WARP\] names color 3; expected one of"),
        ({"WEFT COLORS": "1=0"}, r"\[WEFT COLORS\] names color 0; expected one of the 2"),
        ({"WARP COLORS": "1=1", "COLOR TABLE": None}, r"a missing \[COLOR TABLE\]; expected a"),
        ({"TIEUP": None}, r"test.wif: \[TIEUP\] is missing or empty; expected it beside"),
        ({"TREADLING": None}, r"\[TREADLING\] is missing or empty; expected .* \[LIFTPLAN\]"),
        ({"THREADING": None}, r"\[THREADING\] is missing or empty; expected the shaft"),
        ({"TREADLING": "1=5"}, r":30: \[TREADLING\] row 1 names treadle 5; expected at most 4"),
        ({"THREADING": "1=9"}, r":20: \[THREADING\] names shaft 9; expected at most 4"),
        ({"WARP": None, "THREADING": None}, r"\[WARP\] states no number of threads; expected"),
        ({"COLOR TABLE": "1=0,0\n2=1,1,1"}, r"color 1 has 2 numbers; expected R, G, B"),
        ({"COLOR TABLE": "99999=0,0,0"}, r"found color 99999; expected at most 65536"),
        ({"WEAVING": "Shafts=many"}, r"Shafts is 'many'; expected a whole number above 0"),
        ({"WEAVING": "Shafts=-4"}, r"Shafts is '-4'; expected a whole number above 0"),
        ({"WARP": "Threads=4\nColor=1\nUnits=cm\nSpacing=-1"}, r"Spacing is '-1'; expected a num"),
        ({"THREADING": "-1=1"}, r"a row is numbered '-1'; expected a number from 1 on"),
        ({"TIEUP": "1=1,-2"}, r"row 1 is '1,-2'; expected whole numbers of 0 or more"),
    ],
)
def test_a_fault_is_one_line_with_file_section_found_and_expected(
    changes: dict[str, str | None], message: str
) -> None:
    with pytest.raises(DraftError, match=message) as caught:
        read(wif(changes))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("data", [b"", b"\x89PNG\r\n\x1a\n\0\0", b"[WIF]\nVersion=1.1\n", b"hello"])
def test_what_is_no_wif_is_refused(data: bytes) -> None:
    with pytest.raises(DraftError, match="no section of a draft; expected a WIF"):
        read(data)


@pytest.mark.parametrize("name", ["absent.wif", "", "a\0b", "new\nline.wif"])
def test_a_file_that_cannot_be_opened_is_named_on_one_line(
    name: str, tmp_path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(DraftError, match="cannot be read") as caught:
        read_wif(name)
    assert "\n" not in str(caught.value)
