"""Every example scene in a cloth that suits it, as a folder of pictures.

python examples/gallery.py FOLDER [--width 640] [--spp 128] [SCENE …]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import weaveusd
from weaveusd.draft.make import make_draft
from weaveusd.draft.write import write_wif
from weaveusd.errors import WeaveusdError
from weaveusd.render.scenes import dress, scene_names, scene_path
from weaveusd.yarn.recipe import read_preset

SHOTS = (
    # scene, camera, fabric
    ("pillow", "Camera", "linen_plain"),
    ("pillow", "Detail", "linen_plain"),
    ("pillow_sky", "Camera", "linen_plain"),
    ("skirt", "Camera", "shot_silk"),
    ("skirt", "Detail", "shot_silk"),
    ("skirt_sky", "Camera", "shot_silk"),
    ("sofa", "Camera", "herringbone"),
    ("sofa", "Detail", "herringbone"),
    ("swatch", "Camera", "linen_plain"),
    ("swatch", "Detail", "denim"),
    ("cornell_drape", "Camera", "houndstooth"),
    ("sky_sphere", "Camera", "charmeuse"),
)

PATCH_MM = (24.0, 24.0)
"""Cloth in one texture, so that slubs and tones do not repeat within a close view."""


def main(folder: Path, scenes: list[str], width: int, spp: int) -> None:
    """Publish the fabrics of `SHOTS` below `folder` and render those of `scenes`."""
    (folder / "drafts").mkdir(parents=True, exist_ok=True)
    for scene, camera, fabric in SHOTS:
        if scene not in scenes:
            continue
        draft = folder / "drafts" / f"{fabric}.wif"
        draft.write_bytes(write_wif(make_draft(read_preset(fabric).weave or "plain")))
        done = weaveusd.publish(
            draft, preset=fabric, name=fabric, root=folder / "assets", patch_mm=PATCH_MM
        )
        stage = dress(scene_path(scene), done.asset.entry, folder / f"{scene}_{fabric}.usda")
        picture = folder / f"{scene}_{fabric}{'' if camera == 'Camera' else '_detail'}.png"
        result = weaveusd.render(stage, picture, camera=f"/World/{camera}", width=width, spp=spp)
        print(f"{picture}: {result.seconds:.0f} s", *result.losses, sep="\n  ", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="by default all")
    parser.add_argument("--width", type=int, default=640, help="pixels")
    parser.add_argument("--spp", type=int, default=128, help="samples a pixel")
    given = parser.parse_args()
    for name in given.scenes:
        if name not in scene_names():
            parser.error(f"no scene {name!r}: expected {', '.join(scene_names())}")
    try:
        main(given.folder, given.scenes or scene_names(), given.width, given.spp)
    except WeaveusdError as error:
        sys.exit(f"gallery: {error}")
