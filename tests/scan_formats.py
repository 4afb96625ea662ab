#!/usr/bin/python3
"""Scans in every format that instruments write, packed here by the formats' own specifications in another language, and
what the program makes of them: scan_formats.py MICROBRDF

Each has 4 rows of 6 points whose heights say where they stand, three of them missing, 0.25 x 0.5 um apart."""
import hashlib
import io
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import zipfile
import zlib

try:
    import h5py
    import numpy as np
except ImportError:
    print("SKIPPED: /usr/bin/python3 has no numpy or no h5py")
    sys.exit(77)

ROWS, COLS, DX, DY = 4, 6, 0.25, 0.5
# Whole numbers, so that every integer type holds them; in um after a step that each format chooses.
COUNTS = (np.arange(ROWS * COLS).reshape(ROWS, COLS) * 7 + 3).astype(float)
HOLES = np.zeros((ROWS, COLS), bool)
HOLES[0, 2] = HOLES[2, 0] = HOLES[3, 5] = True
# float32 carries 2^-24 of the largest count; integers and doubles no less than the program's own float32 heights.
TOLERANCE = 2e-7


class Case:
    """Bytes, and what they mean: um per count, what is added, where points are missing, what the user must say."""

    def __init__(self, data, step, offset=0.0, holes=HOLES, pitch=None, spacing=(DX, DY)):
        self.data, self.step, self.offset, self.holes, self.pitch = data, step, offset, holes, pitch
        self.spacing = spacing


def filled(marker, dtype):
    return np.where(HOLES, marker, COUNTS).astype(dtype)


# --- X3P, ISO 5436-2 ---------------------------------------------------------------------------------------------
def x3p(dtype, kind, marker=None, step=None, offset=None, folder="", root="p:ISO5436_2", md5="right", junk=False,
        mask=False, stored=False, windows_link=False, exponent="e-007", name="bindata/data.bin"):
    floats = kind in "FD"
    z = COUNTS if marker is None and not mask else filled(marker or 0, float)
    raw = (np.where(HOLES, z, z * 1e-6) if floats else z).astype(dtype).tobytes()
    checksum = {"right": hashlib.md5(raw).hexdigest().upper(), "none": ""}[md5]
    valid = ""
    members = {}
    if mask:
        bits = np.packbits(~HOLES.ravel(), bitorder="little").tobytes()
        members["bindata/valid.bin"] = bits
        valid = f"<ValidPointsLink>bindata/valid.bin</ValidPointsLink><MD5ChecksumValidPoints>{hashlib.md5(bits).hexdigest()}</MD5ChecksumValidPoints>"
    z_scale = "" if step is None else f"<Increment>{step}</Increment>"
    z_scale += "<Offset></Offset>" if offset is None else f"<Offset>{offset}</Offset>"
    link = name.replace("/", "\\") if windows_link else name
    space = root.split(":")[0] if ":" in root else None
    declared = f'xmlns:{space}="http://www.opengps.eu/2008/ISO5436_2"' if space else 'xmlns="http://www.opengps.eu/2008/ISO5436_2"'
    main = f"""<?xml version="1.0" encoding="UTF-8" standalone="no" ?>
<{root} {declared}>
 <Record1><Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType><Axes>
  <CX><AxisType>I</AxisType><DataType>D</DataType><Increment>2.5{exponent}</Increment><Offset>1</Offset></CX>
  <CY><AxisType>I</AxisType><DataType>D</DataType><Increment>5{exponent}</Increment><Offset/></CY>
  <CZ><AxisType>A</AxisType><DataType>{kind}</DataType>{z_scale}</CZ></Axes></Record1>
 <Record3><MatrixDimension><SizeX>{COLS}</SizeX><SizeY>{ROWS}</SizeY><SizeZ>1</SizeZ></MatrixDimension>
  <DataLink><PointDataLink>{link}</PointDataLink><MD5ChecksumPointData>{checksum}</MD5ChecksumPointData>{valid}</DataLink></Record3>
 <Record4><ChecksumFile>md5checksum.hex</ChecksumFile></Record4>
</{root}>""".encode()
    members = {"main.xml": main, name: raw} | members
    if md5 != "none":
        members["md5checksum.hex"] = f"{hashlib.md5(main).hexdigest()} *main.xml".encode()
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_STORED if stored else zipfile.ZIP_DEFLATED) as archive:
        if junk:
            archive.writestr("__MACOSX/._main.xml", b"\0\5\x16\7")
            archive.writestr(f"__MACOSX/{folder}main.xml", b"no XML")
            archive.writestr(".DS_Store", b"\0\0\0\1Bud1")
            archive.writestr("mask.png", b"\x89PNG\r\n\x1a\n")
        for member, content in members.items():
            archive.writestr(folder + member, content)
    return out.getvalue()


