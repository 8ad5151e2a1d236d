"""Finds and loads the compiled module for this processor."""
import csv
import importlib.machinery
import importlib.util
import os
import pathlib
import sys
from collections.abc import Set

_PACKAGE = pathlib.Path(__file__).parent

#: Folder of the robots and scenes that come with fricid: models/, scenes/.
SHARE = _PACKAGE / "share" / "fricid"

#: The engine plugin for MuJoCo, for mujoco.mj_loadPluginLibrary (docs/use_it.md).
MUJOCO_PLUGIN = _PACKAGE / "_native" / "libfricid_mujoco.so"

# What /proc/cpuinfo calls the instructions of a level of x86-64, beyond those of every such processor.
_V3 = {"avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe"}
_NEEDED: dict[str, Set[str]] = {
    "native": set(),  # compiled on this machine
    "x86-64-v4": _V3 | {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"},
    "x86-64-v3": _V3,
}


def load() -> str:
    """Makes fricid._core importable, by the best module that the processor can run.

    FRICID_INSTRUCTIONS=x86-64-v3 picks one by name. Returns the name.
    """
    folder = _PACKAGE / "_native"
    modules = {name: path for name in _NEEDED for path in folder.glob(f"_core.{name}*.so")}
    if not modules:
        raise ImportError(f"{folder}/_core is missing; install fricid again")
    _refuse_torn_libraries()
    name = _choose(set(modules))
    path = str(modules[name])
    loader = importlib.machinery.ExtensionFileLoader("fricid._core", path)
    spec = importlib.util.spec_from_file_location("fricid._core", path, loader=loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["fricid._core"] = module
    try:
        loader.exec_module(module)
    except BaseException:
        del sys.modules["fricid._core"]
        raise
    return name


def _choose(names: Set[str]) -> str:
    wanted = os.environ.get("FRICID_INSTRUCTIONS")
    if wanted and wanted not in names:
        raise ImportError(
            f"FRICID_INSTRUCTIONS = {wanted}; allowed: {', '.join(sorted(names))}"
        )
    has = _instructions()
    for name, needed in _NEEDED.items():
        if name in names and needed <= has and wanted in (None, "", name):
            return name
    missing = _NEEDED[wanted or "x86-64-v3"] - has
    raise ImportError(
        f"this processor lacks {' '.join(sorted(missing))}; fricid is compiled for "
        f"{', '.join(sorted(names))}"
    )


def _instructions() -> Set[str]:
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        if line.startswith("flags"):
            return set(line.partition(":")[2].split())
    return set()


def _refuse_torn_libraries() -> None:
    """A truncated shared library would crash the process instead of failing to load."""
    root = _PACKAGE.parent
    for record in root.glob("fricid-*.dist-info/RECORD"):
        for name, _, size in csv.reader(record.read_text().splitlines()):
            if ".so" not in name:
                continue
            library = root / name
            if not library.exists():
                raise ImportError(f"{library} is missing; install fricid again")
            if library.stat().st_size != int(size):
                raise ImportError(
                    f"{library} is torn: {library.stat().st_size} of {size} bytes; "
                    "install fricid again"
                )
