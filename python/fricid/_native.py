"""Finds and loads the compiled module for this processor."""
import importlib.machinery
import importlib.util
import pathlib
import sys

_FOLDER = pathlib.Path(__file__).parent / "_native"


def load() -> None:
    """Makes fricid._core importable."""
    suffix = importlib.machinery.EXTENSION_SUFFIXES[0]
    path = _FOLDER / f"_core{suffix}"
    if not path.exists():
        raise ImportError(f"{path} is missing; install fricid again")
    loader = importlib.machinery.ExtensionFileLoader("fricid._core", str(path))
    spec = importlib.util.spec_from_file_location("fricid._core", path, loader=loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["fricid._core"] = module
    loader.exec_module(module)
