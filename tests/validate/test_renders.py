"""Checks that render: what a good asset gives, and what a renderer's own faults cost."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.validate.assets import publish
from tests.validate.faults import FAULTS
from weaveusd.errors import RendererUnavailableError
from weaveusd.render import variant
from weaveusd.render.probe import Sampled
from weaveusd.validate.checks import noise
from weaveusd.validate.model import Status
from weaveusd.validate.profiles import find_profile
from weaveusd.validate.run import examine, validate
from weaveusd.validate.trial import Trial

try:
    variant.prepare()
    _MISSING = ""
except RendererUnavailableError as error:
    _MISSING = str(error)

pytestmark = pytest.mark.skipif(bool(_MISSING), reason=_MISSING)

SMALL = replace(find_profile("standard"), size=24, spp=32, samples=20_000)


@pytest.fixture(scope="module")
def entry(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return publish(tmp_path_factory.mktemp("asset") / "v001")


def codes(entry: Path, check: str) -> set[str]:
    return {finding.code for finding in validate(entry, profile=SMALL, checks=[check]).findings}


def test_a_swatch_renders_as_predicted_and_one_of_another_gain_does_not(
    entry: Path, tmp_path: Path
) -> None:
    assert codes(entry, "render/swatch") == {"render/swatch/pass"}
    fault = next(fault for fault in FAULTS if fault.name == "a_gain_of_another_weave")
    assert codes(fault.plant(tmp_path / "v001"), "render/swatch") == {"swatch-color"}


@pytest.mark.slow
def test_a_good_asset_passes_every_render_and_shows_it(entry: Path) -> None:
    report, asset = examine(entry, profile=SMALL, checks=["render"])
    assert {finding.status for finding in report.findings} == {Status.PASS}
    assert {"swatch", "furnace", "exact", "preview-flip", "mtlx-delta-e"} <= set(asset.shown)
    assert asset.shown["swatch"].source.startswith("data:image/png;base64,")


@pytest.mark.slow
def test_a_sampler_is_found_sound(entry: Path) -> None:
    assert codes(entry, "optics/sampling") == {"optics/sampling/pass"}


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (Sampled(p_value=0.5, density=4.72), {"pdf-not-one"}),
        (Sampled(p_value=1e-9, density=1.0), {"sampling-off"}),
        (Sampled(p_value=float("nan"), density=float("nan")), {"pdf-not-one", "sampling-off"}),
    ],
)
def test_a_sampler_that_is_off_is_found(
    entry: Path, monkeypatch: pytest.MonkeyPatch, found: Sampled, expected: set[str]
) -> None:
    monkeypatch.setattr("weaveusd.render.probe.chi_square", lambda *args, **kwargs: found)
    assert codes(entry, "optics/sampling") == expected


@pytest.mark.parametrize(
    ("spoil", "expected"),
    [
        (lambda image, seed: image + 0.02 * (seed < noise.PICTURES), "noise-biased"),
        (lambda image, seed: np.full_like(image, 0.5), "noise-none"),
        (lambda image, seed: np.where(image > image.mean(), np.nan, image), "render-not-finite"),
        (lambda image, seed: image, "render/noise/pass"),
    ],
    ids=["biased", "still", "not_finite", "sound"],
)
def test_what_stays_when_the_seed_changes_is_no_noise(
    entry: Path, monkeypatch: pytest.MonkeyPatch, spoil, expected: str
) -> None:
    render = Trial.render

    def spoilt(self: Trial, *args, seed: int = 0, **settings):
        result = render(self, *args, seed=seed, **settings)
        return replace(result, image=spoil(result.image, seed))

    monkeypatch.setattr(Trial, "render", spoilt)
    assert codes(entry, "render/noise") == {expected}


def test_a_cloth_that_pales_with_its_distance_is_found(
    entry: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert codes(entry, "render/distance") == {"render/distance/pass"}
    render = Trial.render

    def paling(self: Trial, setting, **settings):
        result = render(self, setting, **settings)
        return replace(result, image=result.image * (1.3 if setting.span > 1 else 1.0))

    monkeypatch.setattr(Trial, "render", paling)
    assert codes(entry, "render/distance") == {"distance-color"}


def test_moment_maps_of_a_darker_cloth_are_found_from_afar_alone(tmp_path: Path) -> None:
    fault = next(f for f in FAULTS if f.name == "a_cloth_that_darkens_with_its_distance")
    assert codes(fault.plant(tmp_path / "v001"), "render/distance") == {"distance-level"}


def test_without_a_renderer_its_checks_are_skipped_and_say_why(
    entry: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(wish: str | None = None) -> str:
        raise RendererUnavailableError("no libLLVM here")

    monkeypatch.setattr(variant, "prepare", missing)
    report = validate(entry, profile=SMALL, checks=["render", "optics/sampling"])
    assert {finding.status for finding in report.findings} == {Status.SKIP}
    assert {finding.message for finding in report.findings} == {"no libLLVM here"}
