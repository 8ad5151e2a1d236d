"""Writes meshes/*.obj, kr6_r700.urdf and kr6_r700.xml beside this folder (Python, nothing else).

    python3 models/kr6_r700/generate/main.py [mesh ...]

With names, only those meshes are made again; the two descriptions are always written.
"""

import sys
from pathlib import Path

import descriptions
import links
import meshing


def main(wanted):
    target = Path(__file__).resolve().parent.parent
    folder = target / "meshes"
    folder.mkdir(exist_ok=True)
    trim = links.trim()
    unknown = set(wanted) - set(links.CASTINGS) - set(trim)
    if unknown:
        sys.exit(f"unknown mesh {sorted(unknown)}; known: {sorted([*links.CASTINGS, *trim])}")
    for name, (solid, low, high, cell, vertices) in links.CASTINGS.items():
        if not wanted or name in wanted:
            mesh = meshing.thin(meshing.polygonize(solid(), low, high, cell), vertices)
            write(folder, name, mesh)
    for name, (_, _, mesh) in trim.items():
        if not wanted or name in wanted:
            write(folder, name, mesh)
    for name, content in (
        ("kr6_r700.urdf", descriptions.urdf(trim)),
        ("kr6_r700.xml", descriptions.mjcf()),
        ("kr6_r700_common.xml", descriptions.mjcf_common(trim)),
        ("kr6_r700_body.xml", descriptions.mjcf_body(trim)),
    ):
        (target / name).write_text(content, encoding="ascii")


def write(folder, name, mesh):
    meshing.write_obj(folder / f"{name}.obj", mesh, f"KR 6 R700, {name}")
    print(f"{name}: {len(mesh[0])} vertices, {len(mesh[2])} triangles")


if __name__ == "__main__":
    main(sys.argv[1:])
