#!/usr/bin/python3
"""Writes gallery.md and its figures from fitted results: gallery.py RESULTS DOCS."""
import json
import pathlib
import shutil
import sys

METHODS = ["naive", "filtered", "kirchhoff"]
FIGURES = {("anisotropic", "filtered"), ("brushed", "kirchhoff"), ("newview_milled.asc", "filtered")}

TEXTURES = """\
## Textures

One command each, `microbrdf texture strips --layout "r{row}_c{col}" --texel 60um --size 256`: three strips along and three across, each of
64 texels (3.8 mm), above on blue; the texture made like them below ([texture.md](texture.md)); slope coordinates on the exemplar's mean
± 2.5 standard deviations.

**brushed** (scratches 2 mm long, along y)

![brushed texture](gallery/texture_brushed.png)

**isotropic** (multiscale, correlation lengths to 300 µm)

![isotropic texture](gallery/texture_isotropic.png)
""".splitlines()


def number(value):
    return "–" if value is None else f"{value:.3g}"


def rows(folder):
    fits = json.loads((folder / "fits.json").read_text())["fits"]
    for method in METHODS:
        found = {fit["model"]: fit for fit in fits if fit["method"] == method}
        if not found:
            continue
        e, b = found["ellipsoid"], found["beckmann"]
        status = " ".join(sorted({e["status"], b["status"]}))
        yield (f"| {folder.name} | {method} | {number(e['alpha_x'])} | {number(e['alpha_y'])} | {number(e['theta_x'])} "
               f"| {number(e['theta_y'])} | {number(e['theta_z'])} | {number(e['rel_rms'])} | {number(b['alpha_x'])} "
               f"| {number(b['alpha_y'])} | {number(b['rel_rms'])} | {number(e['nodes_across'])} | {status} |")


def table(folders):
    yield ("| surface | NDF | ellipsoid α_x | α_y | θ_x | θ_y | θ_z | rel. rms | Beckmann α_x | α_y | rel. rms "
           "| nodes across | status |")
    yield "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
    for folder in folders:
        yield from rows(folder)


def main(results, docs):
    docs = pathlib.Path(docs)
    folders = sorted(pathlib.Path(results).iterdir())
    done = [f for f in folders if (f / "fits.json").exists()]
    kinds = {f: (f / "kind").read_text().strip() for f in folders}
    (docs / "gallery").mkdir(exist_ok=True)
    figures = []
    for folder in done:
        for method in METHODS:
            if (folder.name, method) in FIGURES and (folder / f"fit_{method}.png").exists():
                name = f"{folder.name.split('.')[0]}_{method}.png"
                shutil.copy(folder / f"fit_{method}.png", docs / "gallery" / name)
                figures += [f"**{folder.name}, {method}**", "", f"![{folder.name}, {method}](gallery/{name})", ""]
    text = [
        "# Gallery of fits",
        "",
        "Ellipsoid and Beckmann distributions fitted to the normal distributions of made and of real surfaces, as in",
        "[Dong15 Fig. 12]: each NDF on 513² nodes with `--extent auto`, angles in radians. `bench/gallery.sh SCAN...`",
        "measures all of it again and writes this file. The relative rms is that over the table, weighted by solid angle:",
        "it holds the noise of the histogram (or the speckle of D_K) of so many scans beside what the model misses.",
        "",
        "## Made surfaces",
        "",
        "Four patches each of 640 × 480 points at 0.11 µm: gaussian (rms 0.3 µm, τ 3 µm; unfiltered it is Beckmann with",
        "α = 2·0.3/3 = 0.2, under the 1 µm window 2·0.3·3/(3² + 4) = 0.138), anisotropic (τ 12 and 3 µm, turned by 20°;",
        "unfiltered α = 0.05 and 0.2), multiscale and brushed as `microbrdf synth` makes them.",
        "",
        *table([f for f in done if kinds[f] == "made"]),
        "",
    ]
    real = [f for f in folders if kinds[f] == "real"]
    if real:
        text += ["## Real scans", "", *table([f for f in real if f in done]), ""]
        failed = [(f.name, (f / "stderr").read_text().strip().splitlines()) for f in real if f not in done]
        if failed:
            text += ["Without a fit, in the program's words:", ""]
            text += [f"- {name}: {said[0].split(': ', 2)[-1] if said else 'nothing'}" for name, said in failed]
            text += [""]
    text += ["## Figures", "", "Table, ellipsoid and difference around the lobe; slices through the peak, log scale.", "",
             *figures, *TEXTURES]
    (docs / "gallery.md").write_text("\n".join(text).rstrip() + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
