"""Shape of every link in its own frame [mm], after the outer measures listed in ../README.md.

CASTINGS maps a mesh name to (solid, box, cell, vertices); trim(name) gives the turned parts.
Shapes are our own: silhouettes, lofts and fillets chosen to meet those measures.
"""

from math import cos, pi, radians, sin

from meshing import joined, mirrored, moved, revolve
from solids import (
    band,
    blend_max,
    blend_min,
    box,
    carve,
    circle,
    cylinder,
    extrude,
    loft,
    polygon,
    rectangle,
    slab,
    sphere,
    stadium,
)


def base():
    """D-shaped block with a hump for the connectors at the back."""
    drum = cylinder("z", 0, 0, 103, -40, 213, 7)
    # Side view: upright back with chamfers, shoulder at the height of the drum.
    body = extrude(
        "y",
        polygon(
            [(0, -40), (0, 206), (-150, 206), (-205, 180), (-221, 150), (-221, 60), (-160, -40)], 9
        ),
        -103,
        103,
        14,
    )
    hump = blend_max(
        14,
        extrude(
            "y",
            polygon([(-140, 120), (-140, 261), (-172, 261), (-214, 170), (-214, 120)], 10),
            -60,
            60,
            10,
        ),
        # Front view: the hump narrows to the top.
        extrude(
            "x",
            polygon([(-70, 100), (70, 100), (60, 190), (34, 262), (-34, 262), (-60, 190)], 8),
            -230,
            0,
        ),
    )
    foot = extrude(
        "z", polygon([(106, -106), (106, 106), (-106, 106), (-106, -106)], 14), -40, 20, 5
    )
    shell = blend_max(
        3, blend_min(5, blend_min(10, blend_min(20, drum, body), hump), foot), slab("z", 0, 300)
    )
    # Shallow fields on both flanks, and the recess of the connector panel.
    field = polygon([(-190, 60), (-190, 140), (-170, 172), (-70, 172), (-70, 45), (-180, 45)], 12)
    fields = extrude("y", lambda x, z: field(x, z), 100, 130, 2)
    panel = box((-240, -80, 66), (-213, 80, 150), 6)
    return carve(6, shell, lambda x, y, z: fields(x, abs(y), z), panel)


def column():
    """Link 1: a round foot that widens into two cheeks; the axis of A2 is a barrel across."""
    side = polygon(
        [
            (-108, -240),
            (124, -240),
            (127, -150),
            (128, -60),
            (108, 30),
            (60, 66),
            (-30, 66),
            (-60, 30),
            (-96, -70),
            (-112, -150),
        ],
        30,
    )
    front = polygon(
        [
            (-110, -240),
            (110, -240),
            (116, -150),
            (137, -40),
            (137, 60),
            (120, 110),
            (-120, 110),
            (-137, 60),
            (-137, -40),
            (-116, -150),
        ],
        26,
    )
    plan = loft(
        "z",
        [
            (-183, 9, 0, 117, 111),
            (-120, 9, 0, 124, 122),
            (-40, 20, 0, 118, 139),
            (0, 22, 0, 114, 142),
            (90, 25, 0, 112, 142),
        ],
        2.7,
    )
    body = blend_max(
        20,
        extrude("y", blend_min(50, side, circle(25, 0, 76)), -160, 160),
        extrude("x", front, -200, 200),
        plan,
    )
    body = blend_max(6, body, slab("z", -183, 76))
    body = blend_min(16, body, cylinder("y", 25, 0, 85, -137, 137, 16))
    # The slot in which the boss of link 2 turns; its floor lets the arm lean forward and back.
    slot_view = blend_min(
        16,
        circle(25, 0, 93),
        polygon([(25, -92), (200, -200), (200, 200), (25, 200)]),
        polygon([(25, -92), (-200, 5), (-200, 200), (25, 200)]),
    )
    return carve(10, body, extrude("y", slot_view, -75, 68, 6))


