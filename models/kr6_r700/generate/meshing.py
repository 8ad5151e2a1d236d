"""Triangle meshes: from a signed distance function, as a solid of revolution, thinned, as OBJ.

A mesh is (points, normals, faces): lists of (x, y, z) [mm] and of index triples, counter-clockwise
seen from outside. Normals are exact normals of the surface, so that few triangles shade smoothly.
"""

import heapq
from math import ceil, cos, pi, radians, sin, sqrt


def polygonize(solid, low, high, cell):
    """Surface nets of the zero level inside the box [low, high], vertices moved onto the level."""
    size = max(high[i] - low[i] for i in range(3)) + 4.0 * cell
    levels = ceil(size / cell).bit_length()
    origin = [0.5 * (low[i] + high[i]) - 0.5 * cell * (1 << levels) for i in range(3)]

    def at(i, j, k):
        return origin[0] + i * cell, origin[1] + j * cell, origin[2] + k * cell

    # Descend only into cubes that the surface can cross.
    cells = []
    stack = [(0, 0, 0, 1 << levels)]
    while stack:
        i, j, k, n = stack.pop()
        d = solid(*at(i + 0.5 * n, j + 0.5 * n, k + 0.5 * n))
        if abs(d) > 1.1 * 0.5 * sqrt(3.0) * n * cell:
            continue
        if n == 1:
            cells.append((i, j, k))
            continue
        h = n // 2
        stack += [(i + a, j + b, k + c, h) for a in (0, h) for b in (0, h) for c in (0, h)]

    values = {}

    def value(corner):
        if corner not in values:
            values[corner] = solid(*at(*corner))
        return values[corner]

    corners = [(a, b, c) for a in (0, 1) for b in (0, 1) for c in (0, 1)]
    edges = [
        (p, q)
        for p in corners
        for q in corners
        if sum(abs(s - t) for s, t in zip(p, q)) == 1 and p < q
    ]
    index, points = {}, []
    for i, j, k in cells:
        v = {c: value((i + c[0], j + c[1], k + c[2])) for c in corners}
        crossings = []
        for p, q in edges:
            if (v[p] < 0.0) != (v[q] < 0.0):
                w = v[p] / (v[p] - v[q])
                crossings.append([p[a] + w * (q[a] - p[a]) for a in range(3)])
        if crossings:
            mean = [sum(c[a] for c in crossings) / len(crossings) for a in range(3)]
            index[i, j, k] = len(points)
            points.append(at(i + mean[0], j + mean[1], k + mean[2]))

    # One quad around each grid edge whose ends differ in sign.
    faces = []
    around = {
        0: ((0, 0, 0), (0, -1, 0), (0, -1, -1), (0, 0, -1)),
        1: ((0, 0, 0), (0, 0, -1), (-1, 0, -1), (-1, 0, 0)),
        2: ((0, 0, 0), (-1, 0, 0), (-1, -1, 0), (0, -1, 0)),
    }
    for i, j, k in index:
        for axis in range(3):
            a, b = value((i, j, k)), value((i + (axis == 0), j + (axis == 1), k + (axis == 2)))
            if (a < 0.0) == (b < 0.0):
                continue
            quad = [index[i + s, j + t, k + u] for s, t, u in around[axis]]
            if a >= 0.0:
                quad.reverse()
            faces.append((quad[0], quad[1], quad[2]))
            faces.append((quad[0], quad[2], quad[3]))

    normals = []
    for m, p in enumerate(points):
        for _ in range(3):
            g, d = _gradient(solid, p), solid(*p)
            squared = sum(s * s for s in g)
            p = tuple(p[a] - min(max(d, -cell), cell) * g[a] / squared for a in range(3))
        points[m] = p
        normals.append(_unit(_gradient(solid, p)))
    return points, normals, faces


