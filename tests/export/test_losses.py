"""Every network says what it carries of the exact cloth, with the error that was measured."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

import weaveusd
from tests.export.cloths import FIT, FITS, cloth
from weaveusd.export import losses
from weaveusd.export.losses import losses_as_json, losses_of

TWILL = Path(__file__).resolve().parents[2] / "examples" / "drafts" / "twill_2_2.wif"


def effects(material, network, also=()):
    (found,) = (n for n in losses_of(material, also) if n.network == network)
    return {effect.effect: effect for effect in found.effects}


def with_optics(**changes):
    material = cloth()
    first, *rest = material.weave.yarns
    yarns = (replace(first, optics=replace(first.optics, **changes)), *rest)
    return replace(material, weave=replace(material.weave, yarns=yarns))


def test_each_standard_network_states_its_own_error():
    errors = FITS.errors
    for network, error in [
        ("openpbr", errors.openpbr),
        ("standard_surface", errors.standard_surface),
        ("preview", errors.preview),
    ]:
        found = effects(cloth(), network)[losses.REFLECTANCE]
        assert (found.fate, found.error) == ("approximated", error)
        assert found.how


def test_only_the_exact_network_carries_everything():
    material = with_optics(eta=1.4)
    exact = effects(material, "mitsuba")
    for network in ("openpbr", "standard_surface", "preview"):
        assert effects(material, network).keys() == exact.keys()
    assert {e.fate for name, e in exact.items() if name != losses.COLOR} == {"carried"}
    assert effects(material, "preview")[losses.DIRECTION].fate == "dropped"
    assert effects(material, "openpbr")[losses.DIRECTION].fate == "carried"
    assert effects(material, "openpbr")[losses.OPTICS].fate == "approximated"
    assert effects(material, "preview")[losses.OPTICS].fate == "approximated"
    assert effects(material, "standard_surface")[losses.OPTICS].fate == "dropped"


def test_networks_with_lobe_maps_state_the_error_of_the_tile_as_one_texel():
    errors = FITS.errors
    for network, error in [("openpbr", errors.openpbr_afar), ("preview", errors.preview_afar)]:
        found = effects(cloth(), network)[losses.AFAR]
        assert (found.fate, found.error) == ("approximated", error)
    assert effects(cloth(), "standard_surface")[losses.AFAR].fate == "dropped"


def test_effects_that_a_cloth_lacks_are_not_listed():
    material = cloth()
    yarns = tuple(replace(y, optics=replace(y.optics, tau=0.0)) for y in material.weave.yarns)
    opaque = replace(material, weave=replace(material.weave, yarns=yarns))
    assert losses.TRANSMISSION not in effects(opaque, "mitsuba")
    assert losses.TRANSMISSION not in effects(opaque, "preview")
    assert effects(material, "preview")[losses.TRANSMISSION].how.startswith("up to 10%")
    assert losses.GAMUT not in effects(material, "preview")
    wide = replace(material, weave=replace(material.weave, color_space="acescg"))
    assert effects(wide, "preview")[losses.GAMUT].fate == "approximated"


def test_colors_out_of_reach_and_a_lighter_base_are_told():
    material = cloth()
    assert "2 of 2 yarns" in effects(material, "mitsuba")[losses.COLOR].how
    reached = tuple(
        m._replace(reached=y.color)
        for m, y in zip(material.measured, material.weave.yarns, strict=True)
    )
    assert effects(replace(material, measured=reached), "mitsuba")[losses.COLOR].fate == "carried"
    pale = replace(material, fits=replace(FITS, isotropic=replace(FIT, base=0.6)))
    assert "60%" in effects(pale, "preview")[losses.COLOR].how
    assert effects(pale, "openpbr")[losses.COLOR].fate == "carried"


@pytest.mark.parametrize("network", ["exact", "glslfx", "gltf", "u3m"])
def test_networks_on_request_are_reported_where_they_are(network):
    names = [n.network for n in losses_of(cloth())]
    assert network not in names
    assert [n.network for n in losses_of(cloth(), [network])] == [*names, network]


def test_of_a_colorway_only_what_it_loses_otherwise_is_told():
    opaque = with_optics(tau=0.2)
    found = losses.differing(losses_of(opaque), losses_of(cloth()))
    assert set(found) == {"mitsuba", "openpbr", "standard_surface", "preview"}
    assert [e.effect for e in found["mitsuba"]] == [losses.OPTICS]
    assert {e.effect for e in found["preview"]} == {losses.OPTICS, losses.TRANSMISSION}

    errors = replace(FITS.errors, openpbr=0.5)
    other = losses_of(replace(cloth(), fits=replace(FITS, errors=errors)))
    told = losses_as_json(losses_of(cloth()), {"same": losses_of(cloth()), "other": other})
    assert [n["network"] for n in told if "colorways" in n] == ["openpbr"]
    (effect,) = told[1]["colorways"].pop("other")
    assert (effect["effect"], effect["error"]) == (losses.REFLECTANCE, 0.5)
    assert not told[1]["colorways"]


def test_json_has_no_empty_fields():
    for network in losses_as_json(losses_of(cloth())):
        for effect in network["effects"]:
            assert set(effect) <= {"effect", "fate", "how", "error"}
            assert all(value != "" and value is not None for value in effect.values())


def test_the_answer_the_manifest_and_the_readme_say_the_same(tmp_path):
    done = weaveusd.publish(TWILL, preset="denim", root=tmp_path, resolution=64)
    stated = done.as_dict()["losses"]
    assert json.loads((done.asset.folder / "manifest.json").read_text())["losses"] == stated
    text = (done.asset.folder / "README.md").read_text()
    errors = [e["error"] for n in stated for e in n["effects"] if "error" in e]
    assert len(errors) == 5
    for error in errors:
        assert 0 < error < 0.3
        assert f"{error:.1%} off" in text
