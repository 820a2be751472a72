#!/usr/bin/env python3
"""Compares images of Etendue with those of Mitsuba 3 of the same scenes, tile by tile, by Welch's test.

Usage: pip install mitsuba; scripts/against-mitsuba.py [--etendue PROGRAM] [SCENE.xml...]

Both render copies of the scenes with a box filter and GGX in place of Beckmann, with as many seeds as --seeds says.
Where the models differ by design (docs/scene-formats.md), --allow is the relative difference that is not tested.
Measure: relative differences of the mean luminance of tiles. The exit code is 1 if a tile differs with a probability
below 1 % over all tiles of a scene (Sidak). The test of a scene sees differences of about five standard errors, which
are printed. Student's distribution is approximated by the normal one as in Wallace 1959, eq. 3.
"""

import argparse, math, os, re, statistics, subprocess, sys, tempfile
import mitsuba as mi
import numpy as np

TILES = 8
ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..")


def comparable(path, folder, width):
    """Writes the copy of a scene that both render, and returns its path."""
    with open(path) as file:
        text = file.read()
    text = text.replace('value="beckmann"', 'value="ggx"')
    text = re.sub(r'<rfilter type="\w+"\s*/>', '<rfilter type="box"/>', text)
    text = re.sub(r'(<default name="integrator" value=")\w+', r"\1path", text)
    here = os.path.dirname(os.path.abspath(path))
    absolute = lambda match: f'name="filename" value="{os.path.join(here, match.group(1))}"'
    text = re.sub(r'name="filename" value="([^"]+)"', absolute, text)
    for names in (("resx", "resy"), ("width", "height")):
        size = [re.search(rf'name="{name}" value="(\d+)"', text) for name in names]
        if all(size):
            size = [int(match.group(1)) for match in size]
            size = [width, max(1, round(width * size[1] / size[0]))]
            for name, pixels in zip(names, size):
                text = re.sub(rf'name="{name}" value="\d+"', f'name="{name}" value="{pixels}"', text)
            break
    copy = os.path.join(folder, "scene.xml")
    with open(copy, "w") as file:
        file.write(text)
    return copy


def tiles(image):
    """The mean luminance of each tile."""
    luminance = np.asarray(image)[..., :3].astype(np.float64) @ [0.2126, 0.7152, 0.0722]
    rows = np.array_split(luminance, TILES)
    return np.array([[part.mean() for part in np.array_split(row, TILES, axis=1)] for row in rows])


def by_etendue(program, scene, spp, seed, folder):
    out = os.path.join(folder, "etendue.exr")
    subprocess.run([program, "render", scene, "--spp", str(spp), "--seed", str(seed), "-q", "-o", out], check=True)
    return tiles(mi.Bitmap(out).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False))


def p_values(a, b, allow):
    """Two-sided p-values of Welch's test of each tile, for a difference beyond `allow` times the mean."""
    count = len(a)
    of_mean = [np.var(x, axis=0, ddof=1) / count for x in (a, b)]
    error = np.sqrt(sum(of_mean)) + 1e-12
    means = np.mean(a, axis=0), np.mean(b, axis=0)
    beyond = np.maximum(np.abs(means[0] - means[1]) - allow * means[1], 0)
    t = beyond / error
    freedom = sum(of_mean) ** 2 / (sum(v**2 for v in of_mean) / (count - 1) + 1e-300)
    freedom = np.maximum(freedom, 1)
    z = (8 * freedom + 1) / (8 * freedom + 3) * np.sqrt(freedom * np.log1p(t**2 / freedom))
    normal = statistics.NormalDist()
    return np.vectorize(lambda z: 2 * normal.cdf(-z))(z), means, error


def compare(path, options):
    with tempfile.TemporaryDirectory() as folder:
        copy = comparable(path, folder, options.width)
        scene = mi.load_file(copy)
        theirs = [tiles(mi.render(scene, spp=options.spp, seed=seed)) for seed in range(options.seeds)]
        ours = [by_etendue(options.etendue, copy, options.spp, seed, folder) for seed in range(options.seeds)]
    p, (mean, reference), error = p_values(np.array(ours), np.array(theirs), options.allow)
    least = 1 - (1 - p.min()) ** p.size
    ratio = mean.mean() / reference.mean()
    worst = np.unravel_index(p.argmin(), p.shape)
    print(
        f"{os.path.relpath(path)}: mean {ratio:.5f} of Mitsuba's; standard error of a tile "
        f"{100 * np.median(error / (reference + 1e-12)):.2f} %; worst of {p.size} tiles: row {worst[0]}, column "
        f"{worst[1]}, {100 * (mean[worst] / reference[worst] - 1):+.2f} %, p = {least:.3g} over all"
    )
    return least > 0.01


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="*", default=[
        os.path.join(ROOT, "scenes", "mitsuba", name, "scene.xml") for name in ("cornell-box", "veach-mis", "models")])
    parser.add_argument("--etendue", default=os.path.join(ROOT, "target", "release", "etendue"))
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--width", type=int, default=128)
    parser.add_argument("--allow", type=float, default=0.0)
    parser.add_argument("--variant", default="scalar_rgb")
    options = parser.parse_args()
    mi.set_variant(options.variant)
    return 0 if all([compare(path, options) for path in options.scenes]) else 1


sys.exit(main())
