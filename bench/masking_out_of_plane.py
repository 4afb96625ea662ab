#!/usr/bin/python3
"""How many facets of normal h are seen from wi and wo out of the plane of incidence, on made Gaussian surfaces, against
Smith's G and Sun's. Prints the table of docs/brdf.md: masking_out_of_plane.py [SURFACES]

Smoothness s = τ/σ_h = 1. Both directions are at the polar angle with ν = s·cot θ, their azimuths Δφ apart. A ray is met where the surface
rises above it: the running maximum of h(x + t) − t·cot θ, by doubling. Surfaces are periodic, isotropic, C = exp(−r²/τ²)."""
import math
import sys

import numpy as np

SIDE, TAU = 2048, 24.0  # nodes; heights are in units of σ_h
SMOOTHNESS = 1
NUS, OPENINGS = (2, 1, 0.5), (180, 135, 90, 45, 0)
STEPS = {0: (0, 1), 45: (1, 1), 90: (1, 0), 135: (1, -1), 180: (0, -1)}  # rows, columns


def surface(seed):
    """Heights of rms 1 and their slopes along columns and rows."""
    k = 2 * np.pi * np.fft.fftfreq(SIDE)
    kx, ky = np.meshgrid(k, k)
    amplitude = np.exp(-(kx ** 2 + ky ** 2) * TAU ** 2 / 8)
    wave = amplitude * np.fft.fft2(np.random.default_rng(seed).standard_normal((SIDE, SIDE)))
    h, sx, sy = (np.fft.ifft2(w).real for w in (wave, 1j * kx * wave, 1j * ky * wave))
    scale = 1 / np.sqrt(np.mean(h ** 2))
    return h * scale, sx * scale, sy * scale


def seen(h, azimuth, cotangent):
    step = STEPS[azimuth]
    drop = cotangent * math.hypot(*step)
    highest = np.roll(h, (-step[0], -step[1]), (0, 1)) - drop  # over the first 1, 2, 4, … steps
    length = 1
    while length * drop < 10 and length < SIDE // 2:
        highest = np.maximum(highest, np.roll(highest, (-length * step[0], -length * step[1]), (0, 1)) - length * drop)
        length *= 2
    return highest < h


def expected(nu):
    """Smith's Λ for slopes of variance 2σ_h²/τ², and Sun's Γ₀ [Sun02 Eq. 3.4.23]."""
    a = nu / 2
    smith = (math.exp(-a * a) / (a * math.sqrt(math.pi)) - math.erfc(a)) / 2
    sun = math.exp(-math.exp(-nu * nu / 4) / (math.sqrt(2 * math.pi) * nu))
    return smith, sun


def main():
    surfaces = int(sys.argv[1]) if len(sys.argv) > 1 else 12
    near = 0.2 * math.sqrt(2) / TAU  # of the slope of h, a fifth of the slopes' standard deviation
    shares = {(nu, opening): [] for nu in NUS for opening in OPENINGS}
    for seed in range(surfaces):
        h, sx, sy = surface(seed)
        for nu in NUS:
            cotangent = nu / TAU
            first = seen(h, 0, cotangent)
            for opening in OPENINGS:
                # The slope of a facet whose normal is the half vector: −(wi + wo)_xy/(wi + wo)_z.
                half = math.radians(opening) / 2
                length = SMOOTHNESS ** 2 / (nu * TAU) * math.cos(half)
                facets = np.hypot(sx + length * math.cos(half), sy + length * math.sin(half)) < near
                both = first & seen(h, opening, cotangent)
                if facets.sum() > 1000:
                    shares[nu, opening].append(both[facets].mean())
    print("| ν | Δφ | seen | Smith G1² | 1/(1 + 2Λ) | Sun Γ₀² |\n|---|---|---|---|---|---|")
    for (nu, opening), found in shares.items():
        if len(found) < surfaces:
            continue
        smith, sun = expected(nu)
        error = np.std(found, ddof=1) / math.sqrt(surfaces)
        print(f"| {nu} | {opening}° | {np.mean(found):.3f} ± {error:.3f} | {1 / (1 + smith) ** 2:.3f} | {1 / (1 + 2 * smith):.3f} "
              f"| {sun ** 2:.3f} |")


main()
