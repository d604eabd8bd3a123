"""Recover a cloth's γ_s and A from a picture of it, by gradient.

python examples/recover_optics.py [PRESET] [--size 48] [--steps 200]

A swatch of the preset is rendered under four lamps; that picture is the only thing known of its
optics. From a start that is wrong in every number, Adam follows the derivatives that Dr.Jit takes
through the renderer, until γ_s of every yarn and its albedo A are found again. Geometry and the
other optics are taken as known. N_V, which follows from the optics, is computed anew each step.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from weaveusd.cloth.model import Weave
from weaveusd.cloth.weave import weave
from weaveusd.draft.make import make_draft
from weaveusd.render import variant
from weaveusd.shading.normalization import normalization
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.recipe import read_preset

variant.prepare(variant.LLVM)

import drjit as dr  # noqa: E402
import mitsuba as mi  # noqa: E402

from weaveusd.render.bsdf import cloth_bsdf_dict  # noqa: E402
from weaveusd.render.packing import COLOR, COMPONENTS, YARN  # noqa: E402

LAMPS = ((1.6, 1.7, 1.1), (1.9, 0.8, 0.8), (0.5, 2.1, 0.9), (-1.4, -0.2, 1.8))
SHORTEST, WIDEST = np.radians([0.5, 45])
RATE = 0.05
BSDF = "swatch.bsdf."


@dataclass(frozen=True, slots=True)
class Optics:
    """What is looked for: γ_s in radians (yarns,), and the albedo A (yarns, 3)."""

    gamma_s: np.ndarray
    albedo: np.ndarray


class Swatch:
    """A flat cloth under lamps, rendered from optics that can be differentiated."""

    def __init__(self, preset: str, *, size: int, texels: int = 64) -> None:
        recipe = read_preset(preset)
        self.cloth: Weave = weave(make_draft(recipe.weave or "plain"), recipe)
        arrays = synthesize(self.cloth, resolution=texels).whole()
        self.optics = [yarn.optics for yarn in self.cloth.yarns]
        self.truth = Optics(
            np.array([o.gamma_s for o in self.optics]),
            np.array([yarn.color for yarn in self.cloth.yarns]),
        )
        repeat = np.array(self.cloth.repeat_mm)
        bsdf = cloth_bsdf_dict(arrays, self._inputs(), tuple(repeat.max() / repeat))
        self.scene = mi.load_dict(_scene(bsdf, size), parallel=False)
        self.parameters = mi.traverse(self.scene)
        packed = np.array(self.parameters[BSDF + "packed"])
        # Texels without their color, and where the color of which yarn belongs.
        self.index = packed[..., YARN].astype(np.uint32)
        self.shape = packed.shape
        packed[..., COLOR : COLOR + 3] = 0
        self.colorless = mi.Float(packed.ravel())

    def _inputs(self) -> dict[str, list[float]]:
        fields = ("eta", "k_d", "k_s", "gamma_s", "gamma_v", "tau")
        inputs = {name: [getattr(o, name) for o in self.optics] for name in fields}
        return {**inputs, "normalization": self.normalizations(self.truth.gamma_s)}

    def normalizations(self, gamma_s: np.ndarray) -> list[float]:
        """Return N_V of every yarn for these γ_s."""
        return [
            normalization(o.eta, o.k_d, o.k_s, float(gamma), o.gamma_v)
            for o, gamma in zip(self.optics, gamma_s, strict=True)
        ]

    def dress(self, log_gamma: Any, albedo: Any, n_v: list[float]) -> None:
        """Give the cloth ln γ_s (yarns,), A (3 yarns,), both differentiable, and N_V (yarns,)."""
        texels = self.shape[0] * self.shape[1]
        flat = self.colorless
        for channel in range(3):
            color = dr.gather(mi.Float, albedo, mi.UInt32(self.index.ravel()) * 3 + channel)
            place = dr.arange(mi.UInt32, texels) * COMPONENTS + COLOR + channel
            spread = dr.zeros(mi.Float, texels * COMPONENTS)
            dr.scatter(spread, color, place)
            flat = flat + spread
        self.parameters[BSDF + "packed"] = mi.TensorXf(flat, self.shape)
        self.parameters[BSDF + "gamma_s"] = dr.exp(log_gamma)
        self.parameters[BSDF + "normalization"] = mi.Float(n_v)
        self.parameters.update()

    def image(self, *, spp: int, seed: int) -> Any:
        """Return the picture (size, size, 3) of the cloth as it is dressed."""
        return mi.render(self.scene, self.parameters, spp=spp, seed=seed, seed_grad=seed + 1)

    def target(self, spp: int = 256) -> Any:
        """Return the picture of the cloth with its own optics."""
        self.dress(
            mi.Float(np.log(self.truth.gamma_s)),
            mi.Float(self.truth.albedo.ravel()),
            self.normalizations(self.truth.gamma_s),
        )
        return dr.detach(self.image(spp=spp, seed=10_007))


def _scene(bsdf: dict[str, Any], size: int) -> dict[str, Any]:
    eye = mi.ScalarTransform4f().look_at(origin=(-1.7, -1.7, 1.4), target=(0, 0, 0), up=(0, 0, 1))
    lamps = {
        f"lamp{k}": {"type": "point", "position": list(p), "intensity": {"type": "rgb", "value": 4}}
        for k, p in enumerate(LAMPS)
    }
    return {
        "type": "scene",
        # Point lamps alone: every sample meets all of them, and nothing is left to chance.
        "integrator": {"type": "direct", "emitter_samples": 4, "bsdf_samples": 0},
        "sensor": {
            "type": "perspective",
            "fov": 36,
            "to_world": eye,
            "film": {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}},
        },
        "swatch": {"type": "rectangle", "bsdf": bsdf},
        **lamps,
    }


def loss(image: Any, other: Any, target: Any) -> Any:
    """Return the mean squared difference to the target, relative where it is bright.

    `other` is a render of its own, on no tape. The square of one render alone would measure its
    noise too and, since wide lobes are less noisy, favor lobes too wide; this product falls a
    little below 0 where only noise is left. Its derivative is half of that of the square, which
    Adam does not feel.
    """
    scale = 1 / dr.square(target + 0.1)
    return dr.mean((image - target) * dr.detach(other - target) * scale, axis=None)


def wrong_start(truth: Optics) -> Optics:
    """Return optics that are far from the truth: lobes twice as wide, all yarns gray."""
    return Optics(np.minimum(2 * truth.gamma_s, WIDEST), np.full_like(truth.albedo, 0.4))


def recover(
    swatch: Swatch, start: Optics, target: Any, *, steps: int, spp: int = 8
) -> Iterator[tuple[float, Optics]]:
    """Yield the loss and the optics after every step of Adam."""
    optimizer = mi.ad.Adam(lr=RATE)
    optimizer["log_gamma"] = mi.Float(np.log(start.gamma_s))
    optimizer["albedo"] = mi.Float(start.albedo.ravel())
    found = start
    for step in range(steps):
        # The albedo first: while colors are wrong, the width of a lobe would make up for them.
        late = min(1, 0.1 ** (2 * step / steps - 1))
        rates = {"log_gamma": 4 * RATE * late if step > steps / 4 else 0.0, "albedo": RATE * late}
        optimizer.set_learning_rate(rates)
        n_v = swatch.normalizations(found.gamma_s)
        swatch.dress(optimizer["log_gamma"], optimizer["albedo"], n_v)
        with dr.suspend_grad():
            other = swatch.image(spp=spp, seed=4 * step)
        error = loss(swatch.image(spp=spp, seed=4 * step + 2), other, target)
        dr.backward(error)
        optimizer.step()
        optimizer["log_gamma"] = dr.clip(
            optimizer["log_gamma"], float(np.log(SHORTEST)), float(np.log(WIDEST))
        )
        optimizer["albedo"] = dr.clip(optimizer["albedo"], 0.001, 1)
        found = Optics(
            np.exp(np.array(optimizer["log_gamma"], float)),
            np.array(optimizer["albedo"], float).reshape(-1, 3),
        )
        yield float(np.array(error).ravel()[0]), found


def main() -> None:
    """Print truth, start and what was found for every yarn."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("preset", nargs="?", default="shot_silk")
    parser.add_argument("--size", type=int, default=48, help="pixels along a side")
    parser.add_argument("--steps", type=int, default=200)
    options = parser.parse_args()

    swatch = Swatch(options.preset, size=options.size)
    truth = swatch.truth
    target = swatch.target()
    start = found = wrong_start(truth)
    for step, (error, now) in enumerate(recover(swatch, start, target, steps=options.steps), 1):
        found = now
        if step % 20 == 0 or step == options.steps:
            print(f"step {step:4}  loss {error:.2e}")
    print(f"\n{'':22} {'γ_s':>7}   A")
    for k, yarn in enumerate(swatch.cloth.yarns):
        for name, optics in (("truth", truth), ("start", start), ("found", found)):
            color = "  ".join(f"{c:.3f}" for c in optics.albedo[k])
            gamma = np.degrees(optics.gamma_s[k])
            print(f"{yarn.name if name == 'truth' else '':<14} {name:<7} {gamma:6.2f}°   {color}")


if __name__ == "__main__":
    main()
