#!/usr/bin/env python3
"""Etendue and Mitsuba 3 at equal time: error against seconds, as docs/compare.md and docs/images/compare.svg.

Usage: pip install mitsuba numpy; scripts/error-against-time.py [--etendue PROGRAM] [--budget SECONDS] [SCENE...]

Of a Mitsuba scene both programs read the same file, with a box filter and GGX in place of Beckmann; suzanne-room is
read by Mitsuba with its `principled` material, which is near ours, not equal. Each program is held
against its own pair of references R1, R2 of a third of its time: with w = 1 / (r^2 + 0.01 mean(r)^2) the mean of
w (X - R1)(X - R2) is the squared error of X, without the noise of the references, and without the differences between
the programs. Renders of both alternate. Seconds are those of rendering: of Etendue as --stats has them, of Mitsuba from
the call to the finished array; the first render of each sample count, which compiles Mitsuba's kernels, does not count.
Etendue renders with its defaults and Sobol' points, Mitsuba by its llvm variant, `path`, and its best sampler (--sampler).
"""

import argparse, json, math, os, platform, re, subprocess, sys, tempfile, time
import mitsuba as mi
import numpy as np

ROOT = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
SCENES = {
    "cornell-box": ("scenes/mitsuba/cornell-box/scene.xml", "the Cornell box"),
    "suzanne-room": ("scenes/suzanne-room/suzanne-room.toml", "suzanne-room"),
    "veach-mis": ("scenes/mitsuba/veach-mis/scene.xml", "Veach's plates"),
}
SEEDS = 4
FIRST, FACTOR = 4, 4


def resized(text, size):
    """A Mitsuba scene of another size, with a box filter and GGX, for both programs."""
    text = text.replace('value="beckmann"', 'value="ggx"')
    text = re.sub(r'<rfilter type="\w+"\s*/>', '<rfilter type="box"/>', text)
    text = re.sub(r'(<default name="integrator" value=")\w+', r"\1path", text)
    for axis, pixels in zip("xy", size):
        text = re.sub(rf'name="res{axis}" value="\d+"', f'name="res{axis}" value="{pixels}"', text)
    return text


def absolute(text, folder):
    """A scene whose files are named from the root."""
    pattern = r'(name="filename" value=|file = )"([^"]+)"'
    return re.sub(pattern, lambda m: f'{m.group(1)}"{os.path.join(folder, m.group(2))}"', text)


def size_of(path, width):
    if path.endswith(".xml"):
        text = open(path).read()
        own = [int(re.search(rf'name="res{axis}" value="(\d+)"', text).group(1)) for axis in "xy"]
    else:
        own = [int(x) for x in re.search(r"size = \[(\d+), (\d+)\]", open(path).read()).groups()]
    return width, max(1, round(width * own[1] / own[0]))


class Etendue:
    name = "Etendue"

    def __init__(self, program, path, size, folder):
        text = absolute(open(path).read(), os.path.dirname(path))
        if path.endswith(".xml"):
            text = resized(text, size)
        elif "filter" not in text:
            text = text.replace("[film]", '[film]\nfilter = "box"')
        self.scene = os.path.join(folder, "etendue" + os.path.splitext(path)[1])
        open(self.scene, "w").write(text)
        self.program, self.size, self.out = program, size, os.path.join(folder, "etendue.pfm")

    def render(self, spp, seed):
        stats = self.out + ".json"
        size = "x".join(map(str, self.size))
        command = [self.program, "render", self.scene, "--size", size, "--spp", str(spp), "--seed", str(seed)]
        # A file may name another sampler, as Mitsuba's scenes do.
        command += ["--sampler", "sobol"]
        subprocess.run(command + ["-q", "-o", self.out, "--stats", stats], check=True)
        with open(self.out, "rb") as file:
            file.readline()
            width, height = map(int, file.readline().split())
            order = "<f4" if float(file.readline()) < 0 else ">f4"
            image = np.frombuffer(file.read(), dtype=order).reshape(height, width, 3)[::-1]
        return image.astype(np.float64), json.load(open(stats))["time"]["render"]


