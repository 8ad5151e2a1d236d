"""Collision shapes of the links in their own frames [m]: capsules, cylinders, boxes, spheres."""

from math import atan2, hypot

# Link -> shapes. A capsule or cylinder is (kind, end, end, radius), a box (kind, low, high),
# a sphere (kind, centre, radius).
SHAPES = {
    "base_link": [
        ("cylinder", (0, 0, 0), (0, 0, 0.213), 0.106),
        ("box", (-0.221, -0.104, 0), (0, 0.104, 0.207)),
        ("box", (-0.216, -0.06, 0.207), (-0.139, 0.06, 0.261)),
        ("box", (-0.107, -0.107, 0), (0.107, 0.107, 0.022)),
    ],
    "link_1": [
        ("cylinder", (0.008, 0, -0.183), (0.008, 0, -0.06), 0.125),
        ("cylinder", (0.025, -0.141, 0), (0.025, 0.141, 0), 0.087),
        ("box", (-0.085, -0.132, -0.12), (0.12, 0.132, 0)),
    ],
    "link_2": [
        ("cylinder", (0, -0.071, 0), (0, 0.063, 0), 0.089),
        ("box", (0.05, -0.074, -0.07), (0.11, 0.066, 0.07)),
        ("box", (0.11, -0.085, -0.058), (0.19, 0.078, 0.058)),
        ("cylinder", (0.315, -0.132, 0), (0.315, 0.123, 0), 0.088),
        ("box", (0.18, -0.128, -0.066), (0.26, -0.07, 0.066)),
        ("box", (0.18, 0.07, -0.066), (0.26, 0.119, 0.066)),
        ("box", (0.18, -0.07, -0.02), (0.225, 0.07, 0.05)),
    ],
    "link_3": [
        ("cylinder", (0, -0.068, 0), (0, 0.068, 0), 0.078),
        ("cylinder", (0, 0, 0.035), (0.108, 0, 0.035), 0.057),
    ],
    "link_4": [
        ("cylinder", (0.109, 0, 0), (0.17, 0, 0), 0.064),
        ("capsule", (0.176, 0.002, 0.001), (0.252, 0.002, 0.001), 0.068),
        ("box", (0.172, -0.028, 0), (0.272, 0.028, 0.078)),
        ("cylinder", (0.365, -0.066, 0), (0.365, -0.038, 0), 0.044),
        ("cylinder", (0.365, 0.04, 0), (0.365, 0.071, 0), 0.044),
        ("box", (0.28, -0.066, -0.047), (0.365, -0.038, 0.047)),
        ("box", (0.28, 0.04, -0.047), (0.365, 0.07, 0.047)),
    ],
    "link_5": [
        ("cylinder", (0, -0.037, 0), (0, 0.039, 0), 0.04),
        ("cylinder", (0, 0, 0), (0.079, 0, 0), 0.037),
    ],
    "link_6": [("cylinder", (-0.0135, 0, 0), (0.0005, 0, 0), 0.02)],
}


def _text(values):
    return " ".join(repr(round(v, 9) + 0.0).removesuffix(".0") for v in values)


def mjcf_shapes(link):
    for n, shape in enumerate(SHAPES[link]):
        kind = shape[0]
        if kind == "box":
            low, high = shape[1:]
            middle = [0.5 * (a + b) for a, b in zip(low, high)]
            half = [0.5 * (b - a) for a, b in zip(low, high)]
            geom = f'type="box" pos="{_text(middle)}" size="{_text(half)}"'
        elif kind == "sphere":
            geom = f'type="sphere" pos="{_text(shape[1])}" size="{_text([shape[2]])}"'
        else:
            ends = _text(shape[1] + shape[2])
            geom = f'type="{kind}" fromto="{ends}" size="{_text([shape[3]])}"'
        yield f"{link}_collision_{n}", geom


def urdf_shapes(link):
    """(xyz, rpy, geometry); URDF has no capsule, so that becomes a cylinder and two spheres."""
    for shape in SHAPES[link]:
        kind = shape[0]
        if kind == "box":
            low, high = shape[1:]
            size = _text([b - a for a, b in zip(low, high)])
            yield [0.5 * (a + b) for a, b in zip(low, high)], (0, 0, 0), f'<box size="{size}"/>'
            continue
        if kind == "sphere":
            yield shape[1], (0, 0, 0), f'<sphere radius="{_text([shape[2]])}"/>'
            continue
        start, end, radius = shape[1:]
        d = [b - a for a, b in zip(start, end)]
        # Yaw and pitch that turn z into the direction of the shape.
        rpy = (0.0, atan2(hypot(d[0], d[1]), d[2]), atan2(d[1], d[0]))
        middle = [0.5 * (a + b) for a, b in zip(start, end)]
        length = hypot(*d)
        yield middle, rpy, f'<cylinder radius="{_text([radius])}" length="{_text([length])}"/>'
        if kind == "capsule":
            for centre in (start, end):
                yield centre, (0, 0, 0), f'<sphere radius="{_text([radius])}"/>'
