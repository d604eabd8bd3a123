"""The cloths of the example stages: how they resist, hang, lie and are sewn."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "examples" / "stages"))

import cushions
import panels
import pillow
import skirt
from colliders import Colliders
from relax import GRAVITY, Fabric, Phase, energy, relax, stretches

CLOTH = Fabric(density=0.2, stretch=2000.0, shear=100.0, bend=1e-5)
CELLS = np.array((8, 8, 8))


def sheet(width=0.2, height=0.2, columns=8, rows=8, upright=True):
    """A rectangle, in the plane z = 0 or lying in y = 0."""

    def place(right, up):
        s, t = width * right, height * up
        x, flat = s - width / 2, np.zeros_like(s)
        return [s, t, x, t, flat] if upright else [s, t, x, flat, -t]

    return panels.sew([panels.plane(rows, columns, place)])


def top_row(sewn):
    pinned = np.zeros(len(sewn.start), bool)
    pinned[sewn.ids[0][-1]] = True
    return pinned


def test_a_cloth_as_cut_resists_nothing():
    sewn = sheet()
    assert energy(panels.body_of(sewn, CLOTH), sewn.start, gravity=0.0) < 1e-15


def test_a_turned_cloth_resists_nothing():
    sewn = sheet()
    turn, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    assert energy(panels.body_of(sewn, CLOTH), sewn.start @ turn + 1.0, gravity=0.0) < 1e-12


def test_a_stretch_costs_half_its_square():
    sewn = sheet()
    body = panels.body_of(sewn, CLOTH)
    wider = sewn.start * (1.01, 1, 1)
    assert energy(body, wider, gravity=0.0) == pytest.approx(0.5 * 2000 * 0.04 * 0.01**2, rel=1e-6)
    assert stretches(body, wider) == pytest.approx(np.tile((1.01, 1.0), (len(body.areas), 1)))


def test_a_bend_costs_its_curvature():
    """Half the rigidity, times the curvature squared, times the area."""
    radius = 0.1
    sewn = sheet(columns=32)
    x, y, _ = sewn.start.T
    rolled = np.stack((radius * np.sin(x / radius), y, radius * np.cos(x / radius)), axis=1)
    stiff = Fabric(density=0.2, stretch=0.0, shear=0.0, bend=1.0)
    expected = 0.5 * 0.04 / radius**2
    assert energy(panels.body_of(sewn, stiff), rolled, 0.0) == pytest.approx(expected, rel=0.1)


def test_a_hanging_strip_is_stretched_by_its_weight():
    soft = Fabric(density=0.2, stretch=60.0, shear=20.0, bend=1e-6)
    height = 0.3
    sewn = sheet(0.05, height, 4, 24)
    # What a sweep leaves unmended shrinks with the square of the step.
    phases = [Phase(0.6, 1 / 9600, drag=6.0), Phase(0.3, 1 / 9600, drag=40.0)]
    rest = relax(panels.body_of(sewn, soft, top_row(sewn)), sewn.start, phases, Colliders(0))
    drop = -rest[sewn.ids[0][0], 1].mean()
    assert drop == pytest.approx(0.2 * GRAVITY * height**2 / (2 * 60.0), rel=0.05)


def test_energy_falls_until_a_cloth_hangs_still():
    sewn = sheet(upright=False)
    body = panels.body_of(sewn, CLOTH, top_row(sewn))
    times = (0.0, 0.15, 0.3, 0.6, 1.2)
    at = [relax(body, sewn.start, [Phase(t, drag=6.0)], Colliders(0)) for t in times]
    energies = [energy(body, p) for p in at]
    assert energies == sorted(energies, reverse=True)
    assert np.abs(at[-1][:, 2].min() - at[-1][:, 2].max()) < 0.25  # it hung down, not away
    assert at[-1][:, 1].min() == pytest.approx(-0.2, rel=0.02)


def test_a_symmetric_cloth_hangs_symmetrically():
    sewn = sheet(upright=False)
    grid = sewn.ids[0]
    pinned = np.zeros(len(sewn.start), bool)
    pinned[[grid[-1, 0], grid[-1, -1]]] = True
    body = panels.body_of(sewn, CLOTH, pinned)
    rest = relax(body, sewn.start, [Phase(1.0, drag=8.0), Phase(0.5, drag=40.0)], Colliders(0))
    mirrored = rest[grid[:, ::-1]] * (-1, 1, 1)
    assert np.abs(mirrored - rest[grid]).max() < 0.01 * 0.2


def test_the_same_cloth_falls_alike_to_the_bit():
    one, two = pillow.pillow(8)[1], pillow.pillow(8)[1]
    assert np.array_equal(one, two)


def test_cloth_stays_out_of_what_is_solid():
    sewn = sheet(0.3, 0.3, 16, 16, upright=False)
    start = sewn.start + np.array((0, 0.25, 0.15))
    axes = np.array(((0.8, 0, 0.6), (0, 1, 0), (-0.6, 0, 0.8)))
    solids = Colliders(0.002).ground().ellipsoid((0, 0.1, 0), (0.06, 0.1, 0.05))
    solids.box((0.1, 0.04, 0.0), (0.04, 0.04, 0.04), axes)
    rest = relax(panels.body_of(sewn, CLOTH), start, [Phase(1.0, drag=2.0)], solids)
    assert rest[:, 1].min() >= 0.002
    assert np.linalg.norm((rest - (0, 0.1, 0)) / (0.062, 0.102, 0.052), axis=1).min() > 0.99
    inside = np.abs((rest - (0.1, 0.04, 0.0)) @ axes.T) < 0.0419
    assert not inside.all(axis=1).any()
    assert rest[:, 1].max() > 0.19  # it lies on the ellipsoid


def test_a_cushion_takes_the_volume_of_its_filling():
    sewn = panels.sew(cushions.box_panels(cushions.Box.of((0, 0, 0), (0.4, 0.2, 0.3)), CELLS))
    limp = Fabric(density=0.2, stretch=2000.0, shear=100.0, bend=0.0)
    body = panels.body_of(sewn, limp)
    slowly = Phase(2.0, gravity=0.0, drag=300.0, pressure=200.0, volume=1.1 * 0.024)
    rest = relax(body, sewn.start, [slowly], Colliders(0))
    a, b, c, d = (rest[sewn.quads[:, k]] for k in range(4))
    one, two = np.einsum("ij,ij", a, np.cross(b, c)), np.einsum("ij,ij", a, np.cross(c, d))
    assert (one + two) / 6 == pytest.approx(1.1 * 0.024, rel=0.03)


def test_a_pillow_is_stretched_little_and_lies_on_its_wedge():
    sewn, rest = pillow.pillow(16)
    strain = np.abs(stretches(panels.body_of(sewn, pillow.CLOTH), rest) - 1)
    assert strain.mean() < 0.015
    assert np.quantile(strain, 0.95) < 0.06
    assert rest[:, 1].min() > 0.0015
    points, faces = pillow.wedge()
    a, b, c, _ = points[list(faces[0])]
    up = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
    over = (rest[:, 0] > a[0]) & (rest[:, 0] < b[0]) & (rest[:, 2] > c[2]) & (rest[:, 2] < a[2])
    assert ((rest[over] - a) @ up).min() > -0.001


def test_folds_of_a_skirt_keep_apart():
    cells = 12
    sewn, rest = skirt.skirt(cells)
    apart = np.pi * (skirt.WAIST + skirt.LENGTH) / skirt.GORES / cells
    gap = np.linalg.norm(rest[:, None] - rest, axis=2)
    far = np.linalg.norm(sewn.start[:, None] - sewn.start, axis=2) > 2 * apart
    assert gap[far].min() > 0.8 * apart


def test_a_sewn_box_has_no_open_edge():
    sewn = panels.sew(
        cushions.box_panels(cushions.Box.of((0, 0, 0), (1, 1, 1)), np.array((4,) * 3))
    )
    edges = np.concatenate([sewn.quads[:, [k, (k + 1) % 4]] for k in range(4)])
    forward = {tuple(e) for e in edges.tolist()}
    assert len(forward) == len(edges)
    assert all((b, a) in forward for a, b in forward)
    assert len(sewn.start) - len(edges) // 2 + len(sewn.quads) == 2  # Euler


def test_a_finer_cloth_starts_where_the_coarser_ended():
    coarse, fine = (panels.sew(pillow.covers(n)) for n in (4, 8))
    moved = coarse.start + np.sin(7 * coarse.start)
    start = panels.refined(coarse, moved, fine)
    for mine, theirs in zip(coarse.ids, fine.ids, strict=True):
        assert np.array_equal(start[theirs[::2, ::2]], moved[mine])


def test_a_cut_that_is_turned_over_is_refused():
    mirrored = panels.plane(2, 2, lambda r, u: [-r, u, r, u, 0 * r])
    with pytest.raises(ValueError, match="turned over"):
        panels.body_of(panels.sew([mirrored]), CLOTH)
