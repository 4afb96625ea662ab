#!/usr/bin/python3
"""Checks `microbrdf info` against Gwyddion's library on scans, and times Gwyddion's local plane fit.

usage: gwyddion_statistics.py MICROBRDF SCAN...

Needs libgwyddion20-dev, libglib2.0-dev, gcc and numpy. Exits 1 if a number is out of tolerance.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

# Heights: both sum the same valid points in double; microbrdf stores them as float less their mean.
HEIGHT = 1e-5
# Sdq and Sdr over the project's triangles, by numpy from the levelled heights.
TRIANGLES = 1e-5
# Gwyddion's Sdq takes one-sided differences with all their pairs; over triangles, differences along a border count
# half, and those beside a hole fewer.
SLOPE, SLOPE_WITH_HOLES = 0.02, 0.05
# Gwyddion's area cuts each cell into four triangles about the mean of its corners, which smooths: the excess is up
# to a third smaller where noise dominates the slopes. Beside holes it counts triangles that have no height, so only
# complete scans are compared.
AREA = 0.35


def over_triangles(z, dx, dy):
    """Sdq and Sdr of the triangulation cut along the diagonal from (j, i) to (j+1, i+1)."""
    a, b, c, d = z[:-1, :-1], z[:-1, 1:], z[1:, 1:], z[1:, :-1]
    gradient = np.concatenate([(((b - a) / dx) ** 2 + ((c - b) / dy) ** 2).ravel(),
                               (((c - d) / dx) ** 2 + ((d - a) / dy) ** 2).ravel()])
    gradient = gradient[np.isfinite(gradient)]
    return {"Sdq": np.sqrt(gradient.mean()), "Sdr": np.expm1(0.5 * np.log1p(gradient)).mean()}


def build(folder):
    program = folder / "gwyddion_statistics"
    # gwyddion.pc asks for GTK, which is not needed here.
    flags = subprocess.run(["pkg-config", "--cflags", "--libs", "gobject-2.0"], capture_output=True, text=True,
                           check=True).stdout.split()
    include = pathlib.Path(subprocess.run(["pkg-config", "--variable=libdir", "gobject-2.0"], capture_output=True,
                                          text=True, check=True).stdout.strip()) / "gwyddion/include"
    subprocess.run(["gcc", "-O2", "-Wall", "-Wextra", "-o", program,
                    pathlib.Path(__file__).with_suffix(".c"), "-I/usr/include/gwyddion", f"-I{include}", *flags,
                    "-lgwyprocess2", "-lgwyddion2", "-lm"], check=True)
    return program


def main():
    microbrdf, *scans = sys.argv[1:]
    failures = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        program = build(folder)
        for scan in scans:
            done = subprocess.run([microbrdf, "info", "--json", scan], capture_output=True, text=True)
            if done.returncode != 0:
                print(f"{scan}: skipped, {done.stderr.strip()}")
                continue
            ours = json.loads(done.stdout)["scans"][0]
            subprocess.run([microbrdf, "convert", scan, "-o", folder / "z.npy"], capture_output=True, check=True)
            np.load(folder / "z.npy").astype("<f8").tofile(folder / "z.raw")
            shape = [str(ours[key]) for key in ("rows", "cols", "dx_um", "dy_um")]
            theirs = json.loads(subprocess.run([program, "statistics", folder / "z.raw", *shape],
                                               capture_output=True, text=True, check=True).stdout)
            subprocess.run([microbrdf, "convert", "--level", "plane", scan, "-o", folder / "level.npy"],
                           capture_output=True, check=True)
            exact = over_triangles(np.load(folder / "level.npy"), ours["dx_um"], ours["dy_um"])
            complete = ours["missing"] == 0
            print(scan)
            checks = [("Gwyddion", key, value, HEIGHT) for key, value in theirs.items() if key not in ("Sdq", "Sdr")]
            checks += [("Gwyddion", "Sdq", theirs["Sdq"], SLOPE if complete else SLOPE_WITH_HOLES)]
            checks += [("Gwyddion", "Sdr", theirs["Sdr"], AREA)] if complete else []
            checks += [("numpy", key, value, TRIANGLES) for key, value in exact.items()]
            for program_name, key, value, tolerance in checks:
                error = abs(ours[key] - value) / abs(value)
                good = error <= tolerance
                failures += not good
                print(f"  {key:6} {ours[key]:13.7g}  {program_name:8} {value:13.7g}  difference {error:8.1e}"
                      f"{'' if good else '  beyond ' + str(tolerance)}")
            if ours["rows"] * ours["cols"] == 640 * 480:
                seconds = subprocess.run([program, "time", folder / "z.raw", *shape], capture_output=True, text=True,
                                         check=True).stdout.strip()
                print(f"  Gwyddion fits 32-point local planes in {seconds} s of one CPU")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
