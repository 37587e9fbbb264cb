"""Image files that are made byte by byte, colors by the standards' formulas, and a reader of a history's frames."""
import math
import struct
import zlib

WIDTH, HEIGHT = 10, 6
D65, D50 = (0.3127, 0.3290), (0.34567, 0.35850)
REC709, P3 = ((0.64, 0.33), (0.30, 0.60), (0.15, 0.06)), ((0.68, 0.32), (0.265, 0.69), (0.15, 0.06))
ADOBE, REC2020 = ((0.64, 0.33), (0.21, 0.71), (0.15, 0.06)), ((0.708, 0.292), (0.17, 0.797), (0.131, 0.046))
BRADFORD = ((0.8951, 0.2664, -0.1614), (-0.7502, 1.7135, 0.0367), (0.0389, -0.0685, 1.0296))


def times(a, b):
    return tuple(tuple(sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)) for i in range(3))


def apply(m, v):
    return tuple(sum(m[i][k] * v[k] for k in range(3)) for i in range(3))


def inverse(m):
    (a, b, c), (d, e, f), (g, h, i) = m
    det = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return tuple(tuple(v / det for v in row) for row in ((e * i - f * h, c * h - b * i, b * f - c * e),
                                                         (f * g - d * i, a * i - c * g, c * d - a * f),
                                                         (d * h - e * g, b * g - a * h, a * e - b * d)))


def white(xy):
    return (xy[0] / xy[1], 1.0, (1 - xy[0] - xy[1]) / xy[1])


def xyz_from_rgb(primaries, xy=D65):
    m = tuple(zip(*((x, y, 1 - x - y) for x, y in primaries)))
    share = apply(inverse(m), white(xy))
    return tuple(tuple(m[i][k] * share[k] for k in range(3)) for i in range(3))


def adaptation(a, b):
    """Bradford's, from white a to white b."""
    ratio = [y / x for x, y in zip(apply(BRADFORD, white(a)), apply(BRADFORD, white(b)))]
    return times(inverse(BRADFORD), tuple(tuple(ratio[i] * v for v in BRADFORD[i]) for i in range(3)))


def rec709(linear, primaries, xy=D65):
    """Light of other primaries as that of Rec. 709; what is negative is 0, as a history has it."""
    return [max(0.0, v) for v in apply(times(inverse(xyz_from_rgb(REC709)), times(adaptation(xy, D65), xyz_from_rgb(primaries, xy))), linear)]


def srgb(code):
    return code / 12.92 if code <= 0.04045 else ((code + 0.055) / 1.055) ** 2.4


def codes():
    """Rows of pixels, no two alike, and no symmetry."""
    return [[(20 + 23 * x, 30 + 37 * y, 240 - 11 * x - 9 * y) for x in range(WIDTH)] for y in range(HEIGHT)]


def light(curve=srgb, of=tuple):
    return [[list(of([curve(v / 255) for v in pixel])) for pixel in row] for row in codes()]


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(rows, *chunks):
    raw = b"".join(b"\0" + bytes(v for pixel in row for v in pixel) for row in rows)
    head = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + b"".join(chunk(*c) for c in chunks) + chunk(b"IDAT", zlib.compress(raw)) + chunk(b"IEND", b"")


def gamma(value):
    return b"gAMA", struct.pack(">I", round(value * 1e5))


def chromaticities(primaries):
    return b"cHRM", b"".join(struct.pack(">I", round(v * 1e5)) for xy in (D65, *primaries) for v in xy)


def directory(entries, at, order="<"):
    """Entries (tag, type, count, value or bytes) of a TIFF's directory that begins at `at`, and what they point to."""
    entries = sorted(entries)
    end = at + 2 + 12 * len(entries) + 4
    table, beside = struct.pack(order + "H", len(entries)), b""
    for tag, kind, count, value in entries:
        if isinstance(value, int):
            value = struct.pack(order + {1: "B", 3: "H", 4: "I"}[kind], value)
        if len(value) <= 4:
            field = value.ljust(4, b"\0")
        else:
            field = struct.pack(order + "I", end + len(beside))
            beside += value + b"\0" * (len(value) % 2)
        table += struct.pack(order + "HHI", tag, kind, count) + field
    return table, beside


