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


# microbrdf and FINUFFT at equal error: error of D; seconds and CPU seconds of FINUFFT, then of microbrdf. Measured
# by hand: the peer is no dependency.
PEER = [
    ("2.5e-3", 0.492, 0.926, 0.105, 0.207),
    ("1e-3", 0.581, 1.072, 0.105, 0.207),
    ("6e-4", 0.593, 1.115, 0.108, 0.214),
    ("2e-4", 0.614, 1.169, 0.115, 0.226),
]


def peer_section():
    yield from [
        "## D_K beside a general nonuniform FFT",
        "",
        "F is a type-3 nonuniform FFT of the edges' midpoints with three strengths, Σ a_T/3 of the triangles at an edge,",
        "and FINUFFT is a fast general program for that. It was built from its public source outside this repository",
        "(2.6.0-dev, commit 9810998d; its makefile's g++ 12 -O3 -march=native -fopenmp; DUCC 0.35 for its FFTs) and called in",
        "one process with `libmicro`, in turn, eleven times, two threads each; medians. One scan (`microbrdf synth gaussian",
        "--rows 480 --cols 640 --pitch 0.11um --rms 0.3um --tau 3um --seed 1`, its plane taken off), λ_q = 0.555 µm, all",
        "823,469 nodes; errors of both against the closed form on the same 1200 nodes, drawn by D², D and evenly. FINUFFT:",
        "single precision, dimension 3, ntransf 3, upsampfac 1.25, 1.3 or its own choice, whichever is cheapest, plan kept",
        "from run to run, its memory kept by malloc. microbrdf: `SpectralSolver`, with the measurement of its error. Times",
        "are interpolated (log-log) between measured points.",
        "",
        "| error of D | FINUFFT: seconds | CPU | microbrdf: seconds | CPU | times faster | by CPU |",
        "|---|---|---|---|---|---|---|",
    ]
    for error, peer, peer_cpu, ours, ours_cpu in PEER:
        yield (f"| {error} | {peer:.2f} | {peer_cpu:.2f} | {ours:.3f} | {ours_cpu:.2f} "
               f"| {peer / ours:.1f} | {peer_cpu / ours_cpu:.1f} |")
    yield from [
        "",
        "Measured: at eps 3e-3, 1e-3 and 1e-4, upsampfac 1.25, FINUFFT's error was 6.5e-3, 1.6e-3 and 1.6e-4 in 0.45, 0.52",
        "and 0.62 s; at tolerances 2.5e-3, 1e-3 and 6e-4 microbrdf's was 7.7e-4, 4.3e-4 and 2.1e-4 in 0.105, 0.112 and",
        "0.123 s (0.07 s without measuring it). What else was tried for FINUFFT: a plan made anew costs nothing measurable;",
        "malloc as it comes adds 0.14 to 0.2 s; FFTW 3.3.10 instead of DUCC is up to 20 % slower, its measured plans no",
        "better than estimated ones; upsampfac 1.5 takes at least 0.9 s with DUCC and 2.8 s with FFTW's estimated plans, 2",
        "at least 2.9 s and 22 s (one run each); other batch sizes, sorting and subproblem sizes are no faster. Release 2.4.1",
        "with FFTW took 1.2 s at 6e-4 (one run). Given microbrdf's own form of F (one strength and the rim,",
        "`kirchhoff/disk_transform.h`) FINUFFT takes 0.43 s at 1.7e-3 and 0.55 s at 4e-4: still 4 to 5 times as long.",
    ]


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
    ("brdf", "D_K albedo", "tolerance",
     "the same of a perfect mirror under D_K of a made surface (rms 0.3 µm, τ 3 µm; 1025² tables at 0.5 and 0.6 µm), over the tables and by draws: difference to the tables' at 3e-5"),
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


MEASURES = {
    "mean": "mean, σ", "variance": "variance", "axes": "spectra along axes", "plane": "2-D spectrum",
    "between": "between numbers", "between lagged": "… at other lags", "marginals": "marginals",
}


def recipe_section(rows):
    yield from [
        "", "## What each recipe of textures keeps", "",
        "Exemplars of 32 × 32 texels of 30 µm, cut from surfaces as `microbrdf synth` makes them: `brushed --length 2000um --width 3um --rms 0.2um",
        "--coverage 4 --spread 0.05` and `multiscale --tau-max 300um`; strips are four rows and four columns of them. Four textures of 256² texels",
        "each, how far they are from the exemplar on average: its mean (the number that is farthest off, in standard deviations), variance (the same,",
        "relative), autocorrelations (which are the spectra: rms over lags of 1 to 6 texels along the axes, up to 4 × 4 in the plane), correlations",
        "of the five numbers with one another (rms of ten; at lags of one texel, of 60), marginals (largest distance of distribution functions).",
        "Autocorrelations and correlations at other lags are the whole block's even where strips are all that a recipe saw. Another piece of the same",
        "finish differs by the last line: so well does so small an exemplar know its finish.",
    ]
    for surface in dict.fromkeys(r["surface"] for r in rows if r["part"] == "recipes"):
        found = [r for r in rows if r["part"] == "recipes" and r["surface"] == surface]
        yield from ["", f"| {surface} | " + " | ".join(MEASURES.values()) + " |", "|---" * (1 + len(MEASURES)) + "|"]
        for way in dict.fromkeys(r["note"] for r in found):
            value = {r["estimator"]: number(r["error"]) for r in found if r["note"] == way}
            yield f"| {way.replace(';', ',')} | " + " | ".join(value[m] for m in MEASURES) + " |"


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
        *peer_section(),
        "",
        *fit_section(rows),
        "",
        *brdf_section(rows),
        "",
        *texture_section(rows),
        *recipe_section(rows),
        "",
    ])
    (docs / "accuracy.md").write_text(text)


if __name__ == "__main__":
    main(*sys.argv[1:])