def x3p_cases():
    nan, inf, none = float("nan"), float("inf"), np.zeros_like(HOLES)
    yield "int16", Case(x3p("<i2", "I", step="1e-8", mask=True), 0.01)
    yield "int16 negative step, offset", Case(x3p("<i2", "I", step="-1e-008", offset="2.5e-6", mask=True), -0.01, 2.5)
    yield "int16 below zero", Case(x3p("<i2", "I", marker=-30000, step="1e-8", mask=True), 0.01)
    yield "int32", Case(x3p("<i4", "L", step="1e-9", mask=True), 0.001)
    yield "int32, nothing marked", Case(x3p("<i4", "L", step="1E-9"), 0.001, holes=none)
    yield "float32 NaN", Case(x3p("<f4", "F", nan), 1)
    yield "float64 NaN", Case(x3p("<f8", "D", nan), 1)
    yield "float64 inf", Case(x3p("<f8", "D", inf, step="1"), 1)
    yield "float64 -inf, increment 1.0", Case(x3p("<f8", "D", -inf, step="1.0", offset="0"), 1)
    yield "float32 with a list of valid points", Case(x3p("<f4", "F", 0, mask=True), 1)
    yield "float64 with an offset", Case(x3p("<f8", "D", nan, offset="1e-6"), 1, 1.0)
    yield "in a folder, macOS", Case(x3p("<f8", "D", nan, folder="sample-land/", junk=True), 1)
    yield "in two folders", Case(x3p("<f4", "F", nan, folder="a/b/"), 1)
    yield "no checksums", Case(x3p("<f8", "D", nan, md5="none"), 1)
    yield "stored", Case(x3p("<f8", "D", nan, stored=True), 1)
    yield "default namespace", Case(x3p("<f8", "D", nan, root="ISO5436_2"), 1)
    yield "another prefix", Case(x3p("<f8", "D", nan, root="ns1:ISO5436_2"), 1)
    yield "Windows link", Case(x3p("<f8", "D", nan, windows_link=True), 1)
    yield "points elsewhere", Case(x3p("<f8", "D", nan, name="data/points.bin"), 1)
    yield "two-digit exponents", Case(x3p("<f8", "D", nan, exponent="E-07"), 1)


# --- Wyko .opd ---------------------------------------------------------------------------------------------------
def opd(size, marker, name=b"RAW_DATA", mult=None, aspect=None, wavelength=632.8, pixel=DX * 1e-3, extra=False, type_of=None):
    dtype = {1: "<u1", 2: "<i2", 4: "<f4", 8: "<f8"}[size]
    points = (COUNTS if marker is None else filled(marker, float)).astype(dtype)
    array = struct.pack("<3H", COLS, ROWS, size) + points[::-1].T.tobytes()  # columns, from the bottom up
    blocks = [(b"Wavelength", 7, struct.pack("<f", wavelength))]
    if extra:
        blocks.append((b"Title", 5, b"a title\0".ljust(20, b"\0")))
        blocks.append((b"Empty", 5, b""))
        blocks.append((b"Intensity", 3, struct.pack("<3H", 2, 2, 1) + bytes(4)))
    blocks.append((name, 3, array))
    blocks.append((b"Pixel_size", 7 if type_of is None else type_of, struct.pack("<f" if type_of is None else "<d", pixel)))
    if mult is not None:
        blocks.append((b"Mult", 6 if abs(mult) < 32768 else 12, struct.pack("<h" if abs(mult) < 32768 else "<i", mult)))
    if aspect is not None:
        blocks.append((b"Aspect", 7, struct.pack("<f", aspect)))
    spare = 3 if extra else 0
    record = struct.Struct("<16shiH")
    directory = record.pack(b"Directory", 1, record.size * (len(blocks) + 1 + spare), 0xFFFF)
    for block, kind, content in blocks:
        directory += record.pack(block, kind, len(content), 0xFFFF)
    directory += bytes(record.size * spare)
    return b"\x01\x00" + directory + b"".join(content for _, _, content in blocks)


