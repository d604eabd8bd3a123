"""What stands where in each of the example stages, and the cameras that look at it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import author
import numpy as np
import pillow
import rooms
import skirt
import sofa
import swatch
from drape import BALL_CENTER, BALL_RADIUS
from pxr import Gf, UsdGeom, UsdLux

if TYPE_CHECKING:
    from pxr import Usd


def cornell_pillow(stage: Usd.Stage) -> None:
    """The pillow in a Cornell box."""
    rooms.cornell_box(stage)
    _pillow(stage)


def pillow_under_sky(stage: Usd.Stage) -> None:
    """The pillow in the open."""
    rooms.ground(stage)
    author.add_camera(stage, "Camera", (0.10, 0.40, 1.25), (0, 0.125, 0.0), 0.56)
    _pillow(stage)


def cornell_skirt(stage: Usd.Stage) -> None:
    """The skirt in a Cornell box."""
    rooms.cornell_box(stage)
    _skirt(stage)


def skirt_under_sky(stage: Usd.Stage) -> None:
    """The skirt in the open."""
    rooms.ground(stage)
    author.add_camera(stage, "Camera", (0.0, 0.33, 1.35), (0, 0.225, 0.0), 0.54)
    _skirt(stage)


def sofa_in_studio(stage: Usd.Stage) -> None:
    """The sofa in a studio."""
    rooms.studio(stage)
    author.add_look(stage, "Wood", author.WOOD)
    author.add_component(stage, "Sofa", "sofa.geometry.usdc")
    legs = author.add_group(stage, "Legs")
    profile = [(0.0, 0.0), (0.014, 0.0), (0.024, sofa.FOOT), (0.024, sofa.FOOT + 0.02)]
    inset = 0.07
    for name, x, z in (
        ("FrontLeft", -sofa.OUTER + inset, sofa.FRONT - inset),
        ("FrontRight", sofa.OUTER - inset, sofa.FRONT - inset),
        ("RearLeft", -sofa.OUTER + inset, sofa.REAR + inset),
        ("RearRight", sofa.OUTER - inset, sofa.REAR + inset),
    ):
        author.add_lathe(stage, f"{legs}/{name}", profile, "Wood", (x, z))
    author.add_camera(stage, "Camera", (1.5, 1.25, 4.0), (0.0, 0.42, 0.0), 2.15, 1.5)
    author.add_camera(stage, "Detail", (0.42, 0.86, 1.05), (0.60, 0.50, 0.36), 0.30, 1.5)


def flat_swatch(stage: Usd.Stage) -> None:
    """The swatch on a table, from above, with its rule and chips."""
    author.add_look(stage, "Table", (0.07, 0.07, 0.075))
    author.add_look(stage, "Rule", (0.75, 0.74, 0.70))
    author.add_look(stage, "Ink", (0.02, 0.02, 0.02))
    author.add_component(stage, "Swatch", "swatch.geometry.usdc")
    scale = author.add_group(stage, "Scale")
    for name, (points, quads) in swatch.rule().items():
        author.add_mesh(stage, f"{scale}/{name}", points, quads, "Ink" if name == "Marks" else name)
    chips = author.add_group(stage, "Chips")
    for name, (points, quads) in swatch.chips().items():
        author.add_look(stage, name, (swatch.CHIPS[name],) * 3)
        author.add_mesh(stage, f"{chips}/{name}", points, quads, name)
    reach = 2.0
    table = np.array([(-reach, 0, reach), (reach, 0, reach), (reach, 0, -reach),
                      (-reach, 0, -reach)])  # fmt: skip
    author.add_mesh(stage, "/World/Table", table, [(0, 1, 2, 3)], "Table")
    author.add_panel_light(
        stage, "KeyLight", (-0.30, 0.36, -0.22), (0, 0, 0), (0.16, 0.16), 17.0, (1, 1, 1)
    )
    dome = UsdLux.DomeLight.Define(stage, "/World/Sky")
    dome.CreateIntensityAttr(0.25)
    author.add_camera(stage, "Camera", (0, 0.30, 0.0005), (0, 0, 0), 0.078)
    author.add_camera(stage, "Detail", (0.004, 0.030, 0.034), (0.0, 0.0006, 0.004), 0.012)


def cornell_drape(stage: Usd.Stage) -> None:
    """The small square over its ball, in a Cornell box of 8 cm."""
    rooms.cornell_box(stage, side=0.08)
    author.add_component(stage, "Drape", "cornell_drape.geometry.usdc")
    x, y, z = (v / author.CENTIMETRE for v in BALL_CENTER)
    radius = BALL_RADIUS / author.CENTIMETRE
    stand = author.add_group(stage, "Stand")
    ball = UsdGeom.Sphere.Define(stage, f"{stand}/Ball")
    ball.CreateRadiusAttr(radius)
    ball.CreateExtentAttr([Gf.Vec3f(-radius), Gf.Vec3f(radius)])
    ball.AddTranslateOp().Set((x, y, z))
    author.bind_look(ball.GetPrim(), "White")
    foot = y - 0.8 * radius
    author.add_lathe(
        stage, f"{stand}/Foot", [(0.0045, 0), (0.0045, foot * author.CENTIMETRE)], "White",
        (BALL_CENTER[0], BALL_CENTER[2]),
    )  # fmt: skip


def sky_sphere(stage: Usd.Stage) -> None:
    """A ball of 3 cm on a plane, under a clear sky with a sun."""
    rooms.ground(stage, "sky.exr", reach=2.0, exposure=0.0)
    author.add_component(stage, "Ball", "sky_sphere.geometry.usdc")
    sun = UsdLux.DistantLight.Define(stage, "/World/Sun")
    sun.CreateIntensityAttr(2.2)
    sun.CreateColorAttr(Gf.Vec3f(1.0, 0.94, 0.85))
    sun.CreateAngleAttr(0.0)
    sun.AddRotateYOp().Set(38.0)
    sun.AddRotateXOp().Set(-42.0)
    author.add_camera(stage, "Camera", (0.0, 0.0175, 0.12), (0.0, 0.015, 0.0), 0.042)


SCENES: dict[str, Callable[[Usd.Stage], None]] = {
    "cornell_drape": cornell_drape,
    "pillow": cornell_pillow,
    "pillow_sky": pillow_under_sky,
    "skirt": cornell_skirt,
    "skirt_sky": skirt_under_sky,
    "sky_sphere": sky_sphere,
    "sofa": sofa_in_studio,
    "swatch": flat_swatch,
}


def _pillow(stage: Usd.Stage) -> None:
    """Add the pillow, its wedge and a camera close to a corner."""
    author.add_component(stage, "Pillow", "pillow.geometry.usdc")
    points, faces = pillow.wedge()
    group = author.add_group(stage, "Wedge")
    for path in ("/World/Pillow", group):
        form = UsdGeom.Xform.Get(stage, path)
        form.AddTranslateOp().Set((0.0, 0.0, -5.0))
        form.AddRotateYOp().Set(-20.0)
    author.add_camera(stage, "Detail", (0.16, 0.44, 0.17), (0.165, 0.222, -0.085), 0.10)
    for name, quad in zip(("Slope", "Rear", "Bottom", "Left", "Right"), faces, strict=True):
        author.add_mesh(stage, f"{group}/{name}", points, [quad], "White")


def _skirt(stage: Usd.Stage) -> None:
    """Add the skirt on its dress form."""
    author.add_component(stage, "Skirt", "skirt.geometry.usdc")
    author.add_component(stage, "DressForm", "skirt.form.usdc", "White")
    author.add_camera(stage, "Detail", (0.12, 0.47, 0.33), (0.02, 0.335, 0.066), 0.022)
    author.add_look(stage, "Wood", author.WOOD)
    stand = author.add_group(stage, "Stand")
    foot = [
        (0.085, 0.0),
        (0.085, 0.006),
        (0.012, 0.014),
        (0.008, 0.03),
        (0.008, skirt.HEIGHT - 0.15),
    ]
    author.add_lathe(stage, f"{stand}/Foot", foot, "Wood")
