"""Finds and loads the compiled module."""
import csv
import importlib.machinery
import importlib.util
import pathlib
import sys

_PACKAGE = pathlib.Path(__file__).parent

#: Folder of the robots and scenes that come with fricid: models/, scenes/.
SHARE = _PACKAGE / "share" / "fricid"


def load() -> None:
    """Makes fricid._core importable."""
    path = _PACKAGE / "_native" / f"_core{importlib.machinery.EXTENSION_SUFFIXES[0]}"
    if not path.exists():
        raise ImportError(f"{path} is missing; install fricid again")
    _refuse_torn_libraries()
    loader = importlib.machinery.ExtensionFileLoader("fricid._core", str(path))
    spec = importlib.util.spec_from_file_location("fricid._core", path, loader=loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["fricid._core"] = module
    try:
        loader.exec_module(module)
    except BaseException:
        del sys.modules["fricid._core"]
        raise


def _refuse_torn_libraries() -> None:
    """A shared library that lost its end would not fail to load, but end the process."""
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