def opd_cases():
    um = float(np.float32(632.8)) * 1e-3
    none = np.zeros_like(HOLES)
    yield "int16, 32766", Case(opd(2, 32766, mult=236, aspect=2), um / 236)
    yield "int16, 32767", Case(opd(2, 32767, mult=4000, aspect=2, name=b"RAW DATA"), um / 4000)
    yield "int16, no Mult", Case(opd(2, 32767, aspect=2, name=b"OPD"), um)
    yield "int16, Mult of 32 bits", Case(opd(2, 32766, mult=100000, aspect=2), um / 100000)
    yield "float, 1e38", Case(opd(4, 1e38, aspect=2, name=b"Raw"), um)
    yield "float, largest", Case(opd(4, 3.4e38, aspect=2), um)
    yield "float, Mult", Case(opd(4, float("inf"), mult=2, aspect=2), um / 2)
    yield "float, NaN", Case(opd(4, float("nan"), aspect=2), um)
    yield "other blocks beside it", Case(opd(2, 32767, mult=10, aspect=2, extra=True), um / 10)
    yield "square pixels", Case(opd(2, 32767, mult=10), um / 10, spacing=(DX, DX))
    yield "pixel of 64 bits", Case(opd(2, 32767, mult=10, type_of=8), um / 10, spacing=(DX, DX))
    yield "aspect 1.16667", Case(opd(4, 1e38, aspect=1.16667), um, spacing=(DX, DX * 1.16667))
    yield "bytes", Case(opd(1, None, mult=100, aspect=2), um / 100, holes=none)
    yield "no pixel size", Case(opd(2, 32767, mult=10, pixel=0), um / 10, pitch="0.25,0.5")


