"""The whole road once: two drafts become assets, and the assets pictures.

python examples/demo.py FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

import weaveusd
from weaveusd.errors import WeaveusdError
from weaveusd.render.scenes import dress, scene_path

DRAFTS = Path(__file__).parent / "drafts"

SHOTS = (
    # draft, preset, scene
    ("houndstooth.wif", "wool", "cornell_drape"),
    ("satin_5.wif", "silk", "sky_sphere"),
)


def main(folder: Path) -> None:
    """Publish the drafts of `SHOTS` below `folder`, render them, and say where to look."""
    pictures = []
    for draft, preset, scene in SHOTS:
        done = weaveusd.publish(DRAFTS / draft, preset=preset, root=folder / "assets")
        print(f"{done.asset.status} {done.asset.entry} in {done.seconds:.1f} s")
        stage = dress(scene_path(scene), done.asset.entry, folder / f"{scene}.usda")
        picture = folder / f"{scene}_{Path(draft).stem}_{preset}.png"
        print(f"rendering {scene} …", flush=True)
        result = weaveusd.render(stage, picture, width=640, height=640, spp=64)
        print(f"  {result.seconds:.0f} s, {result.variant}")
        pictures.append(picture)
    print("\nLook at", *(f"  {p.resolve()}" for p in pictures), sep="\n")


if __name__ == "__main__":
    try:
        main(Path(sys.argv[1] if len(sys.argv) > 1 else "out/demo"))
    except WeaveusdError as error:
        sys.exit(f"demo: {error}")