class Mitsuba:
    name = "Mitsuba"

    def __init__(self, path, size, folder, sampler):
        if path.endswith(".xml"):
            text = resized(absolute(open(path).read(), os.path.dirname(path)), size)
            text = text.replace('<sampler type="independent">', f'<sampler type="{sampler}">')
            copy = os.path.join(folder, "mitsuba.xml")
            open(copy, "w").write(text)
            self.scene = mi.load_file(copy)
        else:
            self.scene = mi.load_dict(suzanne_room(os.path.dirname(path), size, sampler))

    def render(self, spp, seed):
        start = time.perf_counter()
        image = np.array(mi.render(self.scene, spp=spp, seed=seed))[..., :3].astype(np.float64)
        return image, time.perf_counter() - start


def materials_of(file):
    """The materials of an MTL file, as dictionaries of their numbers."""
    materials = {}
    for key, *values in (line.split() for line in open(file) if line.strip()):
        if key == "newmtl":
            current = materials[values[0]] = {}
        elif materials:
            current[key] = values[0] if key.startswith("map_") else [float(value) for value in values]
    return materials


def suzanne_room(folder, size, sampler):
    """scenes/suzanne-room as a scene of Mitsuba: a mesh for each material of the OBJ."""
    transform = mi.ScalarTransform4f().look_at(origin=[0, 1.6, 6.2], target=[0, 1.1, -1], up=[0, 1, 0])
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}}
    sensor = {"type": "perspective", "fov": 36, "fov_axis": "y", "to_world": transform, "film": film}
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": -1},
        "sensor": {**sensor, "sampler": {"type": sampler}},
    }
    corners = {"v": [], "vt": [], "vn": []}
    faces = {}
    for key, *values in (line.split() for line in open(os.path.join(folder, "suzanne-room.obj")) if line.strip()):
        if key in corners:
            corners[key].append([float(value) for value in values])
        elif key == "usemtl":
            current = faces.setdefault(values[0], [])
        elif key == "f":
            current.append([[int(index) - 1 for index in corner.split("/")] for corner in values])
    positions, coordinates, normals = (np.array(corners[key], dtype=np.float32) for key in ("v", "vt", "vn"))
    for name, material in materials_of(os.path.join(folder, "suzanne-room.mtl")).items():
        if name not in faces:
            continue
        triangles = np.array(faces[name]).reshape(-1, 3)
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict(bsdf_of(material, folder))
        if any(material["Ke"]):
            emission = {"type": "rgb", "value": material["Ke"]}
            properties["emitter"] = mi.load_dict({"type": "area", "radiance": emission})
        count = len(triangles)
        mesh = mi.Mesh(name, count, count // 3, has_vertex_normals=True, has_vertex_texcoords=True, props=properties)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = positions[triangles[:, 0]].ravel()
        parameters["vertex_texcoords"] = coordinates[triangles[:, 1]][:, :2].ravel()
        parameters["vertex_normals"] = normals[triangles[:, 2]].ravel()
        parameters["faces"] = np.arange(count, dtype=np.uint32)
        parameters.update()
        scene[name] = mesh
    return scene


def bsdf_of(material, folder):
    if "Tf" in material:
        return {"type": "dielectric", "int_ior": material["Ni"][0]}
    if "map_Kd" in material:
        colour = {"type": "bitmap", "filename": os.path.join(folder, material["map_Kd"])}
    else:
        colour = {"type": "rgb", "value": material["Kd"]}
    principled = {"type": "principled", "base_color": colour, "roughness": max(material["Pr"][0], 0.02)}
    principled.update(metallic=material["Pm"][0], eta=material["Ni"][0])
    return {"type": "twosided", "bsdf": principled}


def references(program, seconds):
    """Two renders that take about `seconds` together, with the weight of squared errors."""
    program.render(16, 900)
    _, pace = program.render(16, 901)
    spp = 4 ** int(math.log(max(16 * seconds / (2 * pace), 16), 4))
    one, two = (program.render(spp, 902 + index)[0] for index in range(2))
    mean = 0.5 * (one + two)
    return one, two, 1 / (mean**2 + 0.01 * mean.mean() ** 2)


def measured(programs, seconds):
    """For each program a list of (spp, seconds, error, errors by seed), from few samples to many, in turn."""
    held = [references(program, seconds / 3) for program in programs]
    left = [seconds * 2 / 3] * len(programs)
    levels = [[] for _ in programs]
    spp = FIRST
    while any(budget > 0 for budget in left):
        for index, program in enumerate(programs):
            expected = FACTOR * levels[index][-1][1] * (SEEDS + 1) if levels[index] else 0
            if left[index] < expected:
                left[index] = 0
                continue
            started = time.perf_counter()
            program.render(spp, 1000)
            one, two, weight = held[index]
            runs = [program.render(spp, 1 + seed) for seed in range(SEEDS)]
            errors = [float((weight * (image - one) * (image - two)).mean()) for image, _ in runs]
            levels[index].append((spp, float(np.median([t for _, t in runs])), float(np.mean(errors)), errors))
            left[index] -= time.perf_counter() - started
        spp *= FACTOR
    return levels


def cost(levels):
    """relMSE times seconds of the three longest levels, with its standard error, relative."""
    used = levels[-3:]
    products = np.array([[seconds * error for error in errors] for _, seconds, _, errors in used])
    mean = products.mean()
    return mean, products.std(ddof=1) / math.sqrt(products.size) / mean


def plot(results, file):
    """Error against seconds, a panel for each scene, as SVG that follows a light or dark page."""
    wide, high, margin = 360, 250, 54
    columns = 2
    rows = -(-len(results) // columns)
    every = [(t, 100 * math.sqrt(e)) for _, both in results for levels in both for _, t, e, _ in levels if e > 0]
    ends = [[f(math.log10(p[axis]) for p in every) for f in (min, max)] for axis in (0, 1)]
    ends = [[math.floor(2 * low) / 2, math.ceil(2 * high_end) / 2] for low, high_end in ends]
    place = lambda axis, value: (math.log10(value) - ends[axis][0]) / (ends[axis][1] - ends[axis][0])
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {columns * (wide + margin) + 20} {rows * (high + 2 * margin)}">',
        "<style>text{font:13px system-ui,sans-serif;fill:#59616b}.t{font-weight:600;fill:#1c2026}.g{stroke:#d4d8dd;stroke-width:.7}"
        ".a{fill:none;stroke:#0072b2;stroke-width:2}.b{fill:none;stroke:#d55e00;stroke-width:2;stroke-dasharray:7 4}"
        "@media(prefers-color-scheme:dark){text{fill:#a0a8b1}.t{fill:#e6e8ea}.g{stroke:#3a4047}.a{stroke:#3d9ad6}.b{stroke:#ee7a2e}}</style>",
    ]
    for number, (title, both) in enumerate(results):
        left = margin + (number % columns) * (wide + margin)
        top = margin + (number // columns) * (high + 2 * margin)
        x = lambda seconds: left + place(0, seconds) * (wide - 20)
        y = lambda percent: top + (1 - place(1, percent)) * high
        parts.append(f'<text class="t" x="{left}" y="{top - 14}">{title}</text>')
        for error in (0.1, 0.3, 1, 3, 10, 30, 100):
            if 0 <= place(1, error) <= 1:
                parts.append(f'<path class="g" d="M{left} {y(error):.1f}h{wide - 20}"/>')
                parts.append(f'<text x="{left - 6}" y="{y(error) + 4:.1f}" text-anchor="end">{error} %</text>')
        for seconds, label in ((0.01, "10 ms"), (0.1, "0.1 s"), (1, "1 s"), (10, "10 s"), (100, "100 s")):
            if 0 <= place(0, seconds) <= 1:
                parts.append(f'<path class="g" d="M{x(seconds):.1f} {top}v{high}"/>')
                parts.append(f'<text x="{x(seconds):.1f}" y="{top + high + 18}" text-anchor="middle">{label}</text>')
        for levels, kind, name in zip(both, "ab", ("Etendue", "Mitsuba 3")):
            points = [(x(t), y(100 * math.sqrt(e))) for _, t, e, _ in levels if e > 0]
            parts.append(f'<path class="{kind}" d="M{"L".join(f"{px:.1f} {py:.1f}" for px, py in points)}"/>')
            row = top + 16 + 18 * "ab".index(kind)
            parts.append(f'<path class="{kind}" d="M{left + wide - 120} {row}h26"/>')
            parts.append(f'<text x="{left + wide - 88}" y="{row + 4}">{name}</text>')
    open(file, "w").write("\n".join(parts + ["</svg>"]) + "\n")


def processor():
    try:
        return re.search(r"model name\s*: (.*)", open("/proc/cpuinfo").read()).group(1)
    except (OSError, AttributeError):
        return platform.processor() or platform.machine()


def page(results, options, version):
    """docs/compare.md: where Mitsuba is quicker first, then the others."""
    told = []
    for title, both in results:
        (ours, our_error), (theirs, their_error) = map(cost, both)
        told.append((theirs / ours, 2 * math.hypot(our_error, their_error), title, both))
    told.sort(key=lambda it: it[0])
    lines = ["<!-- Made by scripts/error-against-time.py; do not edit. -->", "# Etendue and Mitsuba 3 at equal time", ""]
    slower = [it for it in told if it[0] * math.exp(it[1]) < 1]
    if slower:
        names = ", ".join(f"{it[2]} ({1 / it[0]:.2f} times as fast as Etendue)" for it in slower)
        lines += [f"Mitsuba is quicker in {names}.", ""]
    lines += ["![Error against seconds of Etendue and Mitsuba 3](images/compare.svg)", ""]
    lines += ["relMSE × seconds of the three longest sample counts, less is better, and the times to an equal error:", ""]
    lines += ["| scene | Etendue | Mitsuba 3 | time of Mitsuba / time of Etendue |", "|---|---:|---:|---:|"]
    for ratio, margin, title, both in told:
        ours, theirs = (cost(levels)[0] for levels in both)
        interval = f"{ratio:.2f} ({ratio * math.exp(-margin):.2f} to {ratio * math.exp(margin):.2f})"
        lines.append(f"| {title} | {ours:.3g} | {theirs:.3g} | {interval} |")
    # Without the folders of the machine.
    command = " ".join(["scripts/error-against-time.py"] + [re.sub("[^=]*/", "", it) for it in sys.argv[1:]])
    lines += ["", f"Measured by `{command}`: {options.width} pixels wide, {SEEDS} seeds, {options.budget:g} s for each program and scene,"]
    lines += [f"{version} against Mitsuba {mi.__version__} (`{mi.variant()}`, sampler `{options.sampler}`), on {os.cpu_count()} processors ({processor()})."]
    method = __doc__.split("\n\n")[2].strip().replace("\n", " ")
    lines += ["", method, ""]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scenes", nargs="*", help=f"of {', '.join(SCENES)}, or files NAME=SCENE.xml")
    parser.add_argument("--etendue", default=os.path.join(ROOT, "target", "release", "etendue"))
    parser.add_argument("--budget", type=float, default=120, help="seconds for each program and scene")
    parser.add_argument("--width", type=int, default=384)
    parser.add_argument("--sampler", default="multijitter", help="of Mitsuba")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--docs", default=os.path.join(ROOT, "docs"))
    options = parser.parse_args()
    mi.set_variant(options.variant)
    version = subprocess.run([options.etendue, "--version"], check=True, capture_output=True, text=True).stdout.strip()
    results = []
    for name in options.scenes or SCENES:
        title, _, file = name.partition("=")
        path, title = (file, title) if file else SCENES[name]
        path = os.path.abspath(os.path.join(ROOT, path))
        size = size_of(path, options.width)
        with tempfile.TemporaryDirectory() as folder:
            programs = [Etendue(options.etendue, path, size, folder), Mitsuba(path, size, folder, options.sampler)]
            levels = measured(programs, options.budget)
        results.append((title, levels))
        for program, own in zip(programs, levels):
            told = ", ".join(f"{100 * math.sqrt(max(e, 0)):.2f} % in {t:.3g} s" for _, t, e, _ in own)
            print(f"{name}: {program.name}: {told}", file=sys.stderr)
    os.makedirs(os.path.join(options.docs, "images"), exist_ok=True)
    plot(results, os.path.join(options.docs, "images", "compare.svg"))
    with open(os.path.join(options.docs, "compare.md"), "w") as file:
        file.write(page(results, options, version))


main()
