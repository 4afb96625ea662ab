#!/usr/bin/python3
"""Tries `microbrdf texture` on scans made here and reads its files by their own specifications: texture_files.py MICROBRDF

Texels against slopes computed here, textures against spectra taken here, coarser levels (of an OpenEXR file read byte
by byte) against the lobe of least Kullback-Leibler divergence, found by Newton's method on slopes drawn from the finest
texels."""
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

try:
    import h5py
    import numpy as np
except ImportError:
    print("SKIPPED: /usr/bin/python3 has no h5py")
    sys.exit(77)

# Points in um, not square; points of a texel along x and y.
DX, DY, COLS, ROWS = 0.3, 0.2, 60, 75
NAMES = ("alpha.x", "alpha.y", "theta.x", "theta.y", "theta.z")
# Numbers in files are float32; spectra of them are as good.
FLOAT, SPECTRUM = 1e-5, 2e-3
# A coarse lobe's widths, centre (in widths) and divergence (of itself, on average) beside the best one's. Measured: 0.008,
# 0.001, 0.004.
WIDTHS, CENTRE, DIVERGENCE = 0.02, 0.005, 0.02
# A level's misfit is a mean over some of its texels, good to a tenth of itself.
MISFIT = 0.1


def expect(fact, sentence):
    if not fact:
        sys.exit(f"FAILED: {sentence}")


def rough(random, rows, cols, tau=2.5):
    """A Gaussian surface of unit rms."""
    kx, ky = 2 * np.pi * np.fft.rfftfreq(cols, DX), 2 * np.pi * np.fft.fftfreq(rows, DY)[:, None]
    z = np.fft.irfft2(np.fft.rfft2(random.normal(size=(rows, cols))) * np.exp(-(kx**2 + ky**2) * tau**2 / 8), (rows, cols))
    return z / z.std()


def filtered_slopes(z):
    """Slopes of the plane fitted about each point with weights exp(-r^2/2)."""
    x, y = np.arange(-20, 21) * DX, np.arange(-30, 31) * DY

    def moment(field, p, q):
        rows = np.apply_along_axis(np.convolve, 1, field, (x**p * np.exp(-x**2 / 2))[::-1], "full")[:, 20:-20]
        return np.apply_along_axis(np.convolve, 0, rows, (y**q * np.exp(-y**2 / 2))[::-1], "full")[30:-30]

    powers = ((0, 0), (1, 0), (0, 1))
    there = np.ones_like(z)
    left = np.moveaxis(np.array([[moment(there, p + r, q + s) for p, q in powers] for r, s in powers]), (0, 1), (2, 3))
    plane = np.linalg.solve(left, np.stack([moment(z, p, q) for p, q in powers], -1)[..., None])[..., 0]
    return plane[..., 1], plane[..., 2]


def ggx_over_gauss():
    """Width of the GGX nearest to a Gaussian of slopes, in root mean square, over the Gaussian's sigma."""
    q = (np.arange(40000) + 0.5) / 1000  # squared radius over sigma^2

    def cost(s):
        return ((1 / (s * (1 + q / s) ** 2) - np.exp(-q / 2) / 2) ** 2).sum()

    widths = np.arange(0.8, 2, 0.001)
    return widths[np.argmin([cost(w * w) for w in widths])]


