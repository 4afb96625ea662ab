#!/usr/bin/python3
"""Draws the curves of error against run time and writes accuracy.md: accuracy.py CSV DOCS."""
import csv
import math
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

COLOURS = {"exact": "black", "monte-carlo": "tab:orange", "spectral": "tab:blue"}


def number(text):
    return f"{float(text):.2g}"


def draw_kirchhoff(rows, path):
    surfaces = list(dict.fromkeys(row["surface"] for row in rows))
    columns = 4
    lines = math.ceil(len(surfaces) / columns)
    figure, axes = plt.subplots(lines, columns, figsize=(12, 3 * lines), sharex=True, sharey=True, squeeze=False)
    for axis in axes.flat[len(surfaces):]:
        axis.axis("off")
    for axis, surface in zip(axes.flat, surfaces):
        for estimator, colour in COLOURS.items():
            points = [r for r in rows if r["surface"] == surface and r["estimator"] == estimator and r["note"] != "paper"]
            axis.loglog([float(r["seconds"]) for r in points], [float(r["error"]) for r in points], "o-",
                        color=colour, markersize=3, label=estimator)
        for row in (r for r in rows if r["surface"] == surface and r["note"] == "paper"):
            axis.loglog(float(row["seconds"]), float(row["error"]), "*", color="tab:red", markersize=12,
                        label="[Dong15]: one point a triangle")
        axis.set_title(surface, fontsize=10)
        axis.grid(alpha=0.3)
    for axis in axes[-1]:
        axis.set_xlabel("seconds for the whole table")
    for axis in axes[:, 0]:
        axis.set_ylabel("relative L2 error of D")
    axes.flat[0].legend(fontsize=7, loc="lower left")
    figure.tight_layout()
    plt.rcParams["svg.fonttype"] = "none"
    plt.rcParams["svg.hashsalt"] = "microbrdf"
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def spectral_table(rows):
    yield "| surface | tol | error | without core | seconds | said |"
    yield "|---|---|---|---|---|---|"
    for r in rows:
        if r["estimator"] == "spectral":
            said = "reached" if r["reached"] == "yes" else "**not reached**"
            yield (f"| {r['surface']} | {r['asked']} | {number(r['error'])} | {number(r['error_core_free'])} "
                   f"| {number(r['seconds'])} | {said} |")


def comparison_table(rows):
    yield "| surface | [Dong15]: error | seconds | spectral at no more error: error | seconds | times faster |"
    yield "|---|---|---|---|---|---|"
    for paper in (r for r in rows if r["note"] == "paper"):
        better = [r for r in rows if r["surface"] == paper["surface"] and r["estimator"] == "spectral"
                  and float(r["error"]) <= float(paper["error"])]
        if not better:
            continue
        best = min(better, key=lambda r: float(r["seconds"]))
        ratio = float(paper["seconds"]) / float(best["seconds"])
        yield (f"| {paper['surface']} | {number(paper['error'])} | {number(paper['seconds'])} "
               f"| {number(best['error'])} | {number(best['seconds'])} | {ratio:,.0f} |")


def kirchhoff_section(rows):
    spectral = [r for r in rows if r["estimator"] == "spectral"]
    held = [r for r in spectral if r["reached"] == "yes"]
    worst = max(max(float(r["error"]), float(r["error_core_free"])) / float(r["asked"]) for r in held)
    return "\n".join([
        "## The Kirchhoff distribution D_K",
        "",
        "![Error against run time of D_K](accuracy/kirchhoff.svg)",
        "",
        "On all nodes of the 1025² table at λ_q = 0.555 µm, out to the first false order, on all cores. The error",
        "is (Σ(D − D\\*)²/ΣD\\*²)^½ over the table, estimated from 96 nodes drawn in thirds by D², by D² without the",
        "coherent core, and evenly, with D\\* from the closed form (`kirchhoff/exact`). *Without core* leaves out",
        "|h_xy| within two resolution cells. Monte Carlo and the closed form were timed on those 96 directions and",
        "scaled to all nodes; what rounding leaves of the closed form shows when the same triangles are summed in",
        "the opposite order. The red star is the paper's choice: one random point a triangle, |F|² as it comes.",
        "",
        *comparison_table(rows),
        "",
        f"The spectral estimator, by what was asked. Where it says *reached*, the larger of the two errors was at",
        f"most {worst:.2g} times the tolerance.",
        "",
        *spectral_table(rows),
    ])


# Part, estimator, what `asked` is, what error and seconds are.
FIT_CURVES = [
    ("fit", "size", "nodes a side", "exact table: frame found against the true one, in widths; seconds of a fit"),
    ("fit", "histogram", "nodes a side", "the same with the mean over each bin in its node"),
    ("fit", "noise", "noise / peak", "129² nodes with additive noise"),
    ("fit", "counts", "normals", "129² nodes, a histogram of drawn normals"),
    ("fit", "steps", "Gauss–Newton steps", "513² nodes after so many steps on all of them"),
    ("masking", "table", "nodes a side", "tabulated G1, rms over directions; seconds with its table and 2000 values"),
    ("sampling", "table", "nodes a side",
     "tabulated density of visible normals, relative L2; seconds for 10⁵ samples with tables and both densities"),
]