# --- Digital Surf .sur -------------------------------------------------------------------------------------------
def surf(bits=16, special=True, order="<", units=("mm", "mm", "um"), dz=0.01, z_offset=0.0, compressed=0, comment=b"", private=b"",
         spacing=None, padding=b"\0", zmin=3, objects=1, spare=0):
    um = {"m": 1e6, "mm": 1e3, "um": 1.0, "\xb5m": 1.0, "nm": 1e-3}
    spacing = spacing or (DX / um[units[0]], DY / um[units[1]])
    header = bytearray(512)

    def put(at, kind, *values):
        struct.pack_into(order + kind, header, at, *values)

    header[0:12] = b"DSCOMPRESSED" if compressed else b"DIGITAL SURF"
    put(12, "h", 0 if order == "<" else 257)
    put(14, "h", objects)
    put(16, "h", 1)
    put(18, "h", 2)
    put(82, "4h", 1, 0, int(special), 1)
    put(98, "h", bits)
    put(100, "2i", zmin, int(COUNTS.max()))
    put(108, "3i", COLS, ROWS, COLS * ROWS)
    put(120, "3f", *spacing, dz)
    for k, unit in enumerate(units):
        text = unit.encode("latin-1").ljust(16, padding)
        header[132 + 16 * k:148 + 16 * k] = b"XYZ"[k:k + 1].ljust(16, b" ")
        header[180 + 16 * k:196 + 16 * k] = text
        header[228 + 16 * k:244 + 16 * k] = b"um".ljust(16, b"\0")  # what to show them in
    put(276, "3f", 1, 1, 1)
    put(334, "2H", len(comment), len(private))
    put(466, "3f", 1.5, 2.5, z_offset)
    z = filled(zmin - 2, float) if special else COUNTS
    points = z.astype(order + ("i2" if bits == 16 else "i4")).tobytes()
    if compressed:
        size = -(-len(points) // compressed)
        parts = [points[k:k + size] for k in range(0, len(points), size)]
        packed = [zlib.compress(part) for part in parts]
        points = struct.pack(order + "I", len(parts))
        points += b"".join(struct.pack(order + "2I", len(a), len(b)) for a, b in zip(parts, packed)) + b"".join(packed)
    return bytes(header) + comment + private + points + bytes(spare)


def surf_cases():
    none = np.zeros_like(HOLES)
    for bits in (16, 32):
        yield f"{bits} bits", Case(surf(bits), 0.01)
        yield f"{bits} bits, Macintosh", Case(surf(bits, order=">"), 0.01)
        yield f"{bits} bits, no special points", Case(surf(bits, special=False), 0.01, holes=none)
        yield f"{bits} bits, z in m, xy in nm", Case(surf(bits, units=("nm", "nm", "m"), dz=1e-8), 0.01)
        yield f"{bits} bits, three units", Case(surf(bits, units=("\xb5m", "mm", "nm"), dz=10), 0.01)
        yield f"{bits} bits, z offset", Case(surf(bits, units=("m", "m", "mm"), dz=1e-5, z_offset=0.003), 0.01, 3.0)
        yield f"{bits} bits, comment and private", Case(surf(bits, comment=b"hello", private=b"x" * 33), 0.01)
        yield f"{bits} bits, negative heights", Case(surf(bits, zmin=-20000), 0.01)
        yield f"{bits} bits, negative step", Case(surf(bits, dz=-0.01), -0.01)
        for streams in (1, 3):
            yield f"{bits} bits, compressed in {streams}", Case(surf(bits, compressed=streams), 0.01)
        yield f"{bits} bits, compressed, comment", Case(surf(bits, compressed=2, comment=b"abc"), 0.01)
    yield "units padded with blanks", Case(surf(padding=b" "), 0.01)
    yield "no lateral scale", Case(surf(spacing=(0, 0)), 0.01, pitch="0.25,0.5")
    yield "bytes behind the points", Case(surf(spare=100), 0.01)


# --- Sensofar .plu -----------------------------------------------------------------------------------------------
def plu(date=b"Fri Mar 10 16:35:59 2023", comment=b"(None)", layers=0, spacing=(DX, DY), grey=True):
    header = bytearray(508)
    header[0:len(date)] = date
    struct.pack_into("<I", header, 128, 1678462559)
    header[132:132 + len(comment)] = comment
    struct.pack_into("<3I", header, 388, ROWS, COLS, layers)
    struct.pack_into("<6f", header, 400, 1, *spacing, 5, -7, 1.5)
    struct.pack_into("<5I", header, 428, 3, 3, 0, 14, 3)
    struct.pack_into("<4I", header, 448, ROWS, COLS, ROWS, COLS)
    struct.pack_into("<2I", header, 500, ROWS, COLS)
    z = np.where(HOLES, 1000001, COUNTS * 0.25).astype("<f4")
    data = z.tobytes() + struct.pack("<2f", float((COUNTS * 0.25).min()), float((COUNTS * 0.25).max()))
    return bytes(header) + data + (bytes(ROWS * COLS) if grey else b"")


def plu_cases():
    yield "as the instrument writes", Case(plu(), 0.25)
    yield "a day of one digit", Case(plu(b"Sat Jan  1 00:00:00 2000"), 0.25)
    yield "a line feed behind the date", Case(plu(b"Mon Dec 31 23:59:59 2012\n"), 0.25)
    yield "another date", Case(plu(b"2023-03-10 16:35:59"), 0.25)
    yield "no grey picture, a comment", Case(plu(comment=b"brushed steel", grey=False), 0.25)
    yield "no lateral scale", Case(plu(spacing=(0, 0)), 0.25, pitch="0.25,0.5")


# --- Keyence .vk4 ------------------------------------------------------------------------------------------------
def vk4(bits=32, dz=500000, spacing=(250000, 500000), more=0, colour=False):
    """The height image, before it a colour picture if asked for; settings as long as `more` makes them. Lengths are pm."""
    settings = bytearray(304 + more)
    struct.pack_into("<7I", settings, 0, len(settings), 2026, 12, 1, 13, 0, 0)
    struct.pack_into("<3I", settings, 168, *spacing, dz)
    picture = struct.pack("<5I", COLS, ROWS, 24, 0, 3 * ROWS * COLS) + bytes(range(3 * ROWS * COLS)) if colour else b""
    raw = COUNTS.astype({8: "u1", 16: "<u2", 32: "<u4"}[bits]).tobytes()
    image = struct.pack("<7I", COLS, ROWS, bits, 0, len(raw), 0, int(COUNTS.max())) + bytes(range(256)) * 3 + raw
    places = [0] * 18
    places[0] = 84
    places[1] = 84 + len(settings) if colour else 0
    places[6] = 84 + len(settings) + len(picture)
    return b"VK4_" + bytes((1, 0, 0, 8)) + bytes(4) + struct.pack("<18I", *places) + settings + picture + image


def vk4_cases():
    none = np.zeros_like(HOLES)
    for bits in (8, 16, 32):
        yield f"{bits} bits", Case(vk4(bits), 0.5, holes=none)
    yield "a digit of 100 pm", Case(vk4(dz=100), 1e-4, holes=none)
    yield "longer settings, a colour picture", Case(vk4(more=52, colour=True), 0.5, holes=none)
    yield "no lateral scale", Case(vk4(spacing=(0, 0)), 0.5, holes=none, pitch="0.25,0.5")


# --- SDF, ISO 25178-71 -------------------------------------------------------------------------------------------
def sdf_ascii(end="\n", equals=" = ", bad="BAD", number="{:.0f}", scale="1e-8", magic="aISO-1.0", kind=7, per_line=COLS, trailer="",
              indent=""):
    fields = {"ManufacID": "here", "CreateDate": "010120260000", "ModDate": "010120260000", "NumPoints": COLS, "NumProfiles": ROWS,
              "Xscale": "2.5E-07", "Yscale": "5e-07", "Zscale": scale, "Zresolution": "-1", "Compression": 0, "DataType": kind,
              "CheckType": 0}
    lines = [magic] + [f"{key:<12}{equals}{value}" if equals == " = " else f"{key}{equals}{value}" for key, value in fields.items()] + ["*"]
    words = [bad if hole else number.format(z) for hole, z in zip(HOLES.ravel(), COUNTS.ravel())]
    lines += [indent + " ".join(words[k:k + per_line]) for k in range(0, len(words), per_line)] + ["*"]
    if trailer:
        lines += [trailer, "*"]
    return (end.join(lines) + end).encode()


def sdf_binary(kind, marker, magic=b"bISO-1.0", scale=1e-8, trailer=b""):
    dtype = ("u1", "<u2", "<u4", "<f4", "i1", "<i2", "<i4", "<f8")[kind]
    header = struct.pack("<8s10s12s12s2H4d3B", magic, b"here", b"010120260000", b"010120260000", COLS, ROWS, DX * 1e-6, DY * 1e-6, scale,
                         -1.0, 0, kind, 0)
    z = COUNTS - (100 if kind == 4 else 0)
    return header + (z if marker is None else np.where(HOLES, marker, z)).astype(dtype).tobytes() + trailer


def sdf_cases():
    none = np.zeros_like(HOLES)
    yield "ASCII", Case(sdf_ascii(), 0.01)
    yield "ASCII, CRLF, trailer", Case(sdf_ascii("\r\n", trailer="made by hand"), 0.01)
    yield "ASCII, no blanks, one a line", Case(sdf_ascii(equals="=", per_line=1), 0.01)
    yield "ASCII, tabs", Case(sdf_ascii(equals="\t=\t"), 0.01)
    yield "ASCII, fractions, BCR", Case(sdf_ascii(number="{:.3f}", magic="aBCR-1.0"), 0.01)
    yield "ASCII, exponents, all in a line", Case(sdf_ascii(number="{:.6E}", per_line=100), 0.01)
    yield "ASCII, integers", Case(sdf_ascii(kind=5, scale="1.0E-008", indent="   "), 0.01)
    yield "ASCII, bad in small letters", Case(sdf_ascii(bad="bad"), 0.01)
    for kind, marker in ((1, 65535), (2, 4294967295), (3, np.nan), (5, -32768), (6, -2147483648), (7, np.nan), (7, -np.inf),
                         (7, -np.finfo(float).max), (3, -np.finfo(np.float32).max)):
        yield f"binary, type {kind}, {marker}", Case(sdf_binary(kind, marker), 0.01)
    yield "binary, type 0", Case(sdf_binary(0, None), 0.01, holes=none)
    yield "binary, type 4", Case(sdf_binary(4, None), 0.01, -1.0, holes=none)
    yield "binary, BCR, trailer", Case(sdf_binary(5, -32768, b"bBCR-1.0", trailer=b"\r\nmade by hand\r\n*"), 0.01)


# --- OpenEXR -----------------------------------------------------------------------------------------------------
def exr_packed(raw):
    """ZIP's predictor: even bytes, then odd ones, then differences [OpenEXR, Technical Introduction]."""
    data = np.frombuffer(raw, np.uint8)
    data = np.concatenate([data[0::2], data[1::2]]).astype(np.int16)
    data[1:] = data[1:] - data[:-1] + 128
    packed = zlib.compress((data & 255).astype(np.uint8).tobytes())
    return packed if len(packed) < len(raw) else raw


def exr(channels, compression=0, tile=None, origin=(0, 0), decreasing=False, long_names=False):
    """channels: {name: "half", "float" or "uint"}; heights in Y or in the only one, elsewhere 99."""
    kinds = {"uint": (0, "<u4"), "half": (1, "<f2"), "float": (2, "<f4")}
    height = "Y" if "Y" in channels else next(iter(channels))
    x0, y0 = origin
    window = struct.pack("<4i", x0, y0, x0 + COLS - 1, y0 + ROWS - 1)
    planes = {}
    for name in sorted(channels):
        values = filled(np.nan, float) if channels[name] != "uint" else COUNTS
        planes[name] = (values if name == height else np.full((ROWS, COLS), 99.0)).astype(kinds[channels[name]][1])

    def attribute(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    listed = b"".join(name.encode() + b"\0" + struct.pack("<i4B2i", kinds[channels[name]][0], 0, 0, 0, 0, 1, 1) for name in sorted(channels))
    head = attribute("channels", "chlist", listed + b"\0") + attribute("compression", "compression", bytes([compression]))
    head += attribute("dataWindow", "box2i", window) + attribute("displayWindow", "box2i", struct.pack("<4i", 0, 0, 99, 99))
    head += attribute("lineOrder", "lineOrder", bytes([int(decreasing)])) + attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    head += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)) + attribute("screenWindowWidth", "float", struct.pack("<f", 1))
    if tile:
        head += attribute("tiles", "tiledesc", struct.pack("<2IB", *tile, 0))
    head = struct.pack("<2I", 20000630, 2 | (0x200 if tile else 0)) + head + b"\0"

    def rows_of(r0, r1, c0=0, c1=COLS):
        raw = b"".join(planes[name][r, c0:c1].tobytes() for r in range(r0, r1) for name in sorted(channels))
        return exr_packed(raw) if compression else raw

    chunks = []
    if tile:
        across, down = tile
        for tile_y, r in enumerate(range(0, ROWS, down)):
            for tile_x, c in enumerate(range(0, COLS, across)):
                data = rows_of(r, min(r + down, ROWS), c, min(c + across, COLS))
                chunks.append(struct.pack("<5i", tile_x, tile_y, 0, 0, len(data)) + data)
    else:
        lines = 16 if compression == 3 else 1
        for r in range(0, ROWS, lines):
            data = rows_of(r, min(r + lines, ROWS))
            chunks.append(struct.pack("<2i", y0 + r, len(data)) + data)
    order = list(range(len(chunks)))
    if decreasing:
        order.reverse()
    at, places = len(head) + 8 * len(chunks), {}
    for k in order:
        places[k] = at
        at += len(chunks[k])
    return head + b"".join(struct.pack("<Q", places[k]) for k in range(len(chunks))) + b"".join(chunks[k] for k in order)


