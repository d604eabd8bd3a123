"""A count means the same yarn in whatever unit a mill states it."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from weaveusd.yarn.count import TEX_LIMITS, UNITS, count_limits, parse_count, tex_of


@pytest.mark.parametrize(
    ("count", "unit", "tex"),
    [(590.541, "Ne", 1), (1000, "Nm", 1), (9, "denier", 1), (1653.515, "lea", 1), (1, "tex", 1),
     (20, "Ne", 29.53), (60, "Nm", 16.67), (42, "denier", 4.667), (25, "lea", 66.14)],
)  # fmt: skip
def test_units_are_what_the_tables_say(count, unit, tex):
    assert tex_of(count, unit) == pytest.approx(tex, rel=2e-4)


@given(st.floats(1, 200), st.sampled_from(["Ne", "Nm", "lea"]))
def test_a_higher_indirect_count_is_a_finer_yarn(count, unit):
    assert tex_of(2 * count, unit) == pytest.approx(tex_of(count, unit) / 2)


@given(st.floats(1, 200), st.sampled_from(["tex", "denier"]))
def test_a_higher_direct_count_is_a_thicker_yarn(count, unit):
    assert tex_of(2 * count, unit) == pytest.approx(tex_of(count, unit) * 2)


@pytest.mark.parametrize("unit", UNITS)
def test_the_limits_of_every_unit_are_those_of_tex(unit):
    found = sorted(tex_of(count, unit) for count in count_limits(unit))
    assert found == pytest.approx(TEX_LIMITS)
    assert list(count_limits(unit)) == sorted(count_limits(unit))


@pytest.mark.parametrize(
    ("text", "tex", "plies"),
    [
        ("60 Nm", 16.667, None),
        ("Nm 60", 16.667, None),
        ("2/60 Nm", 33.333, 2),
        ("Nm 60/2", 33.333, 2),
        ("10/2 Ne", 118.108, 2),
        ("Ne 10/2", 118.108, 2),
        ("Ne 40", 14.764, None),
        ("42 denier", 4.667, None),
        ("42den", 4.667, None),
        ("84 denier x 3", 28, 3),
        ("16.5 tex × 2", 33, 2),
        ("R 33 tex/2", 33, 2),
        (" 25 lea ", 66.141, None),
        ("1/20 Ne", 29.527, 1),
    ],
)
def test_a_count_is_read_as_mills_write_it(text, tex, plies):
    count = parse_count(text)
    assert (count.tex, count.plies) == (pytest.approx(tex, rel=1e-4), plies)


@given(st.integers(1, 4), st.integers(8, 120), st.sampled_from(["Ne", "Nm", "lea"]))
def test_plying_adds_up_the_singles(plies, single, unit):
    whole = parse_count(f"{plies}/{single} {unit}")
    assert whole == parse_count(f"{unit} {single}/{plies}")
    assert whole.tex == pytest.approx(plies * parse_count(f"{single} {unit}").tex)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected a count like"),
        ("sixty", "expected a count like"),
        ("60", "expected a count like"),
        ("60 Nm 2", "expected a count like"),
        ("-60 Nm", "expected a count like"),
        ("1e9 tex", "expected a count like"),
        ("３ tex", "expected a count like"),
        ("0 Ne", "above 0"),
        ("3/4 Ne", "at least twice the other"),
        ("0/4 Ne", "0 plies"),
        ("1.5/60 Nm", "1.5 plies"),
        ("17/60 Nm", "17 plies"),
        ("75/36 denier", 'as "84 denier x 2"'),
        ("2/60 Nm x 2", "plies of Nm"),
        ("999999 Ne", "0.0005905 tex, expected 0.1 to"),
        ("R 33 tex/0", "0 plies"),
        ("x" * 500, "expected a count like"),
    ],
)
def test_what_could_mean_something_else_is_refused(text, message):
    with pytest.raises(ValueError, match=message) as caught:
        parse_count(text)
    assert len(str(caught.value)) < 250