BRDF_CURVES = [
    ("brdf", "albedo", "tolerance", "directional albedo at 60°: difference to one of tolerance 1e-6"),
    ("brdf", "table", "nodes a side",
     "f of a tabulated distribution, relative L2 over samples of the model; seconds for 90 × 90 × 180 bins at 3 wavelengths"),
    ("brdf", "half-angle table", "N",
     "f in the nearest of N × N × 2N bins, as readers of MERL's files look it up (N = 90), same error; seconds to fill it at one wavelength"),
    ("brdf", "spectrum", "wavelengths",
     "colour of the albedo at 60°, largest difference in linear sRGB to 200 wavelengths; each albedo to 2e-4, on the same lattice"),
]


def fit_section(rows):
    yield "## Fits, and tabulated masking and sampling"
    yield ""
    yield "Lobes: round (α 0.2), needle (0.3, 0.03), skewed (0.2, 0.1, tilted by 0.6 and 0.3 rad); tables of the whole disk."
    yield "A table's own error in G1 and in visible normals falls as the root of its spacing for an ellipsoid: that is the tail"
    yield "of slopes in the ring of cells that the horizon cuts."
    yield from curve_tables(rows, FIT_CURVES)


def brdf_section(rows):
    yield "## Reflectance"
    yield ""
    yield "Copper under a round lobe (α 0.2) and a needle (0.3, 0.03), ellipsoid NDFs with their G1; 0.55 µm unless said."
    yield "Light at 60°. Seconds of this section are CPU seconds of all threads."
    yield from curve_tables(rows, BRDF_CURVES)


def curve_tables(rows, curves):
    for part, estimator, asked, meaning in curves:
        found = [r for r in rows if r["part"] == part and r["estimator"] == estimator]
        if not found:
            continue
        lobes = list(dict.fromkeys(r["surface"] for r in found))
        yield from ["", f"**{part}, {estimator}**: {meaning}.", ""]
        yield f"| {asked} | " + " | ".join(f"{lobe}: error | seconds" for lobe in lobes) + " |"
        yield "|---" * (1 + 2 * len(lobes)) + "|"
        for value in dict.fromkeys(r["asked"] for r in found):
            cells = []
            for lobe in lobes:
                row = next(r for r in found if r["surface"] == lobe and r["asked"] == value)
                cells += [number(row["error"]), number(row["seconds"])]
            yield f"| {value} | " + " | ".join(cells) + " |"


# Estimators, what `asked` is, what error, second measure and seconds are.
TEXTURE_CURVES = [
    (["texel", "texel predicted"], "independent normals",
     "texels of a Gaussian surface (rms 0.3 µm, τ 3 µm, σ 1 µm): standard deviation of the logarithm of the mean width, as found and as texels "
     "predict it; bias against the whole area's fit; seconds a texel", "bias"),
    (["separable hann", "separable none", "joint hann"], "texels of a strip",
     "a strip along (correlation 8 texels) and one across (3), exponential: rms error of the texture's autocorrelation at lags up to 20 against "
     "the law, 16 strips each; relative error of the variance; seconds for 256² texels", "variance"),
    (["whole", "parts"], "texels a side",
     "relative error of the variance against the model's; of the mean in standard deviations; seconds", "mean"),
    (["levels"], "spread of centres, widths",
     "64 lobes refitted as one: divergence in nats; that of averaged parameters", "averaged"),
]


def texture_section(rows):
    yield "## Texels and textures"
    for estimators, asked, meaning, second in TEXTURE_CURVES:
        found = [r for r in rows if r["part"] == "texture" and r["estimator"] in estimators]
        if not found:
            continue
        yield from ["", f"**{', '.join(estimators)}**: {meaning}.", ""]
        yield f"| {asked} | " + " | ".join(f"{e}: error | {second} | seconds" for e in estimators) + " |"
        yield "|---" * (1 + 3 * len(estimators)) + "|"
        for value in dict.fromkeys(r["asked"] for r in found):
            cells = []
            for estimator in estimators:
                row = next(r for r in found if r["estimator"] == estimator and r["asked"] == value)
                cells += [number(row["error"]), number(row["error_core_free"]), number(row["seconds"])]
            yield f"| {value} | " + " | ".join(cells) + " |"


def main(csv_path, docs):
    with open(csv_path, newline="") as file:
        rows = list(csv.DictReader(file))
    docs = pathlib.Path(docs)
    kirchhoff = [r for r in rows if r["part"] == "kirchhoff"]
    draw_kirchhoff(kirchhoff, docs / "accuracy" / "kirchhoff.svg")
    text = "\n".join([
        "# Error against run time",
        "",
        "Measured by `bench/accuracy.sh` (which writes this file) on two cores of a 2.45 GHz EPYC with AVX2; the",
        "numbers are in [accuracy/error_vs_time.csv](accuracy/error_vs_time.csv). The made surfaces have 640 × 480",
        "points at 0.11 µm: smooth (rms 0.03 µm, τ 5 µm), rough (0.3, 3), steep (1, 1.5), holed (rough, 4 % of the",
        "points missing), brushed (scratches 50 µm long and 1.5 µm wide, rms 0.1 µm). The others are real scans.",
        "",
        kirchhoff_section(kirchhoff),
        "",
        *fit_section(rows),
        "",
        *brdf_section(rows),
        "",
        *texture_section(rows),
        "",
    ])
    (docs / "accuracy.md").write_text(text)


if __name__ == "__main__":
    main(*sys.argv[1:])