def exr_cases():
    def case(*arguments, **options):
        holes = np.zeros_like(HOLES) if "uint" in arguments[0].values() else HOLES
        return Case(exr(*arguments, **options), 1, pitch="0.25,0.5", holes=holes)

    yield "float", case({"Y": "float"})
    yield "half", case({"Y": "half"})
    yield "integers", case({"height": "uint"})
    yield "another name", case({"depth.Z": "float"})
    yield "several channels", case({"A": "half", "Y": "float", "Z": "float"})
    yield "several channels, Y half", case({"B": "float", "RY": "float", "Y": "half"})
    yield "ZIPS", case({"Y": "float"}, compression=2)
    yield "ZIP", case({"Y": "half"}, compression=3)
    yield "tiled", case({"Y": "float"}, tile=(4, 3))
    yield "tiled, ZIP, two channels", case({"X": "half", "Y": "float"}, compression=3, tile=(4, 3))
    yield "a window elsewhere", case({"Y": "float"}, origin=(-100, 57))
    yield "a tiled window elsewhere", case({"Y": "half"}, origin=(1000, -3), tile=(2, 2))
    yield "lines from below", case({"Y": "float"}, decreasing=True)


# --- Gwyddion Simple Field, NumPy, plain text --------------------------------------------------------------------
def gsf(fields, blanks=" = "):
    head = "Gwyddion Simple Field 1.0\n" + "".join(f"{key}{blanks}{value}\n" for key, value in fields.items())
    head = head.encode()
    head += bytes(4 - len(head) % 4)
    return head + (filled(np.nan, float) * 1e-6).astype("<f4").tobytes()


