"""Standard shaders beside the exact cloth: how far off each is, and what a fit costs.

    python benchmarks/fits.py

For each preset, in its own weave, the error of a Lambertian surface in the yarns' colors, of a
fixed rule (α along the fibre 1.4 tan γ_s, across it 0.8, four times the fibre's F0), of the three
fits, and of the lobes that stand for the whole tile in OpenPBR and the preview: Σ |f̂ − f| / Σ f of
the tile's reflectance over pairs of directions that are not fitted. Then the processor time of a
fit, the least of five. Fails where a fit is worse than the rule.
"""

from __future__ import annotations

import math
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from weaveusd.cloth.weave import weave
from weaveusd.draft.make import make_draft
from weaveusd.shading.directions import pairs
from weaveusd.shading.fits import PAIRS, Solution, Tile, fit_standard
from weaveusd.shading.fresnel import reflectance
from weaveusd.shading.measured import measured, texels_of
from weaveusd.shading.tile import tile_parts
from weaveusd.synth.textures import synthesize
from weaveusd.yarn.recipe import preset_names, read_preset

if TYPE_CHECKING:
    from weaveusd.yarn.model import Optics

RESOLUTION = 256
ROUNDS = 5


def ruled(optics: Optics) -> tuple[float, float]:
    """Return the roughnesses (along, across) of the fixed rule."""
    return min(max(1.4 * math.tan(min(optics.gamma_s, 1.0)), 0.02), 0.8), 0.8


def main() -> int:
    """Print the table and return the exit status."""
    print("error in %, processor time in ms")
    print(
        f"{'cloth':16}{'Lambert':>9}{'rule':>9}{'OpenPBR':>9}{'standard':>9}{'preview':>9}"
        f"{'OpenPBR':>14}{'preview':>9} afar{'ms':>6}"
    )
    worse = []
    for preset in preset_names():
        recipe = read_preset(preset)
        cloth = weave(make_draft(recipe.weave or "plain"), recipe)
        texels = texels_of(cloth, synthesize(cloth, resolution=RESOLUTION))
        gains = measured(cloth, texels)
        times = []
        for _ in range(ROUNDS):
            begun = time.process_time()
            fits = fit_standard(cloth, texels, gains)
            times.append(time.process_time() - begun)

        optics = [yarn.optics for yarn in cloth.yarns]
        alphas = [ruled(o) for o in optics]
        parts, owner = tile_parts(cloth, texels, gains, *pairs(PAIRS), alphas)
        tile = Tile(parts, np.arange(PAIRS) // 4 % 2 == 0, alphas)
        f0 = float(np.mean([4 * o.k_s * float(reflectance(1.0, o.eta)) for o in optics]))
        value = sum(tile.of_part(p, f0, 1.0)[owner.index(k)] for k, p in enumerate(parts))
        rule = tile.error(Solution(f0, 1.0, np.asarray(value)))
        flat = np.sum([part.diffuse.sum(0) for part in parts], 0)
        lambert = tile.error(Solution(0.0, 1.0, flat))

        e = fits.errors
        cells = (lambert, rule, e.openpbr, e.standard_surface, e.preview)
        row = "".join(f"{100 * cell:9.1f}" for cell in cells)
        afar = f"{100 * e.openpbr_afar:14.1f}{100 * e.preview_afar:9.1f}"
        print(f"{preset:16}{row}{afar}{1e3 * min(times):11.0f}", flush=True)
        if e.openpbr > rule:
            worse.append(preset)
    if worse:
        print(f"the fit is worse than the rule for {', '.join(worse)}", file=sys.stderr)
    return 1 if worse else 0


if __name__ == "__main__":
    sys.exit(main())
