#!/usr/bin/python3
"""Reads what `microbrdf brdf --write` writes, by the formats' own specifications: brdf_files.py MICROBRDF

RGL's tensor file [Dupuy, Jakob 2018], MERL's binary [Matusik et al. 2003], ASTM text and WINDOW's matrix in the
Klems basis, field by field, and the reflectance in them against [Dong15 Eqs. 1, 10-14] written here once more."""
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

try:
    import numpy as np
except ImportError:
    print("SKIPPED: /usr/bin/python3 has no numpy")
    sys.exit(77)

PI = np.pi
# What the formats' own steps leave of f, as a root of the mean squared relative error (the matrix: relative L2 by
# 625 points a pair of patches). Measured: 0.0004, 0.014, 0.027 (0.0001 in the mean), 0.017 (0.01 by 10,000 points).
TENSOR_ROUND, TENSOR_SKEWED, MERL_BINS, MERL_BIAS, KLEMS_NOISE = 0.002, 0.03, 0.05, 0.005, 0.03
# Copper of Johnson and Christy at three of their wavelengths (um).
COPPER = {0.4509: 1.24 + 2.397j, 0.5486: 1.02 + 2.577j, 0.6595: 0.22 + 3.747j}
INDEX = 0.27 + 3.4j
ROUND = (0.2, 0.2, 0, 0, 0)
SKEWED = (0.3, 0.15, *np.radians((6, -11, 20)))
RINGS = ((0, 5, 1), (5, 15, 8), (15, 25, 16), (25, 35, 20), (35, 45, 24), (45, 55, 24), (55, 65, 24), (65, 75, 16), (75, 90, 12))


def expect(fact, sentence):
    if not fact:
        sys.exit(f"FAILED: {sentence}")


def direction(theta, phi):
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


def fresnel(cosine, n):
    root = np.sqrt(n * n - 1 + cosine * cosine)
    s, p = (cosine - root) / (cosine + root), (n * n * cosine - root) / (n * n * cosine + root)
    return (abs(s) ** 2 + abs(p) ** 2) / 2


def reflectance(parameters, n, wi, wo):
    """f of an ellipsoid [Dong15 Eqs. 1, 10-14]; n None: a perfect mirror."""
    ax, ay, x, y, z = parameters
    rx = np.array([[1, 0, 0], [0, np.cos(x), -np.sin(x)], [0, np.sin(x), np.cos(x)]])
    ry = np.array([[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]])
    rz = np.array([[np.cos(z), -np.sin(z), 0], [np.sin(z), np.cos(z), 0], [0, 0, 1]])
    a = np.diag([ax, ay, 1]) @ rx @ ry @ rz
    an = np.linalg.norm(a[:, 2])
    h = wi + wo
    h = h / np.linalg.norm(h, axis=-1, keepdims=True)
    d = 1 / (PI * np.linalg.det(a) * an * np.linalg.norm(h @ np.linalg.inv(a), axis=-1) ** 4)

    def g1(u):
        au = u @ a.T
        return np.minimum(1, 2 * an ** 2 * u[..., 2] / (an * np.linalg.norm(au, axis=-1) + au @ a[:, 2]))

    f = d * g1(wi) * g1(wo) / (4 * wi[..., 2] * wo[..., 2])
    return f if n is None else f * fresnel((wi * h).sum(-1), n)


def pairs(parameters, count, steepest=1.3):
    """Light from all sides and viewers where the lobe sends it."""
    random = np.random.default_rng(3)
    wi = direction(steepest * random.random(count), 2 * PI * random.random(count))
    slopes = random.normal(0, 0.6 * max(parameters[:2]), (count, 2))
    h = np.column_stack([slopes, np.ones(count)])
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    cosine = (wi * h).sum(1)
    wo = 2 * cosine[:, None] * h - wi
    seen = (cosine > 0) & (wo[:, 2] > 0.1)
    return wi[seen], wo[seen]


def rms_of_relative(found, wanted):
    return np.sqrt(np.mean((found / wanted - 1) ** 2))


def check_header(text, name):
    for part in ("model: ", "material: ", "1/sr", "solid angle", "wavelengths (um): ", "command: microbrdf brdf"):
        expect(part in text, f"{name}: its header has no '{part}'")
    expect(re.search(r"microbrdf \d+\.\d+\.\d+, \d{4}-\d\d-\d\dT", text), f"{name}: its header has no version and date")


# ---- RGL's tensor file