def gsf_cases():
    whole = {"XRes": COLS, "YRes": ROWS, "XReal": COLS * DX * 1e-6, "YReal": ROWS * DY * 1e-6, "XYUnits": "m", "ZUnits": "m"}
    yield "plain", Case(gsf(whole), 1)
    for title in ("", "x", "xy", "xyz"):
        yield f"title of {len(title)}", Case(gsf(whole | {"Title": title}), 1)
    yield "no blanks, offsets", Case(gsf(whole | {"XOffset": "1e-3", "YOffset": "-2e-3"}, "="), 1)
    yield "no lateral unit", Case(gsf({k: v for k, v in whole.items() if k != "XYUnits"}), 1, pitch="0.25,0.5")


def npy_cases():
    for dtype in ("<f8", ">f8", "<f4", ">f4"):
        out = io.BytesIO()
        np.save(out, filled(np.nan, float).astype(dtype))
        yield dtype, Case(out.getvalue(), 1, pitch="0.25,0.5")
    for dtype in ("<i2", ">i4", "<u2", "u1", "<i8"):
        out = io.BytesIO()
        np.save(out, COUNTS.astype(dtype))
        yield dtype, Case(out.getvalue(), 1, pitch="0.25,0.5", holes=np.zeros_like(HOLES))
    out = io.BytesIO()
    np.lib.format.write_array(out, np.asfortranarray(filled(np.nan, float)), version=(2, 0))
    yield "columns first, version 2", Case(out.getvalue(), 1, pitch="0.25,0.5")