def exif(orientation, order="<"):
    table, beside = directory([(274, 3, 1, orientation)], 8, order)
    return (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(order + "I", 8) + table + b"\0" * 4 + beside


def exif_adobe():
    """Color space "uncalibrated", interoperability R03."""
    first, _ = directory([(34665, 4, 1, 26)], 8)
    second, _ = directory([(40961, 3, 1, 65535), (40965, 4, 1, 56)], 26)
    third, _ = directory([(1, 2, 4, b"R03\0")], 56)
    return b"II*\0" + struct.pack("<I", 8) + first + b"\0" * 4 + second + b"\0" * 4 + third + b"\0" * 4


def tiff(pages):
    """Pages (width, height, samples, bytes, more entries); one strip each."""
    data, at, tables = b"", 8, []
    for width, height, samples, pixels, more in pages:
        bits = 8 * len(pixels) // (width * height * samples)
        entries = [(256, 4, 1, width), (257, 4, 1, height), (258, 3, samples, struct.pack("<H", bits) * samples), (259, 3, 1, 1),
                   (273, 4, 1, at), (277, 3, 1, samples), (278, 4, 1, height), (279, 4, 1, len(pixels))]
        given = {e[0] for e in more}
        if 262 not in given:
            entries.append((262, 3, 1, 2 if samples >= 3 else 1))
        data += pixels + b"\0" * (len(pixels) % 2)
        at = 8 + len(data)
        tables.append(entries + more)
    out = data
    for i, entries in enumerate(tables):
        begin = 8 + len(out)
        table, beside = directory(entries, begin)
        following = begin + len(table) + 4 + len(beside)
        out += table + struct.pack("<I", following if i + 1 < len(tables) else 0) + beside
    return b"II*\0" + struct.pack("<I", 8 + len(data)) + out


def tiff_in_strips(said_rows, rows_per_strip, pack=None, order="<", said_rows_per_strip=None):
    """codes() in strips, and how many rows the file says that it has."""
    rows = codes()
    strips = [flat(rows[y:y + rows_per_strip]) for y in range(0, HEIGHT, rows_per_strip)]
    strips = [pack(s) if pack else s for s in strips]
    places = [8 + sum(len(s) + len(s) % 2 for s in strips[:i]) for i in range(len(strips))]
    data = b"".join(s + b"\0" * (len(s) % 2) for s in strips)
    longs = struct.Struct(order + f"{len(strips)}I")
    entries = [(256, 4, 1, WIDTH), (257, 4, 1, said_rows), (258, 3, 3, struct.pack(order + "3H", 8, 8, 8)), (259, 3, 1, 8 if pack else 1), (262, 3, 1, 2),
               (273, 4, len(strips), longs.pack(*places)), (277, 3, 1, 3), (278, 4, 1, said_rows_per_strip or rows_per_strip), (279, 4, len(strips), longs.pack(*map(len, strips)))]
    table, beside = directory(entries, 8 + len(data), order)
    return (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(order + "I", 8 + len(data)) + data + table + b"\0" * 4 + beside


def psd(mode, channels):
    """codes() with the modes of Photoshop's file format: 3 is RGB; not packed."""
    planes = b"".join(bytes(pixel[min(c, 2)] for row in codes() for pixel in row) for c in range(channels))
    return b"8BPS" + struct.pack(">H6xHIIHHIIIH", 1, channels, HEIGHT, WIDTH, 8, mode, 0, 0, 0, 0) + planes


def flat(rows):
    return bytes(v for row in rows for pixel in row for v in pixel)


def radiance(*lines):
    """Pixels of (0.5, 0.25, 0.125), not packed."""
    head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n" + b"".join(line + b"\n" for line in lines)
    return head + b"\n-Y %d +X %d\n" % (HEIGHT, WIDTH) + bytes((128, 64, 32, 128)) * (WIDTH * HEIGHT)


def profile(primaries, gamma_value, name=b"test"):
    """A matrix profile, version 2."""
    def s15(values):
        return b"".join(struct.pack(">i", round(v * 65536)) for v in values)
    m = times(adaptation(D65, D50), xyz_from_rgb(primaries))
    columns = [[row[k] for row in m] for k in range(3)]
    curve = b"curv\0\0\0\0" + struct.pack(">IH", 1, round(gamma_value * 256)) + b"\0\0"
    text = b"desc\0\0\0\0" + struct.pack(">I", len(name) + 1) + name + b"\0" * 79
    tags = [(b"desc", text)] + [(t, b"XYZ \0\0\0\0" + s15(c)) for t, c in zip((b"rXYZ", b"gXYZ", b"bXYZ"), columns)]
    tags += [(t, curve) for t in (b"rTRC", b"gTRC", b"bTRC")] + [(b"wtpt", b"XYZ \0\0\0\0" + s15((0.9642, 1, 0.8249)))]
    table, data, begin = b"", b"", 132 + 12 * len(tags)
    for tag, value in tags:
        value += b"\0" * (-len(value) % 4)
        table += tag + struct.pack(">II", begin + len(data), len(value))
        data += value
    head = struct.pack(">I4sI4s4s4s6H4s", begin + len(data), b"none", 0x02400000, b"mntr", b"RGB ", b"XYZ ", 2026, 1, 1, 0, 0, 0, b"acsp")
    head = head.ljust(68, b"\0") + s15((0.9642, 1, 0.8249))
    return head.ljust(128, b"\0") + struct.pack(">I", len(tags)) + table + data


def exr(parts, data=None, display=None):
    """Floats, not compressed. Parts (name or None, {channel: function of x and y}, more attributes); windows (x0, y0, x1, y1)."""
    data = data or (0, 0, WIDTH - 1, HEIGHT - 1)
    display = display or data
    is_multi = len(parts) > 1
    rows = range(data[1], data[3] + 1)

    def attribute(name, kind, value):
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(value)) + value
    heads, bodies = b"", []
    for name, channels, more in parts:
        ordered = sorted(channels)
        listing = b"".join(c.encode() + b"\0" + struct.pack("<IIII", 2, 0, 1, 1) for c in ordered) + b"\0"
        heads += attribute(b"channels", b"chlist", listing) + attribute(b"compression", b"compression", b"\0")
        heads += attribute(b"dataWindow", b"box2i", struct.pack("<4i", *data)) + attribute(b"displayWindow", b"box2i", struct.pack("<4i", *display))
        heads += attribute(b"lineOrder", b"lineOrder", b"\0") + attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
        heads += attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)) + attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1))
        if is_multi:
            heads += attribute(b"name", b"string", name.encode()) + attribute(b"type", b"string", b"scanlineimage")
            heads += attribute(b"chunkCount", b"int", struct.pack("<i", len(rows)))
        heads += b"".join(attribute(*a) for a in more) + b"\0"
        bodies.append([b"".join(struct.pack("<f", channels[c](x, y)) for c in ordered for x in range(data[0], data[2] + 1)) for y in rows])
    start = struct.pack("<II", 20000630, 2 | (0x1000 if is_multi else 0)) + heads + (b"\0" if is_multi else b"")
    at, table, chunks = len(start) + 8 * len(rows) * len(parts), b"", b""
    for p, body in enumerate(bodies):
        for y, row in zip(rows, body):
            table += struct.pack("<Q", at + len(chunks))
            chunks += (struct.pack("<i", p) if is_multi else b"") + struct.pack("<ii", y, len(row)) + row
    return start + table + chunks