def frames(parameters):
    """Location and scale of the slopes of ellipsoids [Dong15 Eqs. 10-12]: C = (A'A)^-1, t = C_xx^-1 c_x."""
    shape = parameters.shape[:-1]
    ax, ay, x, y, z = parameters.reshape(-1, 5).astype(float).T
    o, e = np.zeros_like(ax), np.ones_like(ax)

    def matrix(*numbers):
        return np.moveaxis(np.array(numbers).reshape(3, 3, -1), 2, 0)

    a = (matrix(ax, o, o, o, ay, o, o, o, e) @ matrix(e, o, o, o, np.cos(x), -np.sin(x), o, np.sin(x), np.cos(x))
         @ matrix(np.cos(y), o, np.sin(y), o, e, o, -np.sin(y), o, np.cos(y))
         @ matrix(np.cos(z), -np.sin(z), o, np.sin(z), np.cos(z), o, o, o, e))
    c = np.linalg.inv(np.swapaxes(a, 1, 2) @ a)
    inverse = np.linalg.inv(c[:, :2, :2])
    location = np.einsum("nij,nj->ni", inverse, c[:, :2, 2])
    return location.reshape(*shape, 2), (inverse / (a[:, :, 2] ** 2).sum(1)[:, None, None]).reshape(*shape, 2, 2)


def matrices(scale):
    return scale[..., [0, 1, 1, 2]].astype(float).reshape(*scale.shape[:-1], 2, 2)


def coordinates(location, scale):
    """Location and half the logarithm of scale: the five numbers that are synthesised."""
    values, vectors = np.linalg.eigh(matrices(scale))
    log = np.einsum("...ij,...j,...kj->...ik", vectors, np.log(values) / 2, vectors)
    return np.stack([location[..., 0], location[..., 1], log[..., 0, 0], log[..., 0, 1], log[..., 1, 1]])


