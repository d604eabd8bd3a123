"""What `weaveusd lobes --check` says is what the tests of the BSDF ask for."""

from __future__ import annotations

from dataclasses import replace

import pytest

from weaveusd.proof import check
from weaveusd.proof.subjects import subjects

pytestmark = pytest.mark.usefixtures("renderer")


def faults(rows: tuple[check.Row, ...]) -> list[str]:
    return [f"{row.yarns[0]} at {row.angle_deg:g}°: {f}" for row in rows for f in row.faults]


def test_every_preset_keeps_every_law_at_every_angle():
    rows = check.check(subjects())
    assert len(rows) == len(subjects()) * len(check.ANGLES)
    assert not faults(rows)


def test_every_preset_keeps_every_law_with_gaussian_lobes():
    rows = check.check(subjects(), check.QUICK_ANGLES, gaussian=True, samples=check.QUICK_SAMPLES)
    assert not faults(rows)


def test_light_that_passes_leaves_on_the_other_side():
    clear, opaque = (
        check.check([replace(s, optics=replace(s.optics, tau=tau))], [30.0])[0]
        for s in subjects(["linen"])
        for tau in (0.4, 0.0)
    )
    assert opaque.transmitted == opaque.density_back == 0
    assert clear.transmitted > 0.2
    assert clear.reflected < opaque.reflected


@pytest.mark.parametrize(
    ("limit", "value", "fault"),
    [
        ("DENSITY_LIMIT", -1.0, "∫pdf is not 1"),
        ("SINGLE_DENSITY_LIMIT", -1.0, "∫pdf of Dr.Jit is not 1"),
        ("ALBEDO_LIMIT", 0.5, "more light than comes in"),
        ("RECIPROCITY_LIMIT", -1.0, "not reciprocal"),
        ("SINGLE_LIMIT", (-1.0, -1.0), "Dr.Jit differs"),
        ("GOLDEN_LIMIT", -1.0, "golden values differ"),
    ],
)
def test_what_is_out_of_bounds_is_named(monkeypatch, limit, value, fault):
    monkeypatch.setattr(check, limit, value)
    rows = check.check(subjects(["linen"]), [30.0], samples=check.QUICK_SAMPLES)
    assert [row.faults for row in rows] == [(fault,)]


def test_a_sampler_that_does_not_follow_its_density_is_found(monkeypatch):
    from weaveusd.render import sampling

    drawn = sampling.sample

    def bent(*arguments):
        import drjit as dr

        wo = drawn(*arguments)
        theta = wo.theta * 0.95
        sin_theta, cos_theta = dr.sincos(theta)
        return replace(wo, theta=theta, sin_theta=sin_theta, cos_theta=cos_theta)

    monkeypatch.setattr(sampling, "sample", bent)
    (row,) = check.check(subjects(["silk"]), [30.0], samples=check.QUICK_SAMPLES)
    assert len(row.faults) == 1
    assert row.faults[0].startswith("chi² p below")
