#!/usr/bin/python3
"""Files that are made to hurt whoever reads them, given to the program: hostile_scans.py MICROBRDF

Sizes that are lies, bombs of zip, zlib, XML, OpenEXR and HDF5, names that lead out of an archive, circles. Each is read with
2 GiB of address space and 20 s, ends with an exit code of 0 to 3, and what is refused is refused in one sentence of
printable words that names the file."""
import io
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

import scan_formats as formats

NAN = float("nan")
LIES = (0, 1, 0x7FFF, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)


def zipped(members, kind=zipfile.ZIP_DEFLATED):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", kind) as archive:
        for name, content in members:
            archive.writestr(name, content)
    return out.getvalue()


def main_xml(cols=6, rows=4, kind="D", link="bindata/data.bin", before="", sizes="", increment=""):
    return f"""<?xml version="1.0"?>{before}<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"><Record1><Axes>
<CX><AxisType>I</AxisType><Increment>1e-6</Increment></CX><CY><AxisType>I</AxisType><Increment>1e-6</Increment></CY>
<CZ><AxisType>A</AxisType><DataType>{kind}</DataType>{increment}</CZ></Axes></Record1><Record3><MatrixDimension>{sizes}<SizeX>{cols}</SizeX>
<SizeY>{rows}</SizeY><SizeZ>1</SizeZ></MatrixDimension><DataLink><PointDataLink>{link}</PointDataLink></DataLink></Record3>
</p:ISO5436_2>"""


def x3p_files():
    points = np.zeros(24).tobytes()
    laughs = "<!DOCTYPE a [<!ENTITY l0 'ha'>" + "".join(f"<!ENTITY l{k} '{f'&l{k - 1};' * 10}'>" for k in range(1, 12)) + "]>"
    yield "a billion laughs", zipped([("main.xml", main_xml(before=laughs, kind="&l11;")), ("bindata/data.bin", points)])
    outside = "<!DOCTYPE a [<!ENTITY x SYSTEM 'file:///etc/passwd'>]>"
    yield "an entity from outside", zipped([("main.xml", main_xml(before=outside, kind="&x;")), ("bindata/data.bin", points)])
    yield "a million levels", zipped([("main.xml", "<a>" * 1000000 + "</a>" * 1000000)])
    yield "levels in the root", zipped([("main.xml", main_xml(sizes="<b>" * 300000 + "</b>" * 300000)), ("bindata/data.bin", points)])
    yield "a main.xml of blanks", zipped([("main.xml", main_xml() + " " * 300000000)])
    yield "names out of the archive", zipped([("../../main.xml", main_xml(link="../../../../etc/passwd")), ("/etc/passwd", points)])
    yield "a link to the machine", zipped([("main.xml", main_xml(link="/etc/passwd"))])
    yield "a link up", zipped([("a/main.xml", main_xml(link="../../../../../../etc/passwd"))])
    inner = zipped([("main.xml", main_xml()), ("bindata/data.bin", points)])
    yield "a zip in a zip as points", zipped([("main.xml", main_xml()), ("bindata/data.bin", inner)])
    for _ in range(30):
        inner = zipped([("main.xml", inner)])
    yield "thirty zips in one another", inner
    yield "60,000 members", zipped([(f"main.xml{k}", b"") for k in range(60000)] + [("main.xml", main_xml())], zipfile.ZIP_STORED)
    yield "a name of 60,000 bytes", zipped([("x" * 60000 + "/main.xml", main_xml()), ("bindata/data.bin", points)])
    for size in LIES + (46341, 65536, 4294967296):
        yield f"{size} columns and rows", zipped([("main.xml", main_xml(size, size)), ("bindata/data.bin", points)])
        yield f"{size} columns", zipped([("main.xml", main_xml(cols=size)), ("bindata/data.bin", points)])
    for word in ("a\nb\x85\x9b", "&#27;[31m", "\xff" * 30, "D" * 100000, "%s%n"):
        yield f"the type {word[:8]!r}", zipped([("main.xml", main_xml(kind=word)), ("bindata/data.bin", points)])
        yield f"the link {word[:8]!r}", zipped([("main.xml", main_xml(link=word)), ("bindata/data.bin", points)])
        yield f"the columns {word[:8]!r}", zipped([("main.xml", main_xml(cols=word)), ("bindata/data.bin", points)])
        yield f"the increment {word[:8]!r}", zipped([("main.xml", main_xml(increment=f"<Increment>{word}</Increment>"))])
    # 40,000 x 40,000 zeros: 3.2 GB in 3 MB that deflate allows.
    squeezer = zlib.compressobj(9, zlib.DEFLATED, -15)
    million = bytes(1000000)
    block = squeezer.compress(million) + squeezer.flush(zlib.Z_FULL_FLUSH)
    packed = block * 3200 + zlib.compressobj(9, zlib.DEFLATED, -15).flush()
    whole = zipped([("main.xml", main_xml(40000, 40000, "I")), ("bindata/data.bin", b"#")], zipfile.ZIP_STORED)
    end = whole.rindex(b"PK\5\6")
    directory = whole.index(b"PK\1\2")
    local = whole.rindex(b"PK\3\4", 0, directory)
    name = b"bindata/data.bin"
    sizes = struct.pack("<3I", 0, len(packed), 3200000000)
    head = whole[:local] + b"PK\3\4" + struct.pack("<5H", 20, 0, 8, 0, 33) + sizes + struct.pack("<2H", len(name), 0) + name + packed
    last = whole.rindex(b"PK\1\2")
    entries = whole[directory:last] + b"PK\1\2" + struct.pack("<6H", 20, 20, 0, 8, 0, 33) + sizes
    entries += struct.pack("<5H2I", len(name), 0, 0, 0, 0, 0, local) + name
    tail = b"PK\5\6" + struct.pack("<4H2IH", 0, 0, 2, 2, len(entries), len(head), 0)
    yield "3.2 GB in 3 MB", head + entries + tail
    good = formats.x3p("<f8", "D", NAN)
    yield "an encrypted member", good.replace(b"\x14\0\0\0\x08\0", b"\x14\0\1\0\x08\0")
    for wrong in (b"PK\1\2", b"PK\5\6"):
        at = good.rindex(wrong)
        yield f"lies behind {wrong!r}", good[:at + 4] + b"\xff" * (len(good) - at - 4)
    yield "a cut directory", good[:good.rindex(b"PK\5\6")]


