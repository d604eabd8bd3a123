"""What the usdview plugin shows, and that usdview would find it; only its window is untested."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdShade

from tests.export.cloths import cloth
from weaveusd import pipeline
from weaveusd.draft.picture import draft_picture
from weaveusd.draft.wif import read_wif
from weaveusd.export.asset import write_asset
from weaveusd.stage import open_stage
from weaveusd.usdview.card import card_html, card_text, cloth_card, find_cloth
from weaveusd.usdview.drawing import SIDE, draw_draft

ROOT = Path(__file__).resolve().parents[1]
TWILL = ROOT / "examples" / "drafts" / "twill_2_2.wif"


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("asset")
    write_asset(cloth(title="Plain <b>weave</b>"), path)
    (path / "draft.wif").write_bytes(TWILL.read_bytes())
    return path


@pytest.fixture
def stage(folder) -> Usd.Stage:
    """A stage that wears the cloth: a mesh with a subset, and one without a cloth."""
    stage = open_stage(folder / "plain.usda")
    stage.SetEditTarget(stage.GetSessionLayer())
    material = UsdShade.Material(stage.GetPrimAtPath("/plain/Material"))
    mesh = UsdGeom.Mesh.Define(stage, "/World/Skirt")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
    UsdGeom.Subset.Define(stage, "/World/Skirt/hem")
    UsdGeom.Mesh.Define(stage, "/World/Floor")
    return stage


@pytest.mark.parametrize(
    "path",
    ["/plain/Material", "/plain/Material/PreviewSurface", "/plain", "/World/Skirt",
     "/World/Skirt/hem"],
)  # fmt: skip
def test_a_cloth_is_found_from_whatever_is_about_it(stage, path):
    assert find_cloth(stage.GetPrimAtPath(path)).GetPath() == "/plain/Material"


def test_no_cloth_is_found_where_there_is_none(stage):
    assert not find_cloth(stage.GetPrimAtPath("/World/Floor"))


def test_the_card_says_size_yarns_and_origin(stage):
    text = card_text(cloth_card(stage.GetPrimAtPath("/plain/Material")))
    for said in (
        "0.8 × 1 mm", "25 × 20", "Shafts", "66", "500 Z", "0.3 × 0.18", "linen", "made by hand",
        "0" * 64, "g/m²",
    ):  # fmt: skip
        assert said in text, said
    assert [line for line in text.splitlines() if line.startswith(("1   warp", "2   weft"))]


def test_text_of_an_asset_is_never_markup(stage):
    html = card_html(cloth_card(stage.GetPrimAtPath("/plain/Material")))
    assert "Plain &lt;b&gt;weave&lt;/b&gt;" in html
    assert "<b>" not in html


def test_attributes_of_other_types_and_none_at_all_do_no_harm(tmp_path):
    layer = tmp_path / "look.usda"
    start = '#usda 1.0\ndef Material "Cloth" (prepend apiSchemas = ["WeaveClothAPI"]) {\n'
    layer.write_text(start + "}\n")
    assert cloth_card(open_stage(layer).GetPrimAtPath("/Cloth")).sections == ()
    layer = tmp_path / "other.usda"
    layer.write_text(
        start
        + f"""
        int weave:yarns = 7
        string weave:draft = "/etc/passwd"
        string weave:ends = "{"many " * 10_000}"
        float3 weave:picks = (1, 2, 3)
        string weave:recipe = "a\\nb"
        }}
        """
    )
    stage = open_stage(layer)
    card = cloth_card(stage.GetPrimAtPath("/Cloth"))
    assert card.draft == ""
    assert len(card_text(card)) < 1000
    assert "a b" in card_text(card)


def test_the_drawing_is_the_draft_as_weavers_draw_it(stage):
    drawing = draw_draft(cloth_card(stage.GetPrimAtPath("/plain/Material")).draft)
    assert drawing.reason == ""
    pixels = np.frombuffer(drawing.pixels, np.uint8).reshape(drawing.height, drawing.width, 3)
    assert np.array_equal(pixels, draft_picture(read_wif(TWILL), 12))
    assert max(drawing.width, drawing.height) <= SIDE


def test_a_draft_that_cannot_be_drawn_says_why(tmp_path):
    assert "no draft" in draw_draft("").reason
    assert "no such file" in draw_draft(str(tmp_path / "gone.wif")).reason
    broken = tmp_path / "broken.wif"
    broken.write_text("[WIF]\n")
    reason = draw_draft(str(broken)).reason
    assert reason.startswith(str(broken))
    assert "\n" not in reason


USDVIEW = '''
"""Stands in for usdview: its plugin classes, and how it loads plugins."""
import json, sys, types
ROOT = sys.argv[1]
sys.path = [p for p in sys.path if p not in ("", ROOT)]
import pxr
from pxr import Plug, Tf, Usd

class PluginContainer:
    def registerPlugins(self, plugRegistry, plugCtx): raise NotImplementedError
    def configureView(self, plugRegistry, plugUIBuilder): raise NotImplementedError

viewer = types.ModuleType("pxr.Usdviewq"); viewer.__path__ = []
plugin = types.ModuleType("pxr.Usdviewq.plugin"); plugin.PluginContainer = PluginContainer
PluginContainer.__module__ = "pxr.Usdviewq.plugin"
sys.modules.update({"pxr.Usdviewq": viewer, "pxr.Usdviewq.plugin": plugin})
base = Tf.Type.Define(PluginContainer)

said, menus, commands = [], {}, {}

class Command:
    def __init__(self, name, displayName, callback, description=""):
        self.name, self.displayName, self.callback = name, displayName, callback

class Registry:
    def registerCommandPlugin(self, *arguments):
        command = Command(*arguments)
        commands[command.name] = command
        return command

class Menu:
    def __init__(self, name): self.name = name
    def addItem(self, command): menus.setdefault(self.name, []).append(command.displayName)

class Builder:
    def findOrCreateMenu(self, name): return Menu(name)

shown = []
window = types.ModuleType("weaveusd.usdview.window")
window.show_card = lambda card, drawing, parent: shown.append([card.title, drawing.width, parent])

class Api:
    stage = Usd.Stage.Open(sys.argv[2])
    selectedPrims = []
    qMainWindow = "main window"
    def PrintStatus(self, message): said.append(message)

names = []
for found in Plug.Registry.GetAllDerivedTypes(base):
    owner = Plug.Registry().GetPluginForType(found)
    owner.Load()
    names.append([owner.name, found.typeName])
    container = found.pythonClass()
    registry = Registry()
    container.registerPlugins(registry, Api())
    container.configureView(registry, Builder())
sys.modules["weaveusd.usdview.window"] = window
api = Api()
for command in commands.values():
    command.callback(api)
    api.selectedPrims = [api.stage.GetPseudoRoot(), api.stage.GetPrimAtPath("/plain")]
    command.callback(api)
schema = api.stage.GetPrimAtPath("/plain/Material").HasAPI("WeaveClothAPI")
json.dump([names, menus, said, shown, schema, ROOT in sys.path], sys.stdout)
'''


def test_usdview_finds_the_plugin_by_the_environment_alone(folder, tmp_path):
    script = tmp_path / "usdview.py"
    script.write_text(USDVIEW)
    done = subprocess.run(
        [sys.executable, script, str(ROOT), str(folder / "plain.usda")],
        capture_output=True, text=True, cwd="/", env={**os.environ, **pipeline.environment()},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    names, menus, said, shown, schema, on_path = json.loads(done.stdout)
    assert names == [["weaveusd_usdview", "weaveusd.usdview.plugin.ClothContainer"]]
    assert menus == {"weaveusd": ["Cloth of the selection …"]}
    assert said == ["weaveusd: no woven cloth is selected; select its material or what wears it"]
    assert shown == [["Plain <b>weave</b>", 132, "main window"]]
    assert schema
    assert not on_path
    assert done.stderr == ""


def test_pythonpath_holds_nothing_that_could_hide_what_usdview_has():
    found = Path(pipeline.environment()["PYTHONPATH"])
    assert [p.name for p in found.iterdir() if p.name != "__pycache__"] == ["weaveusd_usdview.py"]
