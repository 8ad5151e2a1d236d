"""Puts the licences of what a wheel bundles into fricid/licences of it: licences.py UNPACKED_WHEEL.

One folder per shared library, named after it, with the copyright file of the Debian package that it is from; MuJoCo's
comes with the build. `headers` has those of what the modules contain, `common-licenses` the texts that copyright files refer to.
"""
import pathlib
import re
import shutil
import subprocess
import sys

DOC, COMMON = pathlib.Path("/usr/share/doc"), pathlib.Path("/usr/share/common-licenses")
# Debian and Python packages whose headers the modules contain.
HEADERS = ("libeigen3-dev", "nlohmann-json3-dev", "libcli11-dev", "libtomlplusplus-dev")
PYTHON_HEADERS = ("nanobind",)
OURS = ("_core", "libfricid_mujoco", "libcurl")  # the last stands in for another: no_curl.c


def fail(sentence):
    sys.exit(f"python/licences.py: {sentence}")


def package_of(library):
    """The Debian package of a library that auditwheel copied, by its name without the hash."""
    original = re.sub(r"-[0-9a-f]{8}(?=\.so)", "", library)
    found = subprocess.run(["dpkg-query", "-S", f"*/{original}"], capture_output=True, text=True).stdout
    if not found:
        fail(f"{original} is of no Debian package, so its licence is not known")
    return found.partition(":")[0]


def copy_copyright(package, folder, common):
    text = DOC / package / "copyright"
    if not text.exists():
        fail(f"{text} is missing, the licence of a bundled library")
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(text, folder / f"{package}.txt")
    for name in set(re.findall(r"common-licenses/([\w.+-]*\w)", text.read_text(errors="replace"))):
        if (COMMON / name).exists():
            common.mkdir(exist_ok=True)
            shutil.copyfile(COMMON / name, common / name)


def copy_python_licences(package, folder):
    for record in pathlib.Path(sys.prefix).glob(f"lib/python*/site-packages/{package}-*.dist-info"):
        for text in record.rglob("LICEN*"):
            if text.is_file():
                shutil.copyfile(text, folder / f"{package}.txt")
                return
    fail(f"the licence of {package} is missing in {sys.prefix}")


def main(wheel):
    licences = wheel / "fricid" / "licences"
    for library in sorted(wheel.rglob("*.so*")):
        folder = licences / library.name
        if library.name.startswith(OURS):
            continue
        if library.parent.name == "fricid.libs":
            copy_copyright(package_of(library.name), folder, licences / "common-licenses")
        elif not folder.is_dir():
            fail(f"{library.name} has no licence")
    for package in HEADERS:
        copy_copyright(package, licences / "headers", licences / "common-licenses")
    for package in PYTHON_HEADERS:
        copy_python_licences(package, licences / "headers")


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