def read_exr(path):
    """Header and levels of a tiled, mip-mapped, ZIP-compressed OpenEXR file (openexr.com, OpenEXR file layout)."""
    data = path.read_bytes()
    magic, version = struct.unpack_from("<II", data)
    expect(magic == 20000630 and version == 0x202, "the texture is no tiled OpenEXR file of version 2")
    at, header = 8, {}

    def word():
        nonlocal at
        end = data.index(b"\0", at)
        text, at = data[at:end].decode(), end + 1
        return text

    while data[at]:
        name, kind = word(), word()
        (size,) = struct.unpack_from("<I", data, at)
        header[name] = data[at + 4:at + 4 + size]
        if kind == "string":
            header[name] = header[name].decode()
        at += 4 + size
    at += 1
    channels, place, listed = [], 0, header["channels"]
    while listed[place]:
        end = listed.index(b"\0", place)
        channels.append((listed[place:end].decode(), struct.unpack_from("<i", listed, end + 1)[0]))
        place = end + 17
    x0, y0, x1, y1 = struct.unpack("<iiii", header["dataWindow"])
    wide, high, mode = struct.unpack("<IIB", header["tiles"])
    expect(mode == 0x11 and header["compression"] == b"\3", "the texture's levels are not rounded up, or not ZIP")
    shapes = [(y1 - y0 + 1, x1 - x0 + 1)]
    while max(shapes[-1]) > 1:
        shapes.append(tuple((n + 1) // 2 for n in shapes[-1]))
    tiles = sum(-(-h // high) * -(-w // wide) for h, w in shapes)
    levels = [np.full((*shape, len(channels)), np.nan, np.float32) for shape in shapes]
    for offset in struct.unpack_from(f"<{tiles}Q", data, at):
        i, j, level, _, size = struct.unpack_from("<iiiii", data, offset)
        raw = data[offset + 20:offset + 20 + size]
        h, w = min(high, shapes[level][0] - j * high), min(wide, shapes[level][1] - i * wide)
        kinds = [np.dtype("<f2" if kind == 1 else "<f4") for _, kind in channels]
        if size < h * w * sum(kind.itemsize for kind in kinds):
            coded = np.frombuffer(zlib.decompress(raw), np.uint8).astype(np.int64)
            coded[1:] -= 128
            plain = np.cumsum(coded) & 255
            bytes_ = np.empty(len(plain), np.uint8)
            bytes_[0::2], bytes_[1::2] = plain[:(len(plain) + 1) // 2], plain[(len(plain) + 1) // 2:]
            raw = bytes_.tobytes()
        row = np.dtype([(name, kind, (w,)) for (name, _), kind in zip(channels, kinds)])
        values = np.frombuffer(raw, row, h)
        for c, (name, _) in enumerate(channels):
            levels[level][j * high:j * high + h, i * wide:i * wide + w, c] = values[name]
    return header, channels, levels


def drawn(location, scale, rings, angles):
    """Slopes that stand for lobes: |v|^2 = u/(1 - u), u uniform."""
    u, phi = (np.arange(rings) + 0.5) / rings, 2 * np.pi * (np.arange(angles) + 0.37) / angles
    r = np.sqrt(u / (1 - u))
    v = np.stack([np.outer(r, np.cos(phi)).ravel(), np.outer(r, np.sin(phi)).ravel()], 1)
    return (location[:, None] + np.einsum("nij,kj->nki", np.linalg.cholesky(scale), v)).reshape(-1, 2)


def density(slopes, location, scale):
    away = slopes - location
    return 1 / (np.pi * np.sqrt(np.linalg.det(scale)) * (1 + np.einsum("ki,ij,kj->k", away, np.linalg.inv(scale), away)) ** 2)


def step_to_best(slopes, location, scale):
    """Step (centre, log widths, shear) from a lobe to the likeliest one of slopes by Newton's method on numeric
    derivatives, and what it gains in nats."""
    x = (slopes - location) @ np.linalg.inv(np.linalg.cholesky(scale)).T
    h = 1e-3 * np.eye(5)

    def cost(p):
        b = (x[:, 1] - p[1] - p[3] * (x[:, 0] - p[0]) * np.exp(-p[2])) * np.exp(-p[4])
        return p[2] + p[4] + 2 * np.log1p(((x[:, 0] - p[0]) * np.exp(-p[2])) ** 2 + b * b).mean()

    p = np.zeros(5)
    for _ in range(8):
        gradient = np.array([cost(p + e) - cost(p - e) for e in h]) / 2e-3
        curvature = np.array([[cost(p + d + e) - cost(p + d - e) - cost(p - d + e) + cost(p - d - e) for d in h] for e in h]) / 4e-6
        step = np.linalg.solve(curvature, gradient)
        p = p - step
        if np.abs(step).max() < 1e-6:
            break
    return p, cost(np.zeros(5)) - cost(p)


def run(*arguments):
    done = subprocess.run([microbrdf, "texture", *map(str, arguments), "--json"], capture_output=True, text=True, timeout=60)
    expect(done.returncode == 0, f"{arguments}: {done.stderr}")
    return json.loads(done.stdout)


def texels_of(file):
    return coordinates(file["texels/location"][:], file["texels/scale"][:])


def check_cross(folder):
    """Scans as texels of a cross with a gap, by a manifest."""
    random = np.random.default_rng(7)
    places = [(4, k) for k in range(3, 15) if k != 9] + [(k, 8) for k in range(12) if k != 4]
    scans, lines, slopes = [], ["# strips of a cross", ""], {}
    for n, (row, col) in enumerate(places):
        z = 0.25 * np.exp(0.3 * np.sin(0.7 * col) + 0.2 * np.cos(row)) * rough(random, ROWS, COLS)
        path = folder / f"{n:02d}, scan.npy"
        np.save(path, z.astype(np.float32))
        scans.append(path)
        lines.append(f"{path},{row},{col}")
        slopes[row, col - 3] = z
    (folder / "places.csv").write_text("\n".join(lines))
    said = run(*scans, "--manifest", folder / "places.csv", "--pitch", f"{DX}um,{DY}um", "--size", "45x33", "-o", folder / "cross",
               "--recipe", "separable", "--marginals", "gaussian", "--enough", 10)
    with h5py.File(folder / "cross/texture.h5") as file:
        texels, numbers = file["texels"], file["texels/scan"][:]
        expect(numbers.shape == (12, 12) and (numbers >= 0).sum() == 22, "the cross is not where the manifest says")
        expect(all(numbers[row, col - 3] == n for n, (row, col) in enumerate(places)), "a scan lies at another's place")
        expect(((texels["state"][:] == -1) == (numbers < 0)).all(), "gaps are not where no scan is")
        expect(abs(texels.attrs["texel_width_um"] - COLS * DX) + abs(texels.attrs["texel_height_um"] - ROWS * DY) < 1e-6, "texel size")
        independent = texels["independent_normals"][:][numbers >= 0]
        expect(np.allclose(independent, COLS * DX * ROWS * DY / (4 * math.pi), rtol=1e-5), "independent normals")
        location, scale = frames(texels["parameters"][:][numbers >= 0])
        stored = matrices(texels["scale"][:][numbers >= 0])
        expect(np.abs(location - texels["location"][:][numbers >= 0]).max() < FLOAT and np.abs(scale / stored - 1)[:, [0, 1], [0, 1]].max() < 30 * FLOAT,
               "parameters are not the lobe of location and scale")
        # Widths against the scatter of slopes, and against each other.
        ratio = []
        for j, i in slopes:
            zx, zy = filtered_slopes(slopes[j, i])
            covariance = np.cov(zx.ravel(), zy.ravel())
            ratio.append(np.log(np.linalg.det(matrices(texels["scale"][j, i])) / np.linalg.det(covariance)) / 4)
        expect(abs(np.exp(np.mean(ratio)) / ggx_over_gauss() - 1) < 0.1 and np.std(ratio) < 0.25,
               f"widths over the scatter of slopes: {np.exp(np.mean(ratio)):.3f} +- {np.std(ratio):.3f}, not {ggx_over_gauss():.3f}")
        check_spectra(file, numbers)
    expect(any(s["stage"] == "texture" and "from 1 strip along x and 1 strip along y" in s["reason"] for s in said["plan"]), "the plan's strips")
    check_levels(folder / "cross")


def check_spectra(file, numbers):
    """Mean and variance are the exemplar's; in two dimensions the spectrum is a product."""
    exemplar, texture = texels_of(file)[:, numbers >= 0], coordinates(file["texture/location"][:], file["texture/scale"][:])
    for measured, made in zip(exemplar, texture):
        expect(abs(made.mean() - measured.mean()) < 10 * FLOAT * measured.std() + FLOAT * abs(measured.mean()), "the texture's mean")
        expect(abs(made.std() / measured.std() - 1) < 1e-3, "the texture's variance")
        power = np.abs(np.fft.fft2(made - made.mean())) ** 2
        row, col = power[1, 1:], power[1:, 1]
        expect(np.abs(power[1:, 1:] - np.outer(col, row) / power[1, 1]).max() < SPECTRUM * power[1:, 1:].max(), "the spectrum is no product")


def check_block(folder):
    """A block of texels of one scan: spectra and cross-spectra at its own size, untapered; marginals."""
    random = np.random.default_rng(8)
    rows, cols = 9, 13
    z = rough(random, rows * 40 + 7, cols * 30 + 11) * np.exp(0.4 * rough(random, rows * 40 + 7, cols * 30 + 11, 25)) * 0.2
    np.save(folder / "block.npy", z)
    common = [folder / "block.npy", "--pitch", f"{DX}um,{DY}um", "--texel", "9um,8um", "--enough", 0, "--taper", "none", "--no-levels"]
    spectra = {}
    for recipe in ("full", "joint"):
        run(*common, "--size", f"{cols}x{rows}", "--recipe", recipe, "--marginals", "gaussian", "-o", folder / recipe)
        with h5py.File(folder / recipe / "texture.h5") as file:
            expect(file["texels/parameters"].shape == (rows, cols, 5), "blocks of a scan")
            exemplar, texture = texels_of(file), coordinates(file["texture/location"][:], file["texture/scale"][:])
            spectra[recipe] = np.fft.fft2(exemplar), np.fft.fft2(texture)
    for recipe, (measured, made) in spectra.items():
        measured[:, 0, 0] = made[:, 0, 0] = 0
        for a in range(5):
            for b in range(5):
                wanted, found = measured[a] * measured[b].conj(), made[a] * made[b].conj()
                unit = np.sqrt((abs(measured[a]) ** 2).max() * (abs(measured[b]) ** 2).max())
                kept = np.abs(found - wanted).max() < SPECTRUM * unit
                expect(kept or (recipe == "full" and a != b), f"{recipe} loses the spectrum of {a} and {b}")
    run(*common, "--size", "150x140", "--recipe", "joint", "-o", folder / "marginals")
    with h5py.File(folder / "marginals/texture.h5") as file:
        exemplar, texture = texels_of(file), coordinates(file["texture/location"][:], file["texture/scale"][:])
        for measured, made in zip(exemplar.reshape(5, -1), texture.reshape(5, -1)):
            reach = FLOAT * (1 + abs(measured).max())
            expect(measured.min() - reach <= made.min() and made.max() <= measured.max() + reach, "a value that was not measured")
            for p in (0.1, 0.5, 0.9):
                expect(abs((made < np.quantile(measured, p)).mean() - p) < 0.06, "marginals are not the exemplar's")


def check_levels(folder):
    """The picture is the file's texture, and each coarser texel the best single lobe of those it covers."""
    header, channels, levels = read_exr(folder / "texture.exr")
    expect(channels == [(name, 2) for name in NAMES], "the texture's channels")
    for name, words in {"units": "radians", "texelWidth": f"{COLS * DX:.6f} um", "texelHeight": f"{ROWS * DY:.6f} um", "recipe": "separable",
                        "marginals": "gaussian", "seed": "1", "provenance": "microbrdf texture", "software": "microbrdf", "wrapmodes": "periodic"}.items():
        expect(words in header.get(name, ""), f"the picture does not say {name}: {words}")
    with h5py.File(folder / "texture.h5") as file:
        expect((levels[0] == file["texture/parameters"][:]).all(), "picture and texture differ")
        stated = file["texture/level_misfit"][:]
    location, scale = frames(levels[0])
    random = np.random.default_rng(9)
    for level in range(1, len(levels)):
        side, (rows, cols) = 2**level, levels[level].shape[:2]
        texels = [divmod(k, cols) for k in random.choice(rows * cols, rows * cols if rows * cols <= 32 else 4, replace=False)]
        gains, divergences = [], []
        for j, i in texels:
            own = np.s_[j * side:(j + 1) * side, i * side:(i + 1) * side]
            few, fews = location[own].reshape(-1, 2), scale[own].reshape(-1, 2, 2)
            angles = 24 if len(few) <= 64 else 8
            slopes = drawn(few, fews, angles, angles)
            step, gain = step_to_best(slopes, *(x[0] for x in frames(levels[level][j, i][None])))
            expect(np.abs(step[2:]).max() < WIDTHS and np.abs(step[:2]).max() < CENTRE, f"level {level}: {step} from the best lobe")
            lobe = frames(levels[level][j, i][None])
            if len(few) <= 64:
                mixture = np.mean([density(slopes, *one) for one in zip(few, fews)], 0)
                ratio = density(slopes, lobe[0][0], lobe[1][0]) / mixture
                divergences.append((ratio - 1 - np.log(ratio)).mean())
                gains.append(gain)
        if divergences:
            expect(np.mean(gains) < DIVERGENCE * np.mean(divergences), f"level {level} could gain {np.mean(gains)} nats of {np.mean(divergences)}")
        if len(divergences) == rows * cols:
            expect(abs(np.mean(divergences) / stated[level - 1][1] - 1) < MISFIT, f"level {level} states {stated[level - 1][1]}, found {np.mean(divergences)}")


microbrdf = sys.argv[1]
with tempfile.TemporaryDirectory() as name:
    check_cross(pathlib.Path(name))
    check_block(pathlib.Path(name))
print("texels, spectra, marginals and levels are what they say")
