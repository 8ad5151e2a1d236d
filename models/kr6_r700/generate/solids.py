"""Signed distance functions of solids: negative inside, positive outside, about 1 mm per mm.

A solid is a function f(x, y, z) -> distance [mm]; a profile is a function f(u, v) -> distance [mm].
Blends follow the quadratic smooth minimum: two surfaces that meet get a fillet of about width k,
which is what makes a union of simple solids look like a casting.
"""

from math import hypot, sqrt

AXES = {"x": 0, "y": 1, "z": 2}


def smooth_min(a, b, k):
    """min(a, b) with a fillet: differs from it only where |a - b| < k, by at most k / 4."""
    h = k - abs(a - b)
    return min(a, b) - (h * h / (4.0 * k) if h > 0.0 else 0.0)


def blend_min(k, *parts):
    """Smooth union of solids or of profiles."""
    first, rest = parts[0], parts[1:]

    def distance(*p):
        d = first(*p)
        for part in rest:
            d = smooth_min(d, part(*p), k)
        return d

    return distance


def blend_max(k, *parts):
    """Smooth intersection of solids or of profiles."""
    first, rest = parts[0], parts[1:]

    def distance(*p):
        d = -first(*p)
        for part in rest:
            d = smooth_min(d, -part(*p), k)
        return -d

    return distance


def carve(k, solid, *tools):
    """Solid minus each tool, the new edges rounded with width k."""

    def distance(*p):
        d = -solid(*p)
        for tool in tools:
            d = smooth_min(d, tool(*p), k)
        return -d

    return distance


# Profiles.


def circle(u0, v0, r):
    return lambda u, v: hypot(u - u0, v - v0) - r


def rectangle(u_min, u_max, v_min, v_max):
    uc, vc = 0.5 * (u_min + u_max), 0.5 * (v_min + v_max)
    hu, hv = 0.5 * (u_max - u_min), 0.5 * (v_max - v_min)

    def distance(u, v):
        a, b = abs(u - uc) - hu, abs(v - vc) - hv
        return min(max(a, b), 0.0) + hypot(max(a, 0.0), max(b, 0.0))

    return distance


def half_plane(u0, v0, nu, nv):
    """Inside is the side that the normal (nu, nv) points away from."""
    length = hypot(nu, nv)
    nu, nv = nu / length, nv / length
    return lambda u, v: (u - u0) * nu + (v - v0) * nv


def stadium(u0, v0, u1, v1, r):
    """All points within r of the segment (u0, v0)-(u1, v1)."""
    du, dv = u1 - u0, v1 - v0
    squared = du * du + dv * dv

    def distance(u, v):
        t = ((u - u0) * du + (v - v0) * dv) / squared
        t = min(max(t, 0.0), 1.0)
        return hypot(u - u0 - t * du, v - v0 - t * dv) - r

    return distance


def polygon(points, r=0.0):
    """Simple polygon whose convex corners are rounded with r; its sides stay where they are."""
    n = len(points)
    edges = [(points[i], points[(i + 1) % n]) for i in range(n)]

    def distance(u, v):
        best, inside = 1e30, False
        for (u0, v0), (u1, v1) in edges:
            du, dv = u1 - u0, v1 - v0
            a, b = u - u0, v - v0
            t = (a * du + b * dv) / (du * du + dv * dv)
            t = min(max(t, 0.0), 1.0)
            a -= t * du
            b -= t * dv
            best = min(best, a * a + b * b)
            if (v0 > v) != (v1 > v) and u < u0 + (v - v0) * du / dv:
                inside = not inside
        return -sqrt(best) if inside else sqrt(best)

    if r <= 0.0:
        return distance
    # Rounding = shrink by r, then grow by r: convex corners get radius r.
    shrunk = polygon(_inset(points, r))
    return lambda u, v: shrunk(u, v) - r


def _inset(points, r):
    """Corners of the polygon whose sides lie r further inside (counter-clockwise order)."""
    n = len(points)
    area = sum(
        points[i][0] * points[(i + 1) % n][1] - points[(i + 1) % n][0] * points[i][1]
        for i in range(n)
    )
    if area < 0.0:
        points = points[::-1]
    lines = []
    for i in range(n):
        (u0, v0), (u1, v1) = points[i], points[(i + 1) % n]
        length = hypot(u1 - u0, v1 - v0)
        nu, nv = -(v1 - v0) / length, (u1 - u0) / length
        lines.append((nu, nv, nu * u0 + nv * v0 + r))
    corners = []
    for i in range(n):
        a0, b0, c0 = lines[i - 1]
        a1, b1, c1 = lines[i]
        det = a0 * b1 - a1 * b0
        corners.append(((c0 * b1 - c1 * b0) / det, (a0 * c1 - a1 * c0) / det))
    return corners