def deep_exr(samples=2):
    """Of the OpenEXR file layout: a single part of deep scan lines, not compressed, in which a pixel has so many samples."""
    def attribute(name, kind, value):
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(value)) + value
    channels = (b"A", b"B", b"G", b"R", b"Z")
    listing = b"".join(c + b"\0" + struct.pack("<IIII", 2, 0, 1, 1) for c in channels) + b"\0"
    window = struct.pack("<4i", 0, 0, WIDTH - 1, HEIGHT - 1)
    head = (attribute(b"channels", b"chlist", listing) + attribute(b"compression", b"compression", b"\0") + attribute(b"dataWindow", b"box2i", window)
            + attribute(b"displayWindow", b"box2i", window) + attribute(b"lineOrder", b"lineOrder", b"\0") + attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
            + attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)) + attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1))
            + attribute(b"type", b"string", b"deepscanline") + attribute(b"version", b"int", struct.pack("<i", 1))
            + attribute(b"chunkCount", b"int", struct.pack("<i", HEIGHT)) + attribute(b"maxSamplesPerPixel", b"int", struct.pack("<i", samples)) + b"\0")
    start = struct.pack("<II", 20000630, 2 | 0x800) + head
    counts = struct.pack(f"<{WIDTH}i", *(samples * (x + 1) for x in range(WIDTH)))
    data = struct.pack("<f", 0.5) * (WIDTH * samples * len(channels))
    chunks = [struct.pack("<iQQQ", y, len(counts), len(data), len(data)) + counts + data for y in range(HEIGHT)]
    at = len(start) + 8 * HEIGHT
    return start + b"".join(struct.pack("<Q", at + y * len(chunks[0])) for y in range(HEIGHT)) + b"".join(chunks)