def text_cases():
    for separator in (" ", "\t", ",", ";", "   "):
        for end in ("\n", "\r\n"):
            rows = [separator.join("nan" if hole else repr(float(z)) for hole, z in zip(*row)) for row in zip(HOLES, COUNTS)]
            yield repr(separator + end), Case(("# heights, um" + end + end.join(rows) + end).encode(), 1, pitch="0.25,0.5")


# --- Zygo --------------------------------------------------------------------------------------------------------
S, W, O = 0.5, 6.328e-7, 1.0


def zygo_um(phase_res, sign=0):
    """S W O / R of the two numbers as 32 bits hold them, um a count."""
    step = float(np.float32(S)) * float(np.float32(W)) * O / (4096, 32768, 131072)[phase_res] * 1e6
    return -step if sign else step


def zygo_dat(form=1, phase_res=1, sign=0, buckets=1, frame=(8, 7), lateral=DX * 1e-6, marker=2147483640):
    size = 4096 if form == 3 else 834
    header = bytearray(size)
    struct.pack_into(">IHI", header, 0, 0x881B036F + form - 1, form, size)
    width, height = frame
    struct.pack_into(">2h3Hhi", header, 48, 0, 0, width, height, buckets, 0, 2 * width * height * buckets)
    struct.pack_into(">2h2HI", header, 64, 1, 2, COLS, ROWS, 4 * ROWS * COLS)
    struct.pack_into(">6f", header, 164, S, W, 0, O, 10, lateral)
    struct.pack_into(">h", header, 218, phase_res)
    struct.pack_into(">3h", header, 232, sign, 640, 480)
    return bytes(header) + b"\xff" * (2 * width * height * buckets) + filled(marker, float).astype(">i4").tobytes()


def zygo_text(kind, end="\n", buckets=1, phase_res=1, sign=0, form=2, origin=(139, 38), separator=" ", per_line=10):
    lines = [f"Zygo {kind} Data File - Format {form}", '0 6 2 6 "Fri Jan 16 10:57:22 2015"', f"0 0 4 3 {buckets} 4096" if buckets else "0 0 0 0 0 0",
             f"{origin[0]} {origin[1]} {COLS} {ROWS}", '"a comment # of it"', '"serial"', '"part"',
             f"0 {S} 6.328e-007 0 {O:.0f} 0 2.5e-007 1421361442", '640 480 22 1 5 "10X"', "0 1 0 0 0 0 0 0 0 0", f"{phase_res} 0 7 1 15 0 0 {sign} 1",
             '0 ""', "1 0"] + (['"1X"'] if form == 2 else []) + ["#"]

    def block(values):
        words = [str(value) for value in values]
        return [separator.join(words[k:k + per_line]) + " " for k in range(0, len(words), per_line)] + ["#"]

    if kind == "ASCII":
        if buckets:
            lines += block([7] * (12 * buckets))
        lines += block(filled(2147483640, np.int64).ravel())
    else:
        for (row, col), z in np.ndenumerate(COUNTS):
            height = "No Data" if HOLES[row, col] else f"{z * 0.01:.6f}"
            lines.append(separator.join([str(col + origin[0]), str(row + origin[1]), height]))
        lines.append("#")
    return (end.join(lines) + end).encode()