def band(stations):
    """Strip along u between two smooth curves; a station is (u, v_low, v_high)."""
    u_values = [s[0] for s in stations]
    low = _monotone_cubic(u_values, [s[1] for s in stations])
    high = _monotone_cubic(u_values, [s[2] for s in stations])

    def distance(u, v):
        a, b = low(u) - v, v - high(u)
        curve, d = (low, a) if a > b else (high, b)
        slope = 0.5 * (curve(u + 1.0) - curve(u - 1.0))
        return d / hypot(1.0, slope)

    return distance


# Solids.


def extrude(axis, profile, low, high, edge=0.0):
    """Profile in the two other coordinates (in the order x, y, z), from low to high along axis."""
    i = AXES[axis]

    def distance(x, y, z):
        t = (x, y, z)[i]
        d = (profile(y, z) if i == 0 else profile(x, z) if i == 1 else profile(x, y)) + edge
        h = max(low - t, t - high) + edge
        return min(max(d, h), 0.0) + hypot(max(d, 0.0), max(h, 0.0)) - edge

    return distance


def cylinder(axis, u0, v0, r, low, high, edge=0.0):
    return extrude(axis, circle(u0, v0, r), low, high, edge)


def box(low, high, edge=0.0):
    return extrude(
        "z",
        _rounded(rectangle(low[0] + edge, high[0] - edge, low[1] + edge, high[1] - edge), edge),
        low[2],
        high[2],
        edge,
    )


def _rounded(profile, r):
    return lambda u, v: profile(u, v) - r


def sphere(x0, y0, z0, r):
    return lambda x, y, z: sqrt((x - x0) ** 2 + (y - y0) ** 2 + (z - z0) ** 2) - r


def loft(axis, stations, exponent=2.0):
    """Superellipse sections along an axis.

    A station is (t, cu, cv, hu, hv): position, centre and half widths in the two other
    coordinates; between stations all four follow a monotone cubic (Fritsch-Carlson), beyond the
    ends they are constant. The solid is endless along the axis: cut it with blend_max.
    """
    i = AXES[axis]
    t = [s[0] for s in stations]
    curves = [_monotone_cubic(t, [s[k] for s in stations]) for k in range(1, 5)]

    def distance(x, y, z):
        p = (x, y, z)
        cu, cv, hu, hv = (curve(p[i]) for curve in curves)
        u, v = (y, z) if i == 0 else (x, z) if i == 1 else (x, y)
        a, b = abs(u - cu) / hu, abs(v - cv) / hv
        if exponent == 2.0:
            return (hypot(a, b) - 1.0) * min(hu, hv)
        return ((a**exponent + b**exponent) ** (1.0 / exponent) - 1.0) * min(hu, hv)

    return distance


def slab(axis, low, high):
    i = AXES[axis]
    return lambda *p: max(low - p[i], p[i] - high)


def _monotone_cubic(t, f):
    n = len(t)
    secant = [(f[i + 1] - f[i]) / (t[i + 1] - t[i]) for i in range(n - 1)]
    slope = [0.0] * n
    for i in range(1, n - 1):
        if secant[i - 1] * secant[i] > 0.0:
            slope[i] = 2.0 * secant[i - 1] * secant[i] / (secant[i - 1] + secant[i])

    def value(s):
        if s <= t[0]:
            return f[0]
        if s >= t[-1]:
            return f[-1]
        i = 0
        while s > t[i + 1]:
            i += 1
        h = t[i + 1] - t[i]
        w = (s - t[i]) / h
        w2, w3 = w * w, w * w * w
        return (
            (2 * w3 - 3 * w2 + 1) * f[i]
            + (w3 - 2 * w2 + w) * h * slope[i]
            + (3 * w2 - 2 * w3) * f[i + 1]
            + (w3 - w2) * h * slope[i + 1]
        )

    return value
