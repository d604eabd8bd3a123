from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pxr import UsdLux

from tests.render.lights.lamps import card, irradiance, put, shaped
from weaveusd.errors import StageError
from weaveusd.render.lights import ies

VERTICAL = (0, 30, 60, 90)


def text(
    vertical: Any = VERTICAL, horizontal: Any = (0,), candela: Any = ((100, 80, 40, 0),), *,
    multiplier: float = 1, ballast: float = 1, tilt: str = "TILT=NONE", photometry: int = 1,
) -> str:  # fmt: skip
    lists = (vertical, horizontal, *candela)
    rows = "\n".join(" ".join(map(str, row)) for row in lists)
    return (
        f"IESNA:LM-63-1995\n[TEST] made for a test\n{tilt}\n"
        f"1 1000 {multiplier} {len(vertical)} {len(horizontal)} {photometry} 2 0.1 0.1 0\n"
        f"{ballast} 1 60\n{rows}\n"
    )


def lamp(tmp_path: Path, file: str, turn: Any = (0, 0, 0), **shaping: Any) -> tuple[Any, float]:
    """A card under a small sphere with a profile, and what the sphere alone would give."""
    (tmp_path / "lamp.ies").write_text(file)
    stage = card(tmp_path)
    light = UsdLux.SphereLight.Define(stage, "/World/Light")
    light.CreateRadiusAttr(0.02)
    put(light, at=(0, 0, 4), turn=turn)
    shaped(light, ies_file="./lamp.ies", cone_angle=180.0, **shaping)
    return stage, np.pi * (0.02 / 4) ** 2


@pytest.mark.parametrize(("degrees", "candela"), [(0, 100), (30, 80), (45, 60), (75, 20), (120, 0)])
def test_radiance_is_multiplied_by_the_intensity_between_two_angles(
    mi: Any, tmp_path: Path, degrees: float, candela: float
) -> None:
    stage, plain = lamp(tmp_path, text(), turn=(0, degrees, 0))
    found, losses = irradiance(stage, 256)
    assert found == pytest.approx(candela * plain, rel=0.01, abs=1e-9)
    assert losses == []


@pytest.mark.parametrize(("about", "candela"), [(0, 10), (45, 15), (90, 20), (180, 30), (270, 20)])
def test_the_angle_about_the_axis_starts_at_minus_x_and_grows_towards_minus_y(
    mi: Any, tmp_path: Path, about: float, candela: float
) -> None:
    """Bilateral: 0 to 180 degrees are listed and mirrored."""
    file = text((0, 90), (0, 90, 180), ((10, 10), (20, 20), (30, 30)))
    stage, plain = lamp(tmp_path, file)
    # Light that reaches the card leaves 45 degrees off the axis towards -x, turned by `about`.
    light = UsdLux.SphereLight(stage.GetPrimAtPath("/World/Light"))
    light.ClearXformOpOrder()
    light.AddTranslateOp(opSuffix="up").Set((0.0, 0.0, 4.0))
    light.AddRotateYOp(opSuffix="tip").Set(-45.0)
    light.AddRotateZOp(opSuffix="about").Set(-float(about))
    toward = np.array(light.ComputeLocalToWorldTransform(0)).T[:3, :3].T @ (0, 0, -1.0)
    phi = np.degrees(np.arctan2(-toward[1], -toward[0])) % 360
    assert phi == pytest.approx(about, abs=1e-3)
    assert irradiance(stage, 256)[0] == pytest.approx(candela * plain, rel=0.01)


def test_an_angle_scale_widens_the_beam_from_its_axis(mi: Any, tmp_path: Path) -> None:
    """θ_ies = θ / s where s > 0."""
    stage, plain = lamp(tmp_path, text(), turn=(0, 30, 0), ies_scale=0.5)
    assert irradiance(stage, 256)[0] == pytest.approx(40 * plain, rel=0.01)


def test_an_angle_scale_below_zero_starts_behind() -> None:
    """θ_ies = (θ - π) / -s + π where s < 0."""
    profile = ies.parse(text((90, 120, 180), (0,), ((0, 30, 90),)))
    table = ies.sampled(profile, -0.5, normalize=False)
    # 150 degrees: (150 - 180) / 0.5 + 180 = 120.
    assert table[300, 0] == pytest.approx(30)


def test_a_normalized_profile_has_the_mean_one(mi: Any, tmp_path: Path) -> None:
    """A lamp of one intensity below the horizon is divided by it: its mean over that half."""
    stage, plain = lamp(tmp_path, text((0, 90), (0,), ((50, 50),)), ies_normalize=True)
    assert irradiance(stage, 256)[0] == pytest.approx(plain, rel=0.01)
    whole = ies.parse(text((0, 90, 180), (0, 90), ((1, 2, 1), (3, 4, 3))))
    table = ies.sampled(whole, 0, normalize=True).astype(float)
    theta = np.linspace(0, np.pi, ies.STEPS_OFF)
    rows = (table[:, 1:] + table[:, :-1]).mean(axis=1) / 2
    mean = np.trapezoid(rows * np.sin(theta), theta) / 2
    assert mean == pytest.approx(1, rel=1e-3)


