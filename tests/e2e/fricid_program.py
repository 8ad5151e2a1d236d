"""Helpers of the end-to-end tests: run the program, compare run folders."""
import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

PROGRAM = os.environ["FRICID_PROGRAM"]
SOURCE = pathlib.Path(os.environ["FRICID_SOURCE_DIR"])
TINY = SOURCE / "tests" / "e2e" / "tiny.toml"


def fricid(*arguments, environment={}, **options):
    """Runs the program; returns the finished process with text output."""
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, env=os.environ | environment, **options)


def without_seconds(text):
    """Wall-clock times are the one thing that differs between two runs of the same job."""
    return re.sub(r'"(\w*seconds)": *[-+.\deE]+', r'"\1": 0', text)


def results(folder):
    """Content of every result file: bytes, for JSON and tables without the wall-clock times."""
    found = {}
    for path in sorted(pathlib.Path(folder).rglob("*")):
        name = str(path.relative_to(folder))
        if not path.is_file() or name in ("manifest.json", ".lock", "report.html"):
            continue
        if name.startswith("plots/"):
            continue
        if path.suffix == ".json":
            found[name] = without_seconds(path.read_text())
        elif name in ("table.md", "table.csv"):
            continue  # columns of evaluation.json, seconds among them
        else:
            found[name] = path.read_bytes()
    return found


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
