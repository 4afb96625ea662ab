#!/usr/bin/python3
"""Reciprocity and white furnace of the BRDFs of scans, as a table between two marks of a page.

furnace.py MICROBRDF PAGE SCAN..."""
import json
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy as np

MARKS = "<!-- furnace of scans -->", "<!-- end of furnace -->"
MODELS = (("filtered", "smith"), ("kirchhoff", "smith"), ("kirchhoff", "none"))
LAMBDA_Q = 0.555
DEGREES = (0, 30, 60, 75, 85)
HEAD = ("| scan | pitch, σ (µm) | D, G | sinθ up to | ∫D m_z dω | reciprocal to | "
        + " | ".join(f"{d}°" for d in DEGREES) + " | most |\n" + "|---" * (7 + len(DEGREES)) + "|\n")


def run(*arguments):
    """What the program answers: its --json, also where it failed."""
    done = subprocess.run([*map(str, arguments), "--json"], capture_output=True, text=True, check=False)
    return json.loads(done.stdout)


def ndf(microbrdf, scan, pitch, sigma, output):
    """Both distributions, zoomed in on what holds their energy. Where a tilt or a curved form reaches beyond the
    first false order, out to nine tenths of it, without the form."""
    command = (microbrdf, "ndf", scan, "--method", "filtered", "--method", "kirchhoff", "--sigma", f"{sigma}um",
               "-o", output, "--extent")
    made = run(*command, "auto")
    return made if made.get("scans") else run(*command, min(1, 0.45 * LAMBDA_Q / pitch), "--level", "quadratic")


def row(microbrdf, result, method, masking, folder):
    output = folder / "furnace.h5"
    waves = ("--masking", masking) if method["method"] == "kirchhoff" else ()
    run(microbrdf, "brdf", result, "--distribution", method["method"], *waves, "--lambda", f"{LAMBDA_Q}um", "--furnace",
        "--tol", "0.01", "--no-figure", "-o", output)
    with h5py.File(output) as file:
        furnace = file["/brdf/furnace"]
        theta = np.degrees(np.arccos(np.clip(furnace["wi"][:, 2], -1, 1)))
        albedo, attributes = furnace["value"][:], dict(furnace.attrs)
    largest = [albedo[np.abs(theta - d) < 0.01].max() for d in DEGREES]
    name = "D_M" if method["method"] == "filtered" else "D_K"
    return (f"{name}, {'Smith' if masking == 'smith' else 'G = 1'} | {method['extent']:.3g} | "
            f"{method['normalization']:.3f} | {attributes['reciprocity']:.0e} | "
            + " | ".join(f"{a:.3f}" for a in largest) + f" | {attributes['most']:.3f}")


def rows_of(microbrdf, scan, folder):
    info = run(microbrdf, "info", scan)["scans"][0]
    pitch = max(info["dx_um"], info["dy_um"])
    sigma, result = max(1, pitch), folder / "result.h5"
    made = ndf(microbrdf, scan, pitch, sigma, result)
    if not made.get("scans"):
        return f"| {scan.name} | {pitch:.3g}, {sigma:.3g} | {made['failed'][0]['message']} |\n"
    methods = {method["method"]: method for method in made["methods"]}
    text, begin = "", f"| {scan.name} | {pitch:.3g}, {sigma:.3g} | "
    for method, masking in MODELS:
        text += begin + row(microbrdf, result, methods[method], masking, folder) + " |\n"
        begin = "| | | "
    return text


def main():
    microbrdf, page, scans = sys.argv[1], pathlib.Path(sys.argv[2]), map(pathlib.Path, sys.argv[3:])
    with tempfile.TemporaryDirectory() as folder:
        table = HEAD + "".join(rows_of(microbrdf, scan, pathlib.Path(folder)) for scan in scans)
    before, rest = page.read_text().split(MARKS[0])
    after = rest.split(MARKS[1])[1]
    page.write_text(f"{before}{MARKS[0]}\n{table}{MARKS[1]}{after}")


main()
