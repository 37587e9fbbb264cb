"""Photographs and descriptions for tests of `patinate calibrate`, by formulas: a pinhole camera, a chessboard, mirror spheres, a lit plane."""
import json
import math
import struct
import zlib


def write_png(path, width, height, value):
    """8-bit gray; value(x, y) in [0, 1]."""
    rows = b"".join(b"\0" + bytes(max(0, min(255, int(255 * value(x, y) + 0.5))) for x in range(width)) for y in range(height))
    part = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + part(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) + part(b"IDAT", zlib.compress(rows, 1)) +
                     part(b"IEND", b""))


def add(a, b, s=1.0):
    return [x + s * y for x, y in zip(a, b)]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def unit(a):
    n = math.sqrt(dot(a, a))
    return [x / n for x in a]


def rotation(axis, angle):
    x, y, z = unit(axis)
    c, s, t = math.cos(angle), math.sin(angle), 1 - math.cos(angle)
    return [[t * x * x + c, t * x * y - s * z, t * x * z + s * y], [t * x * y + s * z, t * y * y + c, t * y * z - s * x],
            [t * x * z - s * y, t * y * z + s * x, t * z * z + c]]


def times(m, v):
    return [dot(row, v) for row in m]


def transposed_times(m, v):
    return [sum(m[r][c] * v[r] for r in range(3)) for c in range(3)]


class Pinhole:
    def __init__(self, width, height, focal, turn, shift):
        self.width, self.height, self.focal, self.turn, self.shift = width, height, focal, turn, shift
        self.cx, self.cy = (width - 1) / 2, (height - 1) / 2

    def pixel(self, p):
        x, y, z = add(times(self.turn, p), self.shift)
        return [self.focal * x / z + self.cx, self.focal * y / z + self.cy]

    def ray(self, u, v):
        """Origin and unit direction in the world."""
        direction = unit(transposed_times(self.turn, [(u - self.cx) / self.focal, (v - self.cy) / self.focal, 1.0]))
        return [-c for c in transposed_times(self.turn, self.shift)], direction

    def json(self):
        return {"width": self.width, "height": self.height, "matrix": [[self.focal, 0, self.cx], [0, self.focal, self.cy], [0, 0, 1]],
                "rotation": self.turn, "translation": self.shift}


def on_plane(camera, u, v, point, normal):
    origin, direction = camera.ray(u, v)
    s = dot(add(point, origin, -1), normal) / dot(direction, normal)
    return add(origin, direction, s)


def chessboard(camera, columns, rows, side):
    """A board of inner corners (0, 0) to (columns - 1, rows - 1) times `side` on z = 0, white around; edges cover pixels as they should."""
    def wave(t, slope, last):
        """+-1 in turn between whole numbers, 0 on them; as a pixel of width `slope` averages it. Also: how much of the pixel the board covers."""
        nearest = max(-1, min(last, round(t)))
        away = max(-1.0, min(1.0, 2 * (t - nearest) / slope))
        inside = max(0.0, min(1.0, 0.5 + (t + 1) / slope)) * max(0.0, min(1.0, 0.5 + (last - t) / slope))
        return (away if nearest % 2 == 0 else -away), inside

    def value(x, y):
        p, right, below = (on_plane(camera, x + dx, y + dy, [0, 0, 0], [0, 0, 1]) for dx, dy in ((0, 0), (1, 0), (0, 1)))
        s, in_x = wave(p[0] / side, math.hypot(right[0] - p[0], below[0] - p[0]) / side, columns)
        t, in_y = wave(p[1] / side, math.hypot(right[1] - p[1], below[1] - p[1]) / side, rows)
        return 0.9 + in_x * in_y * (0.475 + 0.425 * s * t - 0.9)
    return value


def hit(origin, direction, center, radius):
    to = add(center, origin, -1)
    along = dot(to, direction)
    half = radius * radius - dot(to, to) + along * along
    return along - math.sqrt(half) if half > 0 and along > 0 else None


def mirror_spheres(camera, spheres, light, light_radius):
    """[(center, radius)] that are dark but for a ball of light; 2 x 2 rays a pixel."""
    def value(x, y):
        near = [s for s in spheres if math.dist(camera.pixel(s[0]), [x, y]) < 1.3 * camera.focal * s[1] / camera.shift[2]]
        total = 0.0
        for k in range(4 if near else 0):
            origin, direction = camera.ray(x + (k % 2 - 0.5) / 2, y + (k // 2 - 0.5) / 2)
            for center, radius in near:
                s = hit(origin, direction, center, radius)
                if s is None:
                    continue
                p = add(origin, direction, s)
                n = [c / radius for c in add(p, center, -1)]
                total += (0.9 if hit(p, add(direction, n, -2 * dot(direction, n)), light, light_radius) else 0.05) / 4
        return total
    return value


def sphere_mask(camera, center, radius):
    return lambda x, y: float(hit(*camera.ray(x, y), center, radius) is not None) if math.dist(camera.pixel(center), [x, y]) < 2 * camera.focal * radius / camera.shift[2] else 0.0


def lit_plane(camera, point, normal, light, intensity, albedo=1.0):
    """Linear values; every pixel sees the plane."""
    normal = unit(normal)

    def value(x, y):
        p = on_plane(camera, x, y, point, normal)
        to = add(light, p, -1)
        return albedo / math.pi * intensity * max(0.0, dot(unit(to), normal)) / dot(to, to)
    return value


def save(path, content):
    path.write_text(json.dumps(content))
