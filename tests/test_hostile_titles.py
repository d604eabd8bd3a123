"""Two hundred titles that want out of the root, or into USD: none of them does."""

from __future__ import annotations

import itertools
import os
import re
from pathlib import Path

import pytest
from pxr import Sdf

from weaveusd import pipeline
from weaveusd.draft.wif import read_wif
from weaveusd.export.names import safe_name
from weaveusd.export.publish import publish_asset
from weaveusd.validate.verify import verify

ROOT = Path(__file__).parents[1]
PLAIN = ROOT / "examples" / "drafts" / "plain.wif"

WANTED = (
    "../escape", "..", "/etc/passwd", "~/x", "~root", "a/../../b", "..\\..\\x", "C:\\x", "\\\\h\\s",
    "@../x.usda@", '"""', "'''", '"', "</Material>", "{}", "$(touch x)", "`touch x`", "; rm x",
    "%n", "$HOME", "%PATH%", "CON", "nul.usda", "COM1", "-rf", "--root=/", "\u202egnp", "x" * 300,
    "é" * 300, "織物", "\u200b", ".", ".hidden", "look", "textures", "manifest.json", "v001",
    ".publish.lock", "{{Param.Root}}", "#usda 1.0",
)  # fmt: skip
AROUND = ("{}", "{}/", "a {} b", "{}\t{}", "../{}")
TITLES = [shape.format(title, title) for title, shape in itertools.product(WANTED, AROUND)]


def test_there_are_two_hundred():
    assert len(TITLES) == len(set(TITLES)) == 200


def outside(folder: Path) -> set[str]:
    """Return everything below `folder` that is not below its `root`."""
    found = {p.relative_to(folder).as_posix() for p in folder.rglob("*")}
    return {path for path in found if path.split("/")[0] != "root"}


def test_no_name_asked_for_leads_out_of_the_root(tmp_path):
    root = tmp_path / "deep" / "root"
    for title in TITLES:
        name = safe_name(title)

        def write(folder: Path, name: str = name) -> None:
            (folder / f"{name}.usda").write_text("#usda 1.0\n")

        asset = publish_asset(root, name, write)
        assert asset.folder.parent.parent == root
        assert asset.entry.is_file()
    assert outside(tmp_path / "deep") == set()
    assert os.listdir(tmp_path) == ["deep"]
    for home in root.iterdir():
        assert re.fullmatch(r"[A-Za-z]\w{0,63}", home.name, re.ASCII)


def publish_titled(title: str, folder: Path) -> None:
    """Publish a draft that is called `title` in every way, into ``root`` below `folder`."""
    draft = folder / "draft.wif"
    text = re.sub(r"Title=.*", "", PLAIN.read_text()).replace("[TEXT]", f"[TEXT]\nTitle={title}")
    draft.write_text(text, encoding="utf-8")
    assert title.split() == read_wif(draft).title.split()
    done = pipeline.publish(
        draft, preset="linen", root=folder / "root", name=title, resolution=8, jobs=1
    )
    assert outside(folder) == {"draft.wif"}
    assert verify(done.asset.entry).intact
    layers = [Sdf.Layer.FindOrOpen(str(path)) for path in done.asset.folder.glob("*.usda")]
    assert [[prim.name for prim in layer.rootPrims] for layer in layers] == [[done.asset.asset]] * 2
    path = f"{done.asset.material}.weave:draftTitle"
    (said,) = [spec.default for layer in layers if (spec := layer.GetAttributeAtPath(path))]
    plain = "".join(c if c.isprintable() else " " for c in title)
    assert said[:200].split() == plain[:200].split()


@pytest.mark.parametrize("title", ["../escape", '"""', "@../x.usda@", "\u202egnp", "$(touch x)"])
def test_a_hostile_title_is_only_ever_text(title, tmp_path):
    publish_titled(title, tmp_path)


@pytest.mark.slow
def test_every_hostile_title_is_only_ever_text(tmp_path):
    for number, title in enumerate(TITLES):
        (tmp_path / str(number)).mkdir()
        publish_titled(title, tmp_path / str(number))
