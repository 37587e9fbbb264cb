"""Files of a series of photographs for tests, written byte by byte: what is in them is known exactly."""
import struct
import zlib


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width, height, pixel, channels=3, exif=None, written=None):
    """`pixel(x, y)` gives a code for each channel: gray, gray and alpha, RGB or RGBA. `written`: a tIME chunk."""
    rows = b"".join(b"\0" + bytes(v for x in range(width) for v in pixel(x, y)) for y in range(height))
    kind = {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, kind, 0, 0, 0))
            + (chunk(b"tIME", struct.pack(">HBBBBB", *written)) if written else b"") + (chunk(b"eXIf", exif) if exif else b"")
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def png_pixels(data):
    """Rows of pixels of an 8-bit PNG without interlacing, each a tuple of channels."""
    width, height, _, kind = struct.unpack(">IIBB", data[16:26])
    channels = {0: 1, 2: 3, 4: 2, 6: 4}[kind]
    at, packed = 8, b""
    while at < len(data):
        size = struct.unpack(">I", data[at:at + 4])[0]
        if data[at + 4:at + 8] == b"IDAT":
            packed += data[at + 8:at + 8 + size]
        at += size + 12
    raw, stride, before, rows = zlib.decompress(packed), width * channels, bytes(width * channels), []
    for y in range(height):
        how, line = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            left, up, corner = line[i - channels] if i >= channels else 0, before[i], before[i - channels] if i >= channels else 0
            nearest = min((left, up, corner), key=lambda v: abs(left + up - corner - v))
            line[i] = (line[i] + (0, left, up, (left + up) // 2, nearest)[how]) % 256
        before = bytes(line)
        rows.append([tuple(line[x * channels:(x + 1) * channels]) for x in range(width)])
    return rows


EXIF_TAGS = {"DateTimeOriginal": 0x9003, "DateTimeDigitized": 0x9004, "OffsetTime": 0x9010, "OffsetTimeOriginal": 0x9011, "OffsetTimeDigitized": 0x9012,
             "SubSecTime": 0x9290, "SubSecTimeOriginal": 0x9291, "SubSecTimeDigitized": 0x9292}


def exif(order=">", **texts):
    """EXIF data of texts: DateTime (of the last change) and those of EXIF_TAGS. `order`: of the bytes."""
    def directory(tags, start):
        head, tail = struct.pack(order + "H", len(tags)), b""
        for tag, value in sorted(tags.items()):
            if isinstance(value, int):
                head += struct.pack(order + "HHII", tag, 4, 1, value)
                continue
            data = value.encode() + b"\0"
            if len(data) <= 4:
                head += struct.pack(order + "HHI", tag, 2, len(data)) + data.ljust(4, b"\0")
            else:
                head += struct.pack(order + "HHII", tag, 2, len(data), start + 2 + 12 * len(tags) + 4 + len(tail))
                tail += data
        return head + struct.pack(order + "I", 0) + tail
    first = {0x0132: texts.pop("DateTime")} if "DateTime" in texts else {}
    size = len(directory({**first, 0x8769: 0}, 8))
    second = directory({EXIF_TAGS[name]: text for name, text in texts.items()}, 8 + size)
    return (b"MM\0*" if order == ">" else b"II*\0") + struct.pack(order + "I", 8) + directory({**first, 0x8769: 8 + size}, 8) + second


def box(kind, *parts):
    data = b"".join(parts)
    return struct.pack(">I", 8 + len(data)) + kind + data


UPRIGHT = (1, 0, 0, 1)


def movie(frames, width, height, durations, timescale=1000, turn=UPRIGHT, color=None, aspect=None, edits=None):
    """QuickTime with uncompressed RGB: `frames` are bytes, `durations` counts of 1 / timescale s.

    turn: a, b, c, d of the display matrix. color: primaries, transfer and matrix by their numbers in ITU-T H.273. aspect: of a pixel.
    edits: pairs of duration and start."""
    entry = (b"\0" * 6 + struct.pack(">H", 1) + b"\0" * 16 + struct.pack(">HHIIIH", width, height, 72 << 16, 72 << 16, 0, 1) + bytes(32) + struct.pack(">Hh", 24, -1)
             + (box(b"colr", b"nclc", struct.pack(">HHH", *color)) if color else b"") + (box(b"pasp", struct.pack(">II", *aspect)) if aspect else b""))
    full = b"\0" * 4
    table = box(b"stbl", box(b"stsd", full, struct.pack(">I", 1), box(b"raw ", entry)),
                box(b"stts", full, struct.pack(">I", len(frames)), b"".join(struct.pack(">II", 1, d) for d in durations)),
                box(b"stsc", full, struct.pack(">IIII", 1, 1, len(frames), 1)),
                box(b"stsz", full, struct.pack(">II", 0, len(frames)), b"".join(struct.pack(">I", len(f)) for f in frames)),
                box(b"stco", full, struct.pack(">II", 1, 28)))
    total = sum(durations)
    a, b, c, d = (v << 16 for v in turn)
    matrix = struct.pack(">9i", a, b, 0, c, d, 0, 0, 0, 1 << 30)
    media = box(b"mdia", box(b"mdhd", full, struct.pack(">IIIIHH", 0, 0, timescale, total, 0, 0)), box(b"hdlr", full, b"mhlrvide", bytes(13)),
                box(b"minf", box(b"vmhd", full, bytes(8)), box(b"dinf", box(b"dref", full, struct.pack(">I", 1), box(b"url ", b"\0\0\0\1"))), table))
    track = box(b"trak", box(b"tkhd", b"\0\0\0\1", struct.pack(">IIIII", 0, 0, 1, 0, total), bytes(16), matrix, struct.pack(">II", width << 16, height << 16)),
                box(b"edts", box(b"elst", full, struct.pack(">I", len(edits)), b"".join(struct.pack(">IiI", *e, 1 << 16) for e in edits))) if edits else b"", media)
    header = box(b"mvhd", full, struct.pack(">IIIIIH", 0, 0, timescale, total, 1 << 16, 256), bytes(10), struct.pack(">9i", 1 << 16, 0, 0, 0, 1 << 16, 0, 0, 0, 1 << 30), bytes(24), struct.pack(">I", 2))
    return box(b"ftyp", b"qt  ", struct.pack(">I", 0), b"qt  ") + box(b"mdat", *frames) + box(b"moov", header, track)