def zygo_cases():
    square = (DX, DX)
    for form in (1, 2, 3):
        yield f".dat format {form}", Case(zygo_dat(form), zygo_um(1), spacing=square)
    for phase_res in (0, 2):
        yield f".dat resolution {phase_res}", Case(zygo_dat(phase_res=phase_res), zygo_um(phase_res), spacing=square)
    yield ".dat sign", Case(zygo_dat(sign=1), zygo_um(1, 1), spacing=square)
    yield ".dat without intensities", Case(zygo_dat(buckets=0, frame=(0, 0)), zygo_um(1), spacing=square)
    yield ".dat five buckets, another marker", Case(zygo_dat(buckets=5, marker=2147483647), zygo_um(1), spacing=square)
    yield ".dat no lateral scale", Case(zygo_dat(lateral=0), zygo_um(1), pitch="0.25,0.5")
    step = S * W * O / 32768 * 1e6
    yield ".asc", Case(zygo_text("ASCII"), step, spacing=square)
    yield ".asc CRLF, two buckets", Case(zygo_text("ASCII", "\r\n", buckets=2), step, spacing=square)
    yield ".asc no intensities, format 1", Case(zygo_text("ASCII", buckets=0, form=1), step, spacing=square)
    yield ".asc sign, resolution 0", Case(zygo_text("ASCII", phase_res=0, sign=1), -step * 8, spacing=square)
    yield ".asc one a line", Case(zygo_text("ASCII", per_line=1), step, spacing=square)
    yield ".xyz", Case(zygo_text("XYZ"), 0.01, spacing=square)
    yield ".xyz tabs, CRLF, format 1", Case(zygo_text("XYZ", "\r\n", form=1, separator="\t"), 0.01, spacing=square)


def datx_cases():
    """What h5py can write of it: the converters' lists are beyond it (hdf5_file_test writes those), so the user says the pitch."""
    for unit, um in (("NanoMeters", 1e-3), ("MicroMeters", 1.0), ("Meters", 1e6), ("Fringes", 0.25 * 0.9)):
        with tempfile.NamedTemporaryFile() as file:
            with h5py.File(file.name, "w") as out:
                surface = out.create_dataset("/Data/Surface/{0001}", data=filled(np.finfo(float).max, float))
                surface.attrs["Unit"] = np.array([unit], dtype=h5py.string_dtype("ascii"))
                surface.attrs["No Data"] = np.array([np.finfo(float).max])
                for name, value in (("Wavelength", 5e-7), ("Interferometric Scale Factor", 0.5), ("Obliquity Factor", 0.9)):
                    surface.attrs[name] = np.array([value])
            yield f".datx {unit}", Case(pathlib.Path(file.name).read_bytes(), um, pitch="0.25,0.5")


FORMATS = {"x3p": x3p_cases, "opd": opd_cases, "sur": surf_cases, "plu": plu_cases, "vk4": vk4_cases, "sdf": sdf_cases, "exr": exr_cases, "gsf": gsf_cases,
           "npy": npy_cases, "text": text_cases, "zygo": zygo_cases, "datx": datx_cases}


def faults(program, case, folder):
    """What the program gets wrong of a case, as sentences."""
    scan, points = folder / "scan", folder / "points.npy"
    scan.write_bytes(case.data)
    pitch = ["--pitch", case.pitch] if case.pitch else []
    points.unlink(missing_ok=True)
    converted = subprocess.run([program, "convert", scan, "-o", points, "--json", *pitch], capture_output=True, text=True)
    if converted.returncode:
        return [f"exit code {converted.returncode}: {converted.stderr.strip()}"]
    info = json.loads(converted.stdout)
    z = np.load(points)
    expected = np.where(case.holes, np.nan, COUNTS * case.step + case.offset)
    wrong = []
    if z.shape != expected.shape or (info["rows"], info["cols"]) != (ROWS, COLS):
        return [f"{z.shape} points"]
    if not np.array_equal(np.isnan(z), case.holes) or info["missing"] != case.holes.sum():
        wrong.append(f"{np.isnan(z).sum()} points are missing, {info['missing']} by the summary, not {case.holes.sum()}")
    error = np.nanmax(abs(z - expected)) / np.nanmax(abs(expected))
    if not error <= TOLERANCE:
        wrong.append(f"heights are off by {error:.2g} of the largest")
    for key, value in zip(("dx_um", "dy_um"), case.spacing):
        if not abs(info[key] / value - 1) <= TOLERANCE:
            wrong.append(f"{key} is {info[key]}, not {value}")
    return wrong


def main():
    program = sys.argv[1]
    count = failed = 0
    with tempfile.TemporaryDirectory() as name:
        for form, cases in FORMATS.items():
            for what, case in cases():
                count += 1
                for fault in faults(program, case, pathlib.Path(name)):
                    failed += 1
                    print(f"FAILED: {form}, {what}: {fault}")
    print(f"{count} scans, {failed} faults")
    sys.exit(failed != 0)


if __name__ == "__main__":
    main()