def test_factors_of_the_file_multiply() -> None:
    profile = ies.parse(text(multiplier=2, ballast=0.5))
    assert profile.candela.tolist() == [[100, 80, 40, 0]]
    assert ies.parse(text(multiplier=3)).candela[0, 0] == 300


def test_a_quarter_and_a_half_are_mirrored_to_a_whole_turn() -> None:
    quarter = ies.parse(text((0, 90), (0, 90), ((1, 1), (2, 2))))
    assert quarter.horizontal_deg.tolist() == [0, 90, 180, 270, 360]
    assert quarter.candela[:, 0].tolist() == [1, 2, 1, 2, 1]
    turned = ies.parse(text((0, 90), (90, 180, 270), ((1, 1), (2, 2), (3, 3))))
    table = ies.sampled(turned, 0, normalize=False)
    at = {degree: table[0, 2 * degree] for degree in (0, 45, 90, 180, 270, 360)}
    assert at == {0: 2, 45: 1.5, 90: 1, 180: 2, 270: 3, 360: 2}


def test_a_tilt_table_is_stepped_over() -> None:
    tilted = text(tilt="TILT=INCLUDE\n1\n3\n0 45 90\n1 0.9 0.8")
    assert ies.parse(tilted).candela.tolist() == [[100, 80, 40, 0]]


@pytest.mark.parametrize(
    ("file", "said"),
    [
        ("", "lacks the line TILT="),
        (text(tilt="TILT=other.tlt"), "has TILT=other.tlt, expected NONE or INCLUDE"),
        (text(photometry=2), "has photometry of type 2, expected 1"),
        (text((0, 30, 20, 90)), "vertical angles that do not rise"),
        (text((0, 90, 200, 300)), "vertical angles that do not rise from 0 to 180"),
        (text(horizontal=(0, 45), candela=((1,) * 4, (1,) * 4)), "horizontal angles 0 to 45"),
        (text(candela=((100, 80, 40),)), "ends within its candela"),
        (text(candela=((100, 80, 40, "x"),)), "has 'x' in its candela, expected a number"),
        (text(candela=((100, 80, 40, "nan"),)), "no finite number"),
        (text(candela=((100, 80, 40, -1),)), "has a negative intensity"),
        ("TILT=NONE\n1 1 1 1e9 1e9 1 1 0 0 0", "vertical angles, expected a whole number"),
        ("TILT=NONE\n1 1 1 9999 9999 1 1 0 0 0", "has 9999 x 9999 angles"),
    ],
)
def test_a_broken_file_says_in_one_line_what_is_wrong(file: str, said: str) -> None:
    with pytest.raises(ValueError, match=r"^[^\n]*$") as caught:
        ies.parse(file)
    assert said in str(caught.value)


@settings(max_examples=200, deadline=None)
@given(st.lists(st.sampled_from(["TILT=NONE\n", "1", "0", "2", "1e9", "-3", "90", "x", "nan"])))
def test_whatever_follows_the_tilt_is_a_profile_or_one_line(words: list[str]) -> None:
    said = ""
    try:
        ies.parse("TILT=NONE\n" + " ".join(words))
    except ValueError as error:
        said = str(error)
    assert "\n" not in said


def test_a_file_too_large_is_not_read(tmp_path: Path) -> None:
    file = tmp_path / "huge.ies"
    with file.open("wb") as out:
        out.truncate(ies.MAX_BYTES + 1)
    with pytest.raises(StageError, match="bytes, at most"):
        ies.read_profile(str(file), "/Light")


def test_an_empty_file_is_no_profile(tmp_path: Path) -> None:
    (tmp_path / "empty.ies").touch()
    with pytest.raises(StageError, match="lacks the line TILT="):
        ies.read_profile(str(tmp_path / "empty.ies"), "/Light")


def test_a_pipe_is_not_waited_for(mi: Any, tmp_path: Path) -> None:
    stage, _ = lamp(tmp_path, text())
    (tmp_path / "lamp.ies").unlink()
    os.mkfifo(tmp_path / "lamp.ies")
    _, losses = irradiance(stage, 1)
    where = "/World/Light.inputs:shaping:ies:file"
    assert losses == [f"/World/Light: {where}: ./lamp.ies is no regular file (dropped)"]


def test_a_broken_profile_leaves_the_lamp_its_light(mi: Any, tmp_path: Path) -> None:
    stage, plain = lamp(tmp_path, "no lamp")
    found, losses = irradiance(stage, 256)
    assert found == pytest.approx(plain, rel=0.01)
    assert len(losses) == 1
    assert "lamp.ies: is no IES file" in losses[0]
