"""Every way to scatter is proven once."""

from __future__ import annotations

import pytest

from weaveusd.errors import InputError, RecipeError
from weaveusd.proof.golden import golden_error
from weaveusd.proof.subjects import inclinations, subjects
from weaveusd.yarn.recipe import preset_names, read_preset


def test_every_yarn_of_every_preset_is_in_one_subject():
    named = [yarn for subject in subjects() for yarn in subject.yarns]
    expected = [f"{n}/{yarn.name}" for n in preset_names() for yarn in read_preset(n).yarns]
    assert sorted(named) == sorted(expected)


def test_no_two_subjects_scatter_alike():
    optics = [subject.optics for subject in subjects()]
    assert len(optics) == len(set(optics))


def test_a_preset_named_twice_is_taken_once():
    assert subjects(["silk", "linen", "silk"]) == subjects(["silk", "linen"])


def test_an_unknown_preset_is_refused():
    with pytest.raises(RecipeError, match="no preset 'sackcloth'"):
        subjects(["sackcloth"])


@pytest.mark.parametrize("angle", [90.0, -95.0, float("nan")])
def test_an_angle_that_grazes_or_is_none_is_refused(angle):
    with pytest.raises(InputError, match=r"expected -89.9° to 89.9°"):
        inclinations([angle])


@pytest.mark.parametrize("gaussian", [False, True])
def test_every_preset_has_golden_values(gaussian):
    for subject in subjects():
        error = golden_error(subject.optics, gaussian=gaussian)
        assert error is not None, f"{subject.yarns[0]}: add its optics to tests/golden"
        assert error < 1e-7