def read_tensors(path):
    data = path.read_bytes()
    expect(data[:12] == b"tensor_file\0" and data[12:14] == b"\1\0", f"{path.name}: no tensor file of version 1.0")
    (count,) = struct.unpack_from("<I", data, 14)
    at, tensors, used = 18, {}, []
    for _ in range(count):
        (length,) = struct.unpack_from("<H", data, at)
        name = data[at + 2:at + 2 + length].decode()
        at += 2 + length
        dimensions, kind, offset = struct.unpack_from("<HBQ", data, at)
        shape = struct.unpack_from(f"<{dimensions}Q", data, at + 11)
        at += 11 + 8 * dimensions
        dtype = np.dtype({1: "u1", 10: "<f4", 11: "<f8"}[kind])
        size = int(np.prod(shape)) * dtype.itemsize
        expect(offset + size <= len(data), f"{path.name}: {name} ends beyond the file")
        used.append((offset, offset + size))
        tensors[name] = np.frombuffer(data, dtype, int(np.prod(shape)), offset).reshape(shape)
    used.sort()
    expect(used[0][0] >= at and all(a[1] <= b[0] for a, b in zip(used, used[1:])), f"{path.name}: fields overlap")
    return tensors


def check_tensors(t, name, wavelengths_nm):
    check_header(t["description"].tobytes().decode(), name)
    phi, theta = len(t["phi_i"]), len(t["theta_i"])
    lead, colours = (phi, theta), len(wavelengths_nm)
    expect(t["jacobian"].tolist() == [1], f"{name}: jacobian")
    expect(np.all(np.diff(t["theta_i"]) > 0) and 0 <= t["theta_i"][0] and t["theta_i"][-1] < PI / 2, f"{name}: theta_i")
    expect(phi == 1 or np.allclose(t["phi_i"][[0, -1]], (-PI, PI)), f"{name}: phi_i is not the whole turn")
    expect(np.allclose(t["wavelengths"], wavelengths_nm), f"{name}: wavelengths in nm")
    expect(t["ndf"].ndim == t["sigma"].ndim == 2 and t["vndf"].shape[:2] == lead, f"{name}: ndf, sigma, vndf")
    side = t["luminance"].shape[-1]
    expect(t["luminance"].shape == (*lead, side, side), f"{name}: luminance")
    expect(t["spectra"].shape == (*lead, colours, side, side), f"{name}: spectra")
    for field in ("ndf", "sigma", "vndf", "luminance", "spectra"):
        expect(np.all(np.isfinite(t[field])) and np.all(t[field] >= 0), f"{name}: {field} has what is no reflectance")


def interval(u, nodes):
    k = min(int(u * (nodes - 1)), nodes - 2)
    return k, u * (nodes - 1) - k


def bilinear(table, x, y):
    (i, s), (j, t) = interval(x, table.shape[-1]), interval(y, table.shape[-2])
    return ((1 - t) * ((1 - s) * table[..., j, i] + s * table[..., j, i + 1])
            + t * ((1 - s) * table[..., j + 1, i] + s * table[..., j + 1, i + 1]))


def mixed(table, t, theta, phi, normalised):
    """The table at a direction of light, linear between those it has."""
    if normalised:
        w = [np.pad(np.ones(n - 2), 1, constant_values=0.5) for n in table.shape[-2:]]
        table = table / np.einsum("...ji,j,i->...", table.astype(float), *w)[..., None, None]
    k = min(np.searchsorted(t["theta_i"], theta, side="right") - 1, len(t["theta_i"]) - 2)
    s = (theta - t["theta_i"][k]) / (t["theta_i"][k + 1] - t["theta_i"][k])
    along = (1 - s) * table[:, k] + s * table[:, k + 1]
    if len(t["phi_i"]) == 1:
        return along[0]
    j = min(np.searchsorted(t["phi_i"], phi, side="right") - 1, len(t["phi_i"]) - 2)
    r = (phi - t["phi_i"][j]) / (t["phi_i"][j + 1] - t["phi_i"][j])
    return (1 - r) * along[j] + r * along[j + 1]


def cumulated(values, u):
    """Integral of the piecewise linear function up to u, as a share of the whole."""
    k, s = interval(u, len(values))
    parts = (values[1:] + values[:-1]) / 2
    return (parts[:k].sum() + s * values[k] + s * s / 2 * (values[k + 1] - values[k])) / parts.sum()