def scene(x, y, c):
    """A color at a place, without symmetry."""
    return (0.05 + 0.08 * x, 0.1 + 0.11 * y, 0.9 - 0.05 * x - 0.04 * y)[c]


def colors(layer="", alpha=None):
    channels = {f"{layer}{n}": (lambda x, y, c=c: scene(x, y, c)) for c, n in enumerate("RGB")}
    if alpha is not None:
        channels[layer + "A"] = lambda x, y: alpha
    return channels


def scene_rows(of=tuple):
    return [[list(of([scene(x, y, c) for c in range(3)])) for x in range(WIDTH)] for y in range(HEIGHT)]


def read_frame(path):
    """Rows of (R, G, B) of a history's frame: half floats, ZIP, blocks of 16 rows."""
    bytes_ = path.read_bytes()
    at, window, names = 8, None, []
    while bytes_[at]:
        name_end = bytes_.index(b"\0", at)
        type_end = bytes_.index(b"\0", name_end + 1)
        size = struct.unpack("<I", bytes_[type_end + 1:type_end + 5])[0]
        value = bytes_[type_end + 5:type_end + 5 + size]
        if bytes_[at:name_end] == b"dataWindow":
            window = struct.unpack("<4i", value)
        if bytes_[at:name_end] == b"channels":
            place = 0
            while value[place]:
                end = value.index(b"\0", place)
                names.append(value[place:end].decode())
                place = end + 17
        at = type_end + 5 + size
    width, height = window[2] + 1, window[3] + 1
    rows = []
    at += 1 + 8 * math.ceil(height / 16)
    for first in range(0, height, 16):
        count = min(16, height - first)
        size = struct.unpack("<i", bytes_[at + 4:at + 8])[0]
        block = bytes_[at + 8:at + 8 + size]
        at += 8 + size
        if size < 2 * width * count * len(names):  # What does not shrink is stored as it is.
            raw = bytearray(zlib.decompress(block))
            for i in range(1, len(raw)):
                raw[i] = (raw[i - 1] + raw[i] - 128) % 256
            half = (len(raw) + 1) // 2
            block = bytes(raw[i // 2 + (half if i % 2 else 0)] for i in range(len(raw)))
        values = struct.unpack(f"<{width * count * len(names)}e", block)
        for y in range(count):
            of = {n: values[(y * len(names) + i) * width:(y * len(names) + i + 1) * width] for i, n in enumerate(names)}
            rows.append([(of["R"][x], of["G"][x], of["B"][x]) for x in range(width)])
    return rows


def upright(rows, orientation):
    """What EXIF's orientations mean [EXIF 2.32, 4.6.4]: where the first row and the first column are seen."""
    columns = [list(c) for c in zip(*rows)]
    return {1: rows, 2: [r[::-1] for r in rows], 3: [r[::-1] for r in rows[::-1]], 4: rows[::-1], 5: columns,
            6: [c[::-1] for c in columns], 7: [c[::-1] for c in columns[::-1]], 8: columns[::-1]}[orientation]