def exr_files():
    good = formats.exr({"Y": "float"})
    tiled = formats.exr({"Y": "float"}, tile=(4, 3))

    def with_value(data, attribute, value):
        at = data.index(attribute) + len(attribute) + 4
        return data[:at] + value + data[at + len(value):]

    for corners in ((0, 0, 2**31 - 1, 2**31 - 1), (-2**31, -2**31, 2**31 - 1, 2**31 - 1), (0, 0, 99999, 99999), (0, 0, 2**31 - 1, 0),
                    (0, 0, 0, 2**31 - 1), (5, 5, 0, 0), (-1, -1, 20000, 20000), (2**31 - 8, 2**31 - 8, 2**31 - 1, 2**31 - 1)):
        for name, data in (("lines", good), ("tiles", tiled)):
            yield f"the window {corners} in {name}", with_value(data, b"dataWindow\0box2i\0", struct.pack("<4i", *corners))
    for size in LIES:
        yield f"tiles of {size}", with_value(tiled, b"tiles\0tiledesc\0", struct.pack("<2I", size, size))
        at = good.index(b"channels\0chlist\0") + 16
        yield f"channels of {size} bytes", good[:at] + struct.pack("<I", size) + good[at + 4:]
        chunk = len(good) - 4 * (8 + formats.COLS * 4)
        yield f"a line of {size} bytes", good[:chunk + 4] + struct.pack("<I", size) + good[chunk + 8:]
        yield f"chunks at {size}", good[:chunk - 32] + struct.pack("<4Q", *[size] * 4) + good[chunk:]
    head = good[:good.index(b"channels\0")]
    yield "an attribute of 2 GB", head + b"x\0string\0" + struct.pack("<i", 2**31 - 1) + good[len(head):]
    yield "100,000 attributes", head + b"".join(b"a%d\0int\0\4\0\0\0\0\0\0\0" % k for k in range(100000)) + good[len(head):]
    for flags in (0x400, 0x800, 0x1000, 0x1a00, 0xff02):
        yield f"flags {flags:x}", good[:4] + struct.pack("<I", 2 | flags) + good[8:]