def evaluate_tensors(t, wi, wo):
    """f times the cosine of wo at each wavelength."""
    h = wi + wo
    h /= np.linalg.norm(h)
    theta_i, phi_i = np.arccos(wi[2]), np.arctan2(wi[1], wi[0])
    phi_m = np.arctan2(h[1], h[0]) - (phi_i if len(t["phi_i"]) == 1 else 0)
    u = np.sqrt(np.arccos(min(1, h[2])) * 2 / PI), ((phi_m + PI) / (2 * PI)) % 1
    visible = mixed(t["vndf"].astype(float), t, theta_i, phi_i, True)
    row, s = interval(u[1], visible.shape[0])
    across = (1 - s) * visible[row] + s * visible[row + 1]
    weights = np.pad(np.ones(visible.shape[1] - 2), 1, constant_values=0.5)
    x, y = cumulated(across, u[0]), cumulated(visible @ weights, u[1])
    spectra = mixed(t["spectra"].reshape(len(t["phi_i"]), len(t["theta_i"]), *t["spectra"].shape[2:]), t, theta_i, phi_i, False)
    sigma = bilinear(t["sigma"], np.sqrt(theta_i * 2 / PI), (phi_i + PI) / (2 * PI))
    return bilinear(spectra, x, y) * bilinear(t["ndf"], *u) / (4 * sigma)


def check_bsdf(path, parameters, indices, most):
    t = read_tensors(path)
    check_tensors(t, path.name, [1000 * k for k in indices])
    wi, wo = pairs(parameters, 60)
    found = np.array([evaluate_tensors(t, a, b) for a, b in zip(wi, wo)])
    for c, n in enumerate(indices.values()):
        error = rms_of_relative(found[:, c], reflectance(parameters, n, wi, wo) * wo[:, 2])
        expect(error < most, f"{path.name}: f is off by {error:.3g} at wavelength {c}")


# ---- MERL's binary


def turned(v, axis, angle):
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return c * v + s * np.cross(axis, v) + (1 - c) * (v @ axis)[:, None] * axis


def merl_bins(wi, wo):
    """The published look-up: the half vector turned onto the normal, then the difference vector's angles."""
    h = wi + wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    theta_h, phi_h = np.arccos(h[:, 2]), np.arctan2(h[:, 1], h[:, 0])
    d = turned(turned(wi, np.array([0., 0, 1]), -phi_h), np.array([0., 1, 0]), -theta_h)
    theta_d, phi_d = np.arccos(np.minimum(1, d[:, 2])), np.arctan2(d[:, 1], d[:, 0]) % PI
    i = np.minimum(89, (90 * np.sqrt(theta_h / (PI / 2))).astype(int))
    return i, np.minimum(89, (theta_d / (PI / 2) * 90).astype(int)), np.minimum(179, (phi_d / PI * 180).astype(int))


def check_merl(path, parameters):
    data = path.read_bytes()
    expect(struct.unpack_from("<3i", data) == (90, 90, 180), f"{path.name}: its dimensions")
    table = np.frombuffer(data, "<f8", offset=12)
    expect(table.size == 3 * 90 * 90 * 180, f"{path.name}: its size")
    table = table.reshape(3, 90, 90, 180)
    expect(np.all((table >= 0) | (table == -1)), f"{path.name}: neither a reflectance nor below the horizon")
    expect(np.array_equal(table[0] == -1, table[2] == -1), f"{path.name}: colours with horizons of their own")
    wi, wo = pairs(parameters, 4000, 1.1)
    wanted, bins = reflectance(parameters, None, wi, wo), merl_bins(wi, wo)
    for c, scale in enumerate((1 / 1500, 1.15 / 1500, 1.66 / 1500)):
        found = table[(c, *bins)] * scale
        error, bias = rms_of_relative(found, wanted), np.mean(found / wanted) - 1
        expect(error < MERL_BINS, f"{path.name}: f is off by {error:.3g} in colour {c}")
        expect(abs(bias) < MERL_BIAS, f"{path.name}: f is off by {bias:.3g} in the mean of colour {c}")
    check_header(pathlib.Path(f"{path}.txt").read_text(), f"{path.name}.txt")


# ---- ASTM's text


def check_astm(path, parameters, indices, rows):
    lines = path.read_text().splitlines()
    expect(lines[0] == "ASTM E1392-90", f"{path.name}: its first line")
    check_header("\n".join(line for line in lines if line.startswith("#")), path.name)
    begin = next(k for k, line in enumerate(lines) if line.startswith("VARS "))
    names = lines[begin][5:].split(",")
    expect(names == ["theta_i", "phi_i", "theta_s", "phi_s"] + [f"BRDF {1000 * k:g} nm" for k in indices], f"{path.name}: VARS")
    table = np.array([[float(v) for v in line.split(",")] for line in lines[begin + 1:]])
    expect(lines[begin - 1] == f"NUM_POINTS {len(table)}" and len(table) == rows, f"{path.name}: {len(table)} rows")
    angles = np.radians(table[:, :4])
    wi, wo = direction(angles[:, 0], angles[:, 1]), direction(angles[:, 2], angles[:, 3])
    for c, n in enumerate(indices.values()):
        wanted = reflectance(parameters, n, wi, wo)
        expect(np.all(abs(table[:, 4 + c] - wanted) <= 1e-6 * wanted), f"{path.name}: values of wavelength {c}")


