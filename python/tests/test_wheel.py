"""The wheel: nothing of the system beyond Python, its size, its types, and a wheel that was torn."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import zipfile

import pytest

import fricid
from fricid import _native

WHEEL = pathlib.Path(os.environ["FRICID_WHEEL"])
PACKAGE = pathlib.Path(fricid.__file__).parent

# What any Linux with Python has: the C and C++ libraries, and zlib, which Python needs itself.
OF_ANY_LINUX = {"libc.so.6", "libm.so.6", "libdl.so.2", "libpthread.so.0", "librt.so.1", "libgcc_s.so.1", "libstdc++.so.6",
                "libz.so.1", "ld-linux-x86-64.so.2", "linux-vdso.so.1"}


def test_libraries_come_with_the_wheel():
    modules = list(PACKAGE.rglob("_core*.so"))
    assert modules
    inside = PACKAGE.parent
    for module in modules:
        linked = subprocess.run(["ldd", module], capture_output=True, text=True, check=True).stdout
        for line in linked.splitlines():
            name, _, rest = line.strip().partition(" ")
            path = re.search(r"=> (\S+)", line)
            if pathlib.Path(name).name in OF_ANY_LINUX:
                continue
            assert path and pathlib.Path(path[1]).resolve().is_relative_to(inside.resolve()), line


def test_tag_and_size():
    assert re.search(r"manylinux_2_\d+_x86_64\.whl$", WHEEL.name), WHEEL.name
    assert WHEEL.stat().st_size < 60e6
    with zipfile.ZipFile(WHEEL) as content:
        names = content.namelist()
    for wanted in ("fricid/py.typed", "fricid/_core.pyi", "fricid/share/fricid/scenes/kr6_demo.toml",
                   "fricid/_native/libfricid_mujoco.so"):
        assert wanted in names
    assert not [name for name in names if name.endswith((".a", ".hpp", ".cpp", ".cmake"))]


def test_every_library_has_its_licence():
    with zipfile.ZipFile(WHEEL) as content:
        names = content.namelist()
        libraries = [pathlib.PurePath(name).name for name in names if re.search(r"\.so[.\d]*$", name)]
        others = [name for name in libraries if not name.startswith(("_core", "libfricid_mujoco", "libcurl"))]
        assert any(name.startswith("libhdf5") for name in others) and any(name.startswith("libmujoco") for name in others)
        for library in [*others, "headers"]:
            texts = [content.read(name).decode(errors="replace") for name in names
                     if name.startswith(f"fricid/licences/{library}/")]
            assert any(re.search("copyright", text, re.I) and re.search("licen[cs]e|redistribution|public domain", text, re.I)
                       for text in texts), library
        for package in ("libeigen3-dev", "nanobind"):
            assert f"fricid/licences/headers/{package}.txt" in names
        # what copyright files refer to is there too
        for name in names:
            if name.startswith("fricid/licences/lib"):
                for common in re.findall(r"/usr/share/common-licenses/([\w.+-]*\w)", content.read(name).decode(errors="replace")):
                    assert f"fricid/licences/common-licenses/{common}" in names, (name, common)


def mypy(*arguments, cwd):
    return subprocess.run([sys.executable, "-m", "mypy", "--strict", *map(str, arguments)], capture_output=True, text=True,
                          cwd=cwd)


USES = """
import numpy as np
import fricid