def hdf5_files(folder):
    def written(fill, **options):
        path = folder / "made.h5"
        path.unlink(missing_ok=True)
        with h5py.File(path, "w", **options) as file:
            fill(file)
        return path.read_bytes()

    def surface(make):
        def fill(file):
            made = make(file.require_group("/Data/Surface"))
            if made is not None:
                made.attrs["Unit"] = np.array(["NanoMeters"], dtype=h5py.string_dtype("ascii"))
        return written(fill)

    def our(make):
        def fill(file):
            file.attrs["format"] = "microbrdf"
            file.attrs["format_version"] = 1
            file.attrs["complete"] = 1
            height = file.create_group("height")
            height.attrs["dx_um"] = height.attrs["dy_um"] = 1.0
            height.attrs["mean_um"] = 0.0
            make(height)
        return written(fill)

    def circle(group):
        group["again"] = group

    def links(group):
        group["soft"] = h5py.SoftLink("/Data/Surface/soft")

    def outside(group):
        group["out"] = h5py.ExternalLink("/etc/passwd", "/")

    def itself(group):
        group["out"] = h5py.ExternalLink("made.h5", "/Data/Surface/out")

    yield "a circle of groups", surface(circle)
    yield "a soft link to itself", surface(links)
    yield "a link to another file", surface(outside)
    yield "a link to itself from outside", surface(itself)
    for name, wrap in (("datx", surface), ("ours", our)):
        yield f"{name}: a million squared, never written", wrap(lambda g: g.create_dataset("z", (10**6, 10**6), "<f8", chunks=(64, 64)))
        yield f"{name}: two to the 62", wrap(lambda g: g.create_dataset("z", (2**31, 2**31), "u1", chunks=(64, 64)))
        yield f"{name}: no points", wrap(lambda g: g.create_dataset("z", (0, 0), "<f8"))
        yield f"{name}: three dimensions", wrap(lambda g: g.create_dataset("z", (2, 2, 2), "<f8"))
        yield f"{name}: text", wrap(lambda g: g.create_dataset("z", (2, 2), "S1000"))
        yield f"{name}: 400 MB in 400 kB", wrap(lambda g: g.create_dataset("z", data=np.zeros((10000, 5000)), chunks=(1000, 5000), compression=9))
        yield f"{name}: points in /dev/zero", wrap(lambda g: g.create_dataset("z", (30, 30), "<f8", external=[("/dev/zero", 0, h5py.h5f.UNLIMITED)]))
        yield f"{name}: a group called z", wrap(lambda g: g.create_group("z"))

    def virtual(group):
        layout = h5py.VirtualLayout((30, 30), "<f8")
        layout[:] = h5py.VirtualSource("made.h5", group.name + "/z", (30, 30))
        return group.create_virtual_dataset("z", layout)

    yield "datx: points that are their own source", surface(virtual)
    yield "ours: points that are their own source", our(virtual)
    good = written(lambda file: file.create_dataset("/Data/Surface/z", data=np.ones((4, 6))))
    for at in range(8, 96, 8):
        for lie in (0, 2**32, 2**63, 2**64 - 1):
            yield f"{lie} at {at}", good[:at] + struct.pack("<Q", lie) + good[at + 8:]