# ---- WINDOW's matrix, as Radiance reads it


def patch_points(theta_low, theta_high, phi, width, side):
    """Points of a patch, each of the same projected solid angle."""
    part = (np.arange(side) + 0.5) / side
    low, high = np.sin(np.radians(theta_low)) ** 2, np.sin(np.radians(theta_high)) ** 2
    sine, angle = np.meshgrid(np.sqrt(low + (high - low) * part), phi + width * (part - 0.5), indexing="ij")
    return direction(np.arcsin(sine), angle).reshape(-1, 3)


def klems_points(side):
    return np.concatenate([patch_points(low, high, 2 * PI * k / n, 2 * PI / n, side) for low, high, n in RINGS for k in range(n)])


def check_klems(path, parameters, n):
    check_header(path.read_text(), path.name)
    space = "{http://windows.lbl.gov}"
    layer = xml.etree.ElementTree.parse(path).getroot().find(f"{space}Optical/{space}Layer")

    def text(node, *names):
        return node.findtext("/".join(space + name for name in names))

    expect(text(layer, "DataDefinition", "IncidentDataStructure") == "Columns", f"{path.name}: its data structure")
    blocks = layer.iter(space + "AngleBasisBlock")
    rings = [(float(text(b, "ThetaBounds", "LowerTheta")), float(text(b, "ThetaBounds", "UpperTheta")), int(text(b, "nPhis")))
             for b in blocks]
    expect(rings == list(RINGS), f"{path.name}: its basis is not that of Klems")
    found = {}
    for data in layer.iter(space + "WavelengthData"):
        expect((text(data, "LayerNumber"), text(data, "Wavelength")) == ("System", "Visible"), f"{path.name}: whose data these are")
        block = data.find(space + "WavelengthDataBlock")
        for axis in ("ColumnAngleBasis", "RowAngleBasis"):
            expect(text(block, axis) == text(layer, "DataDefinition", "AngleBasis", "AngleBasisName"), f"{path.name}: {axis}")
        expect(text(block, "ScatteringDataType") == "BRDF", f"{path.name}: its data type")
        values = [float(v) for v in text(block, "ScatteringData").replace(",", " ").split()]
        found[text(block, "WavelengthDataDirection")] = np.array(values).reshape(145, 145)
    expect(set(found) == {"Reflection Front", "Reflection Back"}, f"{path.name}: its directions {list(found)}")
    # Light is numbered by where it goes: patch k of wi and of wo are opposite in azimuth.
    points = klems_points(5)
    wanted = np.column_stack([
        reflectance(parameters, n, (patch * (-1, -1, 1))[:, None], points[None]).mean(0).reshape(145, -1).mean(1)
        for patch in points.reshape(145, -1, 3)])
    error = np.linalg.norm(found["Reflection Front"] - wanted) / np.linalg.norm(wanted)
    expect(error < KLEMS_NOISE, f"{path.name}: the matrix is off by {error:.3g}")


def main():
    microbrdf = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)

        def write(lobe, *arguments):
            subprocess.run([microbrdf, "brdf", *lobe, *arguments, "--no-figure", "-o", "out.h5"], cwd=folder, check=True,
                           stdout=subprocess.DEVNULL)

        light = ("--wi", "30deg", "--azimuth", "20deg", "--plane", "0", "--plane", "70deg")
        copper = [part for length in COPPER for part in ("--lambda", str(length))]
        write(("--alpha", "0.2"), "--material", "Cu", *copper, *light, "--write", "cu.bsdf", "--write", "cu.astm")
        check_bsdf(folder / "cu.bsdf", ROUND, COPPER, TENSOR_ROUND)
        check_astm(folder / "cu.astm", ROUND, COPPER, 2 * 1799)
        write(("--alpha", "0.2"), "--lambda", "550nm", "--write", "mirror.binary")
        check_merl(folder / "mirror.binary", ROUND)
        skewed, index = ("--alpha", "0.3,0.15", "--theta", "6deg,-11deg,20deg"), {0.55: INDEX}
        write(skewed, "--material", "0.27,3.4", "--lambda", "550nm", *light, "--wi", "0", *(
            part for file in ("skewed.bsdf", "skewed.astm", "skewed.xml") for part in ("--write", file)))
        check_bsdf(folder / "skewed.bsdf", SKEWED, index, TENSOR_SKEWED)
        check_astm(folder / "skewed.astm", SKEWED, index, 4 * 1799)
        check_klems(folder / "skewed.xml", SKEWED, INDEX)


if __name__ == "__main__":
    main()