run: fricid.Run = fricid.simulate({"extends": "scenes/kr6_demo.toml"}, "run", progress=lambda *report: None)
model: fricid.Model = run.models["lugre_s1"]
tau_f = model.friction.torque(np.zeros(6), [0.0] * 6, model.friction.rest())
shape: tuple[int, ...] = tau_f.shape
now: fricid.Estimate = model.filter(np.zeros(6), 250.0).update(np.zeros(6), np.zeros(6))
motion: fricid.Motion = model.rollout(run.logs["validation_0"], seconds=1.0)
whole: bool = fricid.check(run).whole
"""


def test_types(tmp_path):
    (tmp_path / "uses.py").write_text(USES)
    done = mypy("uses.py", cwd=tmp_path)
    assert done.returncode == 0, done.stdout
    (tmp_path / "wrong.py").write_text(USES + 'model.filter(np.zeros(6), "fast")\nfricid.simulate(5, "run")\nmodel.nothing\n')
    done = mypy("wrong.py", cwd=tmp_path)
    assert done.stdout.count("error:") == 3, done.stdout


def test_the_package_is_typed(tmp_path):
    # the stub generator writes os.PathLike without its argument
    done = mypy("--allow-any-generics", "-p", "fricid", cwd=tmp_path)
    assert done.returncode == 0, done.stdout


def import_of(copy):
    """What `import fricid` of a copy of the package, and a run of it, end with."""
    code = "import fricid; fricid.simulate({'extends': 'scenes/kr6_demo.toml'}, 'x/y', jobs=1)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=copy,
                          env=os.environ | {"PYTHONPATH": str(copy)})
    assert done.returncode == 1, done.stderr
    return done.stderr.splitlines()[-1]


@pytest.fixture()
def copy(tmp_path):
    """The installed package where it may be damaged."""
    for folder in PACKAGE.parent.glob("fricid*"):
        shutil.copytree(folder, tmp_path / folder.name)
    return tmp_path


def test_a_missing_module(copy):
    for module in (copy / "fricid/_native").glob("_core*.so"):
        module.unlink()
    assert re.search(r"^ImportError: .*_core.* is missing; install fricid again$", import_of(copy))


def test_a_torn_module(copy):
    for module in (copy / "fricid/_native").glob("_core*.so"):
        content = module.read_bytes()
        module.write_bytes(content[: len(content) // 2])
    assert re.search(r"^ImportError: .*_core.* is torn.*; install fricid again$", import_of(copy))


def test_a_torn_library(copy):
    library = next((copy / "fricid.libs").glob("libhdf5*"))
    library.write_bytes(library.read_bytes()[:-5000])
    assert re.search(r"^ImportError: .*libhdf5.* is torn.*; install fricid again$", import_of(copy))


def test_a_torn_or_missing_plugin(copy):
    plugin = copy / "fricid/_native/libfricid_mujoco.so"
    plugin.write_bytes(plugin.read_bytes()[:-1])
    assert re.search(r"^ImportError: .*libfricid_mujoco.so is torn.*; install fricid again$", import_of(copy))
    plugin.unlink()
    assert re.search(r"^ImportError: .*libfricid_mujoco.so is missing; install fricid again$", import_of(copy))


def test_a_torn_scene_or_robot(copy):
    share = copy / "fricid/share/fricid"
    urdf = share / "models/kr6_r700/kr6_r700.urdf"
    text = urdf.read_text()
    urdf.write_text(text[: len(text) // 2])
    assert re.search(r"UserError: .*kr6_r700.urdf", import_of(copy))
    (share / "scenes/kr6_full.toml").unlink()
    assert re.search(r"UserError: .*kr6_full.toml", import_of(copy))


V3 = _native._NEEDED["x86-64-v3"]
V4 = _native._NEEDED["x86-64-v4"]
BOTH = {"x86-64-v3", "x86-64-v4"}


@pytest.mark.parametrize("names, has, wanted, chosen", [
    (BOTH, V4, "", "x86-64-v4"),
    (BOTH, V3 | {"avx512f"}, "", "x86-64-v3"),
    (BOTH, V4, "x86-64-v3", "x86-64-v3"),
    ({"native"}, set(), "", "native"),
])
def test_the_best_module_that_runs_is_chosen(monkeypatch, names, has, wanted, chosen):
    monkeypatch.setattr(_native, "_instructions", lambda: set(has))
    monkeypatch.setenv("FRICID_INSTRUCTIONS", wanted)
    assert _native._choose(names) == chosen


@pytest.mark.parametrize("names, has, wanted, sentence", [
    (BOTH, V3 - {"avx2"}, "", "this processor lacks avx2; fricid is compiled for x86-64-v3, x86-64-v4"),
    (BOTH, V3, "x86-64-v4", "this processor lacks avx512bw avx512cd avx512dq avx512f avx512vl; fricid is compiled"),
    (BOTH, V4, "sse", "FRICID_INSTRUCTIONS = sse; allowed: x86-64-v3, x86-64-v4"),
])
def test_a_processor_that_runs_none_is_told(monkeypatch, names, has, wanted, sentence):
    monkeypatch.setattr(_native, "_instructions", lambda: set(has))
    monkeypatch.setenv("FRICID_INSTRUCTIONS", wanted)
    with pytest.raises(ImportError, match=sentence):
        _native._choose(names)


def test_this_processor_is_known():
    assert {"fma", "avx2"} <= _native._instructions()