def upper_arm():
    """Link 2: boss at A2, waist, then a fork whose cheeks hold the elbow at A3."""
    side = blend_min(60, circle(0, 0, 84), stadium(0, 0, 315, 0, 56), circle(315, 0, 81))
    plan = band(
        [
            (-90, -70, 62),
            (70, -70, 62),
            (105, -71, 64),
            (150, -82, 75),
            (210, -117, 108),
            (252, -128, 119),
            (410, -128, 119),
        ]
    )
    body = blend_max(18, extrude("y", side, -150, 150), extrude("z", plan, -120, 120))
    # Between boss and fork the sections are rounder.
    sections = loft(
        "x",
        [
            (40, -4, 0, 90, 110),
            (120, -4, 0, 80, 76),
            (160, -4, 0, 92, 76),
            (240, -4, 0, 160, 110),
            (320, -4, 0, 190, 140),
        ],
        3.0,
    )
    body = blend_max(20, body, sections)
    # Room for the elbow, and for the neck of link 3 when the arm is folded either way.
    room = blend_min(
        6,
        circle(315, 0, 77.8),
        rectangle(315, 600, -200, 200),
        stadium(329, -32, 205, -92, 60),
        stadium(295, 17, 249, 100, 56),
    )
    return carve(12, body, extrude("y", room, -70, 70, 8))


def elbow():
    """Link 3: rounded knuckle between the cheeks of link 2, with a neck to the axis of A4."""
    knuckle = blend_max(20, cylinder("y", 0, 0, 77, -67, 67, 18), sphere(0, 0, 0, 94))
    neck = loft("x", [(0, 0, 26, 50, 50), (60, 0, 34, 56, 57), (107, 0, 35, 56, 56)])
    return blend_min(26, knuckle, blend_max(6, neck, slab("x", 0, 107)))


def forearm():
    """Link 4: oval tube that swells in the middle and ends in the fork of the wrist."""
    tube = loft(
        "x",
        [
            (109, 0, 0, 56, 56),
            (140, 0, 0, 61, 56),
            (190, 2, 0, 66, 57),
            (240, 2, 0, 68, 57),
            (300, 2, 0, 67, 52),
            (365, 2, 0, 66, 46),
        ],
        2.5,
    )
    side = blend_min(
        20,
        polygon(
            [
                (109, -80),
                (109, 80),
                (250, 80),
                (330, 45),
                (365, 40),
                (365, -40),
                (330, -45),
                (250, -80),
            ],
            4,
        ),
        circle(365, 0, 41),
    )
    body = blend_max(9, tube, extrude("y", side, -90, 90))
    # Interface block for hoses and signals on top.
    block = extrude("y", polygon([(166, 30), (180, 72), (248, 72), (278, 30)], 7), -27, 27, 6)
    body = blend_min(9, body, block)
    # The gap in which the wrist turns, deep enough for +-120 degrees.
    u, w = 150 * cos(radians(118)), 150 * sin(radians(118))
    gap_view = blend_min(
        12,
        circle(365, 0, 44),
        rectangle(365, 600, -200, 200),
        stadium(365, 0, 365 + u, w, 42),
        stadium(365, 0, 365 + u, -w, 42),
    )
    return carve(8, body, extrude("y", gap_view, -37.5, 39.5, 5))


def wrist():
    """Link 5: drum about A5 and a snout along A6 with the bore of the flange."""
    drum = cylinder("y", 0, 0, 39, -36, 38, 9)
    snout = loft("x", [(0, 0, 0, 35, 35), (45, 0, 0, 35, 36), (79, 0, 0, 32.5, 33)])
    body = blend_min(10, drum, blend_max(5, snout, slab("x", 0, 79)))
    return carve(2, body, cylinder("x", 0, 0, 22, 62, 90))


CASTINGS = {
    "base_link": (base, (-226, -112, -4), (112, 112, 266), 3.5, 2400),
    "link_1": (column, (-120, -145, -188), (140, 145, 92), 4.5, 2200),
    "link_2": (upper_arm, (-95, -135, -95), (408, 130, 95), 4.5, 2600),
    "link_3": (elbow, (-82, -75, -82), (122, 75, 98), 4.0, 900),
    "link_4": (forearm, (100, -75, -66), (414, 75, 80), 3.5, 2000),
    "link_5": (wrist, (-45, -45, -45), (84, 45, 45), 2.2, 1100),
}


# Turned parts.


