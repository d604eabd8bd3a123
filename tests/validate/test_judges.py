"""What judges compute for themselves: drafts, scattering, FLIP."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

from tests.strategies import drafts
from weaveusd.draft.write import write_wif
from weaveusd.errors import InputError
from weaveusd.shading import laws
from weaveusd.shading.microcylinder import Parameters, evaluate
from weaveusd.shading.normalization import normalization
from weaveusd.validate.color_difference import delta_e_2000
from weaveusd.validate.drafts import ReadDraft, read_draft
from weaveusd.validate.flip import flip
from weaveusd.validate.scattering import YarnOptics, lobes, scattered, surface_above

LINEN = YarnOptics(
    eta=1.46, k_d=0.3, k_s=0.8, gamma_s=0.21, gamma_v=0.42, tau=0.1, normalization=1.3
)


@settings(max_examples=60, deadline=None)
@given(draft=drafts())
def test_the_judge_reads_the_weave_that_the_maker_wrote(draft) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "draft.wif"
        path.write_bytes(write_wif(draft))
        np.testing.assert_array_equal(read_draft(path).warp_up, draft.drawdown())


def test_a_draft_is_repeated_only_whole() -> None:
    draft = ReadDraft(np.eye(3, dtype=bool), even=True)
    assert draft.repeated(7, 6) is None
    repeated = draft.repeated(6, 9)
    assert repeated is not None
    assert repeated.shape == (9, 6)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"\[WARP\] has Threads=''"),
        ("[WARP]\nThreads=99999999", "expected 1 to"),
        (
            "[WARP]\nThreads=2\n[WEFT]\nThreads=2\n[WEAVING]\nShafts=2\n",
            r"no section \[THREADING\]",
        ),
        (
            "[WARP]\nThreads=2\n[WEFT]\nThreads=2\n[WEAVING]\nShafts=2\n[THREADING]\n1=3\n",
            r"\[THREADING\] has '3', expected 0 to 2",
        ),
        (
            "[WARP]\nThreads=65536\n[WEFT]\nThreads=65536\n[WEAVING]\nShafts=2\n",
            "more than are read",
        ),
        (
            "[WARP]\nThreads=2\n[WEFT]\nThreads=2\n[WEAVING]\nShafts=2\n[THREADING]\n0=1\n",
            "names row '0'",
        ),
    ],
)
def test_a_hostile_draft_is_refused_before_it_takes_memory(
    tmp_path: Path, text: str, message: str
) -> None:
    path = tmp_path / "draft.wif"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_draft(path)


def test_the_judge_scatters_as_the_maker_does() -> None:
    rng = np.random.default_rng(2)
    theta, phi = rng.uniform(-1.4, 1.4, (2, 500)), rng.uniform(-math.pi, math.pi, (2, 500))
    phi[0] *= 0.49  # the viewer is on the side of the normal
    wi, wo = laws.direction(theta[0], phi[0]), laws.direction(theta[1], phi[1])
    surface, volume = lobes(LINEN, theta[0], phi[0], theta[1], phi[1])
    cosine = np.abs(np.cos(theta[1]) * np.cos(phi[1]))
    params = Parameters(1.46, 0.3, 0.8, 0.21, 0.42, 0.1, A=(1.0,))
    expected = evaluate(wi, wo, laws.NORMAL, laws.ALONG, params)[:, 0]
    own = normalization(1.46, 0.3, 0.8, 0.21, 0.42)
    found = (surface + volume * own / LINEN.normalization) * cosine
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("degrees", [0, 30, 60, 85])
def test_the_shares_of_both_lobes_are_those_of_a_brute_sum(degrees: int) -> None:
    theta_i, phi_i = math.radians(degrees), math.radians(25)
    theta = (np.arange(2000) + 0.5) / 2000 * math.pi - math.pi / 2
    phi = (np.arange(720) + 0.5) / 720 * 2 * math.pi - math.pi
    surface, volume = lobes(LINEN, theta_i, phi_i, theta[:, None], phi)
    weights = (
        np.cos(theta)[:, None] ** 2 * np.abs(np.cos(phi)) * (math.pi / 2000) * (math.tau / 720)
    )
    expected = float(np.sum(surface * weights)), float(np.sum(volume * weights))
    assert scattered(LINEN, theta_i, phi_i) == pytest.approx(expected, rel=2e-3)


def test_an_upright_texel_mirrors_the_whole_of_its_surface_lobe() -> None:
    up, along = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    found = surface_above(LINEN, up, along, np.array([0.0, 0.0, 1.0]))
    assert found == pytest.approx(scattered(LINEN, 0.0)[0], rel=1e-6)


def test_flip_is_nothing_for_equal_pictures_and_grows_with_the_difference() -> None:
    rng = np.random.default_rng(3)
    picture = rng.random((40, 50, 3))
    assert flip(picture, picture).max() == 0.0
    small, large = (flip(picture, np.clip(picture + step, 0, 1)).mean() for step in (0.02, 0.3))
    assert 0 < small < large < 1
    assert flip(np.zeros((30, 30, 3)), np.ones((30, 30, 3))).mean() > 0.9


def test_flip_agrees_with_its_authors_program() -> None:
    """The mean that flip-evaluator 1.7 gives for these pictures, LDR, 67 pixels a degree."""
    rng = np.random.default_rng(3)
    one = rng.random((60, 70, 3))
    other = np.clip(one + rng.normal(0, 0.2, one.shape), 0, 1)
    other[10:30, 20:40] = [1, 0, 0]
    assert flip(one, other).mean() == pytest.approx(0.31135618686676025, abs=2e-4)


def test_equal_colors_differ_by_nothing_and_black_from_white_by_a_hundred() -> None:
    assert delta_e_2000([0.2, 0.3, 0.4], [0.2, 0.3, 0.4]) == pytest.approx(0, abs=1e-9)
    assert delta_e_2000([1.0, 1, 1], [0.0, 0, 0]) == pytest.approx(100, abs=0.1)
