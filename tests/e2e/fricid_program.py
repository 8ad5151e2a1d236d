"""Helpers of the end-to-end tests: run the program, compare run folders."""
import atexit
import functools
import json
import os
import pathlib
import subprocess
import tempfile
import time
import unittest

PROGRAM = os.environ["FRICID_PROGRAM"]
SOURCE = pathlib.Path(os.environ["FRICID_SOURCE_DIR"])
TINY = SOURCE / "tests" / "e2e" / "tiny.toml"


# Plots take most of the seconds of a small run: without a gnuplot in the path there are none.
NO_PLOTS = {"PATH": ""}


def fricid(*arguments, environment={}, **options):
    """Runs the program; returns the finished process with text output."""
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, env=os.environ | environment, **options)


def results(folder):
    """Bytes of every result file. Clock readings are in the manifest and the report alone."""
    found = {}
    for path in sorted(pathlib.Path(folder).rglob("*")):
        name = str(path.relative_to(folder))
        if not path.is_file() or name in ("manifest.json", ".lock", "report.html"):
            continue
        if name.startswith("plots/"):
            continue
        found[name] = path.read_bytes()
    return found


@functools.cache
def tiny_run():
    """The tiny scene run once, on two threads, for all tests of a file, which leave it as it is; and the seconds that it took."""
    holder = tempfile.TemporaryDirectory()
    atexit.register(holder.cleanup)
    folder = pathlib.Path(holder.name) / "run"
    begin = time.monotonic()
    done = fricid("run", TINY, "-o", folder, "--jobs", 2)
    assert done.returncode == 0, done.stderr
    return folder, time.monotonic() - begin


class ProgramTest(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)

    def write(self, name, text):
        path = self.folder / name
        path.write_text(text)
        return path

    def tiny(self, name="scene.toml", **replaced):
        """A copy of the tiny scene with `old: new` text replaced."""
        text = TINY.read_text().replace("../../scenes", str(SOURCE / "scenes"))
        for old, new in replaced.get("changes", {}).items():
            assert old in text, old
            text = text.replace(old, new)
        return self.write(name, text)

    def assert_refused(self, process, pattern, untouched=None):
        """Exit 2, one line on stderr that matches, nothing on stdout, nothing written."""
        self.assertEqual(process.returncode, 2, process.stderr)
        self.assertEqual(process.stderr.count("\n"), 1, process.stderr)
        self.assertRegex(process.stderr, pattern)
        self.assertEqual(process.stdout, "")
        if untouched is not None:
            self.assertFalse(pathlib.Path(untouched).exists(), f"{untouched} was written")

    def assert_same_results(self, one, other):
        a, b = results(one), results(other)
        self.assertEqual(sorted(a), sorted(b))
        for name in a:
            self.assertEqual(a[name], b[name], f"{name} differs")
        self.assertIn("evaluation.json", a)


def load(path):
    return json.loads(pathlib.Path(path).read_text())
