"""Fetches the public logs of real arms that are not there yet: fetch.py DIR [SCENE...]

Files, URLs and hashes are in files.txt. FRICID_REALLOGS_URL names a server that has all of them as FOLDER/FILE. A file that is published
in another form must be put into its folder. Prints the scenes whose logs are all there; without SCENE the others are left out.
One line on stderr and exit 2 when a file cannot be had or is another one; no file is ever there in part.
"""
import argparse
import hashlib
import http.client
import os
import pathlib
import sys
import urllib.error
import urllib.request

TIMEOUT_S = 60


def sha256(path):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_table(path):
    """(hash, scene, folder/file, URL or -, how it is had) per file"""
    lines = [line.split(maxsplit=4) for line in path.read_text().splitlines() if line and line[0] != "#"]
    return [(*fields, "")[:5] for fields in lines]


def fetch(url, path, expected):
    """Downloads beside the file, and renames what has the right hash."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.part")
    try:
        with urllib.request.urlopen(url, timeout=TIMEOUT_S) as source, open(part, "wb") as target:
            while block := source.read(1 << 20):
                target.write(block)
            # of a connection that breaks, read() returns what there is
            if source.length:
                raise http.client.IncompleteRead(b"", source.length)
        found = sha256(part)
        if found != expected:
            raise SystemExit(f"{path}: SHA-256 of {url} is {found}, not {expected}")
        os.replace(part, path)
    except (OSError, ValueError, http.client.HTTPException) as error:
        reason = " ".join(str(error).split())
        raise SystemExit(f"{path}: cannot be had from {url}: {reason}")
    finally:
        part.unlink(missing_ok=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*", help="by default those whose logs can be had")
    parser.add_argument("--table", type=pathlib.Path, default=pathlib.Path(__file__).with_name("files.txt"))
    options = parser.parse_args()
    mirror = os.environ.get("FRICID_REALLOGS_URL", "").rstrip("/")
    table = read_table(options.table)
    known = list(dict.fromkeys(scene for _, scene, *_ in table))
    for scene in options.scenes:
        if scene not in known:
            raise SystemExit(f"{scene}: no public log; there are {', '.join(known)}")

    ready = []
    for scene in options.scenes or known:
        absent = []
        for expected, _, name, url, how in (row for row in table if row[1] == scene):
            path = options.folder / name
            source = f"{mirror}/{name}" if mirror else url
            if path.exists():
                found = sha256(path)
                if found != expected:
                    origin = how if source == "-" else source
                    raise SystemExit(f"{path}: SHA-256 is {found}, not {expected} ({origin})")
            elif source != "-":
                fetch(source, path, expected)
                print(f"fetched {path}", file=sys.stderr)
            else:
                absent.append(f"{path} is not there, put it there: {how}")
        if absent and options.scenes:
            raise SystemExit(absent[0])
        if absent:
            print(f"{scene} is left out: {absent[0]}", file=sys.stderr)
        else:
            ready.append(scene)
    print(",".join(ready))


if __name__ == "__main__":
    try:
        main()
    except SystemExit as stop:
        if isinstance(stop.code, str):
            print(stop.code, file=sys.stderr)
            sys.exit(2)
        raise