def _gradient(solid, p, h=0.05):
    x, y, z = p
    return (
        (solid(x + h, y, z) - solid(x - h, y, z)) / (2 * h),
        (solid(x, y + h, z) - solid(x, y - h, z)) / (2 * h),
        (solid(x, y, z + h) - solid(x, y, z - h)) / (2 * h),
    )


def _unit(v):
    length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) or 1.0
    return v[0] / length, v[1] / length, v[2] / length


def thin(mesh, vertices):
    """Half-edge collapses until few vertices are left, cheapest first.

    The cost of a face is area * sum over its corners of |n_face - n_corner|^2, the error that is
    seen in its shading; plus a distance term that keeps outlines. Vertices never move.
    """
    points, normals, faces = mesh
    faces = [list(f) for f in faces]
    touching = [set() for _ in points]
    for f, face in enumerate(faces):
        for v in face:
            touching[v].add(f)

    def face_cost(a, b, c):
        pa, pb, pc = points[a], points[b], points[c]
        ux, uy, uz = pb[0] - pa[0], pb[1] - pa[1], pb[2] - pa[2]
        vx, vy, vz = pc[0] - pa[0], pc[1] - pa[1], pc[2] - pa[2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        double_area = sqrt(nx * nx + ny * ny + nz * nz)
        if double_area < 1e-9:
            return None
        nx, ny, nz = nx / double_area, ny / double_area, nz / double_area
        longest = max(
            ux * ux + uy * uy + uz * uz,
            vx * vx + vy * vy + vz * vz,
            (ux - vx) ** 2 + (uy - vy) ** 2 + (uz - vz) ** 2,
        )
        # Needles shade badly.
        if double_area < 0.04 * longest:
            return None
        cost = 0.0
        for m in (normals[a], normals[b], normals[c]):
            dot = nx * m[0] + ny * m[1] + nz * m[2]
            if dot < 0.5:
                return None
            cost += 2.0 - 2.0 * dot
        return cost * (double_area + 0.05 * longest)

    def collapse_cost(u, v):
        """Extra cost of moving u onto v; None where the surface would fold."""
        cost = 0.0
        for f in touching[u]:
            a, b, c = faces[f]
            old = face_cost(a, b, c)
            if old is not None:
                cost -= old
            if v in (a, b, c):
                continue
            new = face_cost(v if a == u else a, v if b == u else b, v if c == u else c)
            if new is None:
                return None
            cost += new
        return cost

    def neighbours(u):
        return {v for f in touching[u] for v in faces[f]} - {u}

    def best(u):
        options = []
        around_u = neighbours(u)
        for v in sorted(around_u):
            # An edge of a closed surface has two common neighbours; more would pinch it.
            if len(around_u & neighbours(v)) != 2:
                continue
            cost = collapse_cost(u, v)
            if cost is not None:
                options.append((cost, v))
        return min(options) if options else None

    alive = len(points)
    stamp = [0] * len(points)
    heap = []
    for u in range(len(points)):
        option = best(u)
        if option:
            heap.append((option[0], u, option[1], 0))
    heapq.heapify(heap)
    while alive > vertices and heap:
        cost, u, v, made = heapq.heappop(heap)
        if not touching[u]:
            continue
        if made != stamp[u]:
            option = best(u)
            if option:
                heapq.heappush(heap, (option[0], u, option[1], stamp[u]))
            continue
        ring = neighbours(u)
        for f in list(touching[u]):
            if v in faces[f]:
                for w in faces[f]:
                    touching[w].discard(f)
                faces[f] = None
            else:
                faces[f][faces[f].index(u)] = v
                touching[v].add(f)
        touching[u] = set()
        alive -= 1
        for w in ring:
            stamp[w] += 1
    return _compact(points, normals, [f for f in faces if f])


def _compact(points, normals, faces):
    used = sorted({v for f in faces for v in f})
    number = {v: m for m, v in enumerate(used)}
    return (
        [points[v] for v in used],
        [normals[v] for v in used],
        [tuple(number[v] for v in f) for f in faces],
    )


def revolve(axis, profile, segments=48):
    """Solid of revolution about a coordinate axis through the origin.

    profile: corners (t, r) of half the section, with the material on the right-hand side when
    one walks along it and t grows to the front (t along the axis, r to the left). Corners below
    40 degrees are shaded smoothly, sharper ones stay sharp.
    """
    pieces = [(p, q) for p, q in zip(profile, profile[1:]) if p != q]
    directions = [_unit((q[0] - p[0], q[1] - p[1], 0.0)) for p, q in pieces]
    points, normals, faces = [], [], []

    def circle_of_points(t, r, nt, nr):
        first, count = len(points), 1 if r == 0.0 else segments
        for s in range(count):
            a = 2.0 * pi * s / segments
            points.append(_about(axis, t, r * cos(a), r * sin(a)))
            normals.append(_unit(_about(axis, nt, nr * cos(a), nr * sin(a))))
        return [first + s % count for s in range(segments)]

    previous = None
    for n, ((t0, r0), (t1, r1)) in enumerate(pieces):
        dt, dr, _ = directions[n]
        shared = previous is not None and _dot2(directions[n - 1], directions[n]) > cos(radians(40))
        start = previous if shared else circle_of_points(t0, r0, -dr, dt)
        following = directions[n + 1] if n + 1 < len(pieces) else None
        if following and _dot2(directions[n], following) > cos(radians(40)):
            dt, dr = dt + following[0], dr + following[1]
        end = circle_of_points(t1, r1, -dr, dt)
        for s in range(segments):
            a, b = start[s], start[(s + 1) % segments]
            c, d = end[s], end[(s + 1) % segments]
            if a != b:
                faces.append((a, b, c))
            if c != d:
                faces.append((b, d, c))
        previous = end
    return points, normals, [_turned(points, normals, f) for f in faces]


def _dot2(a, b):
    return a[0] * b[0] + a[1] * b[1]


def _turned(points, normals, face):
    """The face in the order that agrees with the normals of its corners."""
    p, q, r = (points[v] for v in face)
    u = [q[i] - p[i] for i in range(3)]
    v = [r[i] - p[i] for i in range(3)]
    n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    along = sum(n[i] * sum(normals[c][i] for c in face) for i in range(3))
    return face if along > 0.0 else (face[0], face[2], face[1])


def _about(axis, t, u, v):
    return {"x": (t, u, v), "y": (v, t, u), "z": (u, v, t)}[axis]


def moved(mesh, dx, dy, dz):
    points, normals, faces = mesh
    return [(x + dx, y + dy, z + dz) for x, y, z in points], normals, faces


def mirrored(mesh, axis):
    """The mirror image in the plane through the origin that is normal to the axis."""
    i = "xyz".index(axis)

    def flip(v):
        return tuple(-c if a == i else c for a, c in enumerate(v))

    points, normals, faces = mesh
    return [flip(p) for p in points], [flip(n) for n in normals], [(a, c, b) for a, b, c in faces]


def joined(*meshes):
    points, normals, faces = [], [], []
    for p, n, f in meshes:
        first = len(points)
        points += p
        normals += n
        faces += [tuple(first + v for v in face) for face in f]
    return points, normals, faces


def write_obj(path, mesh, title):
    """OBJ in millimetres with one normal per vertex."""
    points, normals, faces = mesh

    def number(value, digits):
        text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
        return "0" if text in ("-0", "") else text

    with open(path, "w", encoding="ascii", newline="\n") as out:
        out.write(f"# {title}, millimetres\n# SPDX-License-Identifier: Apache-2.0\n")
        for p in points:
            out.write("v " + " ".join(number(c, 2) for c in p) + "\n")
        for n in normals:
            out.write("vn " + " ".join(number(c, 3) for c in n) + "\n")
        for f in faces:
            out.write("f " + " ".join(f"{v + 1}//{v + 1}" for v in f) + "\n")