def cap(axis, r, height, edge=3.0, segments=48):
    """Disc with a rounded rim, from 0 to height along the axis."""
    rim = [
        (height - edge * (1.0 - sin(a)), r - edge * (1.0 - cos(a)))
        for a in (i * pi / 8 for i in range(5))
    ]
    return revolve(axis, [(0.0, r)] + rim + [(height, 0.0)], segments)


def ring(axis, r, low, high, segments=64):
    return revolve(axis, [(low, r), (high, r)], segments)


def bolts(axis, r, count, head, height):
    """Socket head screws on a circle of radius r about the axis."""
    bore = 0.5 * head
    profile = [
        (0.0, head),
        (height, head),
        (height, bore),
        (0.2 * height, bore),
        (0.2 * height, 0.0),
    ]
    screw = revolve(axis, profile, 10)
    heads = []
    for i in range(count):
        a = 2.0 * pi * (i + 0.5) / count
        u, v = r * cos(a), r * sin(a)
        heads.append(moved(screw, *{"x": (0, u, v), "y": (u, 0, v), "z": (u, v, 0)}[axis]))
    return joined(*heads)


def both_sides(x, left, right, mesh):
    """The mesh, made for the +y side, at y = left, and its mirror image at y = -right."""
    return joined(moved(mesh, x, left, 0), moved(mirrored(mesh, "y"), x, -right, 0))


def trim():
    """Turned parts: mesh name -> (link, colour, mesh)."""
    sockets = [(-46, 108, 25), (14, 108, 25), (55, 128, 10), (55, 92, 10)]
    screws = [(x, y) for x in (-90, 90) for y in (-90, 90)]
    return {
        "base_link_dark": ("base_link", "dark", ring("z", 100, 205, 222)),
        "base_link_metal": (
            "base_link",
            "metal",
            joined(
                *(moved(cap("z", 8, 6, 1.5, 16), x, y, 20) for x, y in screws),
                *(moved(mirrored(cap("x", r, 4, 1.0, 40), "x"), -212, y, z) for y, z, r in sockets),
                *(
                    moved(mirrored(cap("x", r - 3, 8, 2.0, 40), "x"), -213, y, z)
                    for y, z, r in sockets
                ),
            ),
        ),
        "link_1_covers": ("link_1", "orange", both_sides(25, 134, 134, cap("y", 62, 6))),
        "link_1_dark": (
            "link_1",
            "dark",
            both_sides(
                25,
                134,
                134,
                joined(ring("y", 64, 0, 3.6), moved(bolts("y", 52, 8, 3.6, 0.9), 0, 5.9, 0)),
            ),
        ),
        "link_2_covers": ("link_2", "orange", both_sides(315, 116, 125, cap("y", 52, 6))),
        "link_2_dark": (
            "link_2",
            "dark",
            both_sides(
                315,
                116,
                125,
                joined(ring("y", 53.5, 0, 3.8), moved(bolts("y", 43, 8, 3.6, 0.9), 0, 5.9, 0)),
            ),
        ),
        "link_3_dark": ("link_3", "dark", moved(ring("x", 53.5, 100, 116), 0, 0, 35)),
        "link_4_covers": ("link_4", "orange", both_sides(365, 66, 62, cap("y", 27, 4))),
        "link_4_dark": (
            "link_4",
            "dark",
            joined(
                ring("x", 53.5, 108.5, 112),
                both_sides(365, 69.9, 65.9, bolts("y", 20, 6, 2.6, 0.8)),
            ),
        ),
        "link_4_metal": (
            "link_4",
            "metal",
            joined(
                *(
                    moved(cap("z", 7, 6, 1.5, 20), x, y, 71)
                    for x in (196, 216, 236)
                    for y in (-11, 11)
                )
            ),
        ),
        "link_5_dark": ("link_5", "dark", ring("x", 22.3, 62, 77)),
        "link_6_metal": ("link_6", "metal", flange()),
        "link_6_dark": (
            "link_6",
            "dark",
            bolts("x", 15.75, 7, 2.5, 0.3),
        ),
    }


def flange():
    """Disc of 40 x 13.5 with the centring bore of ISO 9409-1-A31.5."""
    return revolve(
        "x", [(-13.5, 0), (-13.5, 20), (-1, 20), (0, 19), (0, 10), (-6, 10), (-6, 0)], 64
    )