def liars():
    """Every 16- and 32-bit number of a head, replaced."""
    zygo = formats.zygo_dat()
    surf, squeezed, opd = formats.surf(), formats.surf(compressed=2), formats.opd(2, 32767, mult=10, aspect=2)
    plu, sdf = formats.plu(), formats.sdf_binary(6, -2147483648)
    for name, data, places, kind in (("dat", zygo, (0, 6, 48, 52, 56, 60, 64, 68, 70, 72), ">I"), ("sur", surf, (12, 14, 98, 100, 108, 112, 116, 334), "<I"),
                                     ("compressed sur", squeezed, (12, 14, 98, 108, 112, 334, 512, 516, 520, 524, 528), "<I"),
                                     ("opd", opd, tuple(range(18, 160, 6)), "<I"), ("plu", plu, (388, 392, 396, 428, 444, 448, 500, 504), "<I"),
                                     ("sdf", sdf, (42, 44, 78), "<I")):
        for at in places:
            for lie in LIES:
                yield f"{name}: {lie} at {at}", data[:at] + struct.pack(kind, lie) + data[at + 4:]
    for name, data, words in (("sdf", formats.sdf_ascii(), (b"NumPoints    = 6", b"NumProfiles  = 4")),
                              ("asc", formats.zygo_text("ASCII"), (b"139 38 6 4", b"0 0 4 3 1 4096")),
                              ("xyz", formats.zygo_text("XYZ"), (b"139 38 6 4",)),
                              ("gsf", formats.gsf({"XRes": 6, "YRes": 4, "XReal": 1, "YReal": 1, "XYUnits": "m", "ZUnits": "m"}), (b"XRes = 6", b"YRes = 4"))):
        for word in words:
            assert word in data, (name, word)
            for lie in (0, -1, 65535, 4294967295, 4294967296, 10**30):
                number = str(lie).encode()
                yield f"{name}: {lie} for {word}", data.replace(word, b" ".join([number if part.isdigit() else part for part in word.split(b" ")]))
    for shape in ("(4294967295, 4294967295)", "(18446744073709551615, 2)", "(-1, 6)", "(6,)", "(1e9, 3)", "(" * 30000, "(0, 0)", "(4611686018427387904, 4)"):
        head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n".encode()
        yield f"npy: {shape[:30]}", b"\x93NUMPY\1\0" + struct.pack("<H", len(head)) + head + bytes(192)
    yield "npy: a head of 4 GB", b"\x93NUMPY\2\0" + struct.pack("<I", 2**32 - 1) + b"{" * 200
    # 2 GB of zeros in 64 streams of 32 MB each, for a picture that needs a thousandth.
    stream = zlib.compress(bytes(32 << 20), 9)
    bomb = formats.surf(32)[:512].replace(b"DIGITAL SURF", b"DSCOMPRESSED") + struct.pack("<I", 64)
    yield "sur: 2 GB in 2 MB", bomb + struct.pack("<2I", 32 << 20, len(stream)) * 64 + stream * 64
    large = bytearray(bomb)
    struct.pack_into("<3i", large, 108, 20000, 26000, 520000000)
    yield "sur: 2 GB in 2 MB, and all of it points", bytes(large) + struct.pack("<2I", 32 << 20, len(stream)) * 64 + stream * 64
    yield "text: ten million cells in a line", b"1," * 10000000 + b"1\n"
    yield "text: ten million lines", b"1\n" * 10000000
    yield "text: one number of ten million digits", b"1" * 10000000 + b" 2\n"
    yield "text: a comment of 20 MB", b"#" + b"x" * 20000000 + b"\n1 2\n"


def fault(program, path):
    """What is wrong with how the program ends, or nothing."""
    command = f'ulimit -v 2097152; exec timeout -s KILL 20 "{program}" info --pitch 1 "{path}"'
    ended = subprocess.run(["bash", "-c", command], capture_output=True, text=True, errors="replace")
    if ended.returncode not in range(4):
        return f"exit code {ended.returncode}: {ended.stderr[-200:]}"
    if ended.returncode == 0:
        return ""
    said = ended.stderr.rstrip("\n")
    if "\n" in said or not said.isprintable() or str(path) not in said or len(said) > 600:
        return f"does not say in one sentence why: {said[:400]!r}"
    return ""


def main():
    program = sys.argv[1]
    count = failed = read = 0
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        path = folder / "scan"
        for kind, files in (("x3p", x3p_files()), ("exr", exr_files()), ("hdf5", hdf5_files(folder)), ("", liars())):
            for what, data in files:
                path.write_bytes(data)
                count += 1
                if wrong := fault(program, path):
                    failed += 1
                    print(f"FAILED: {kind} {what}: {wrong}", flush=True)
    print(f"{count} files, {failed} faults")
    sys.exit(failed != 0)


if __name__ == "__main__":
    main()
