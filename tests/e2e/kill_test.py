"""A command that is killed, as often as it may be, and then done again ends as if it had never been.

Kills fall at times drawn by a fixed seed. FRICID_KILLS says how many per stage; default 3."""
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from fricid_program import PROGRAM, SOURCE, ProgramTest, fricid

sys.path.insert(0, str(SOURCE / "tests" / "attack"))
import samples  # noqa: E402

KILLS = int(os.environ.get("FRICID_KILLS", "3"))
EM = """[[model]]
name = "em"
law = "coulomb_viscous"
method = "em"
starts = 1
[model.em]
iterations = 4
"""
# They tell when something was done, and what it took.
CLOCKS = {"manifest.json", "report.html", ".lock"}


def contents(folder):
    """Bytes of every file by name; of those that carry the time, the name alone."""
    return {str(path.relative_to(folder)):
            b"" if path.name in CLOCKS or path.suffix == ".pdf" else path.read_bytes()
            for path in sorted(folder.rglob("*")) if path.is_file() and path.name != "stderr"}


class Killed(ProgramTest):
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(holder.cleanup)
        cls.good = pathlib.Path(holder.name) / "good"
        samples.make(PROGRAM, cls.good)
        scene = cls.good / "scene.toml"
        scene.write_text(scene.read_text().replace("[evaluate]", EM + "\n[evaluate]", 1))

    def copy(self):
        """One place for all: a run names its files by their whole path."""
        folder = self.folder / "work"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.good, folder, symlinks=True)
        for path in self.without:
            shutil.rmtree(folder / path, ignore_errors=True)
        return folder

    def kill(self, *command, without=()):
        """`without`: folders that the command is to make, taken out of what it finds."""
        self.without = without
        reference = self.copy()
        begin = time.monotonic()
        done = fricid(*command, cwd=reference)
        seconds = time.monotonic() - begin
        self.assertIn(done.returncode, (0, 1), done.stderr)
        expected = contents(reference)

        rng = random.Random(" ".join(command))
        folder = self.copy()
        hit = 0
        for _ in range(KILLS):
            job = subprocess.Popen([PROGRAM, *command], cwd=folder, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            try:
                job.wait(rng.uniform(0, seconds))
                folder = self.copy()  # it was done before
            except subprocess.TimeoutExpired:
                job.send_signal(signal.SIGKILL)
                job.wait()
                hit += 1
        self.assertGreater(hit, 0)
        again = fricid(*command, cwd=folder)
        self.assertEqual(again.returncode, done.returncode, again.stderr)
        found = contents(folder)
        self.assertEqual(sorted(found), sorted(expected))
        for name, content in expected.items():
            self.assertEqual(found[name], content, f"{name} differs")

    def test_simulation(self):
        self.kill("simulate", "scene.toml", "-o", "out")

    def test_fits(self):
        self.kill("identify", "scene.toml", "-o", "run", "--model", "simple", "--model", "em", "--fresh")

    def test_evaluation(self):
        self.kill("evaluate", "run", "--fresh")

    def test_plots(self):
        self.kill("render", "run", "plots", without=["run/plots"])

    def test_films(self):
        self.kill("render", "run", "video", "--quality", "draft", without=["run/video"])

    def test_still(self):
        self.kill("render", "run", "still", "-o", "out/still.png")

    def test_report(self):
        self.kill("render", "run", "report", "--fresh")

    def test_import(self):
        self.kill("import", "log.csv", "--contract", "contract.toml", "-o", "out")

    def test_estimate(self):
        self.kill("estimate", "model.json", "data.h5", "-o", "out/estimate.h5")

    def test_design(self):
        self.kill("check", "log.csv", "--contract", "contract.toml", "--robot", "robot.urdf",
                  "--design", "out/next.toml")


if __name__ == "__main__":
    unittest.main()
