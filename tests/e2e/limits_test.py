"""What asks for too much, or for what cannot be, is refused in one line before any work; what cannot
be printed is said."""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from fricid_program import PROGRAM, SOURCE, ProgramTest, fricid

sys.path.insert(0, str(SOURCE / "tests" / "attack"))
import manifest  # noqa: E402
import samples  # noqa: E402


HOLDER = tempfile.TemporaryDirectory()
GOOD = pathlib.Path(HOLDER.name) / "good"


def setUpModule():
    unittest.addModuleCleanup(HOLDER.cleanup)
    samples.make(PROGRAM, GOOD)


class Limits(ProgramTest):
    """Commands over a folder of small good files."""

    def setUp(self):
        super().setUp()
        subprocess.run(["cp", "-a", f"{GOOD}/.", self.folder], check=True)

    def fricid(self, *arguments, **options):
        return fricid(*arguments, cwd=self.folder, **options)

    def scene(self, changes, name="scene.toml"):
        text = (self.folder / name).read_text()
        for old, new in changes.items():
            self.assertIn(old, text)
            text = text.replace(old, new, 1)
        self.write(name, text)

    def refuse(self, command, pattern):
        self.assert_refused(self.fricid(*command), pattern, self.folder / "out")


class Options(Limits):
    def test_seeds_of_data_and_filters(self):
        for seed in ("-1", "9223372036854775808", "10000000000000000", "1e3", " 1", "0x1", "01"):
            for command in (["run", "scene.toml", "-o", "out"], ["simulate", "scene.toml", "-o", "out"],
                            ["estimate", "model.json", "data.h5"]):
                with self.subTest(seed=seed, command=command[0]):
                    self.refuse([*command, f"--seed={seed}"],
                                "--seed.*allowed: a whole number from 0 to 9000000000000000")

    def test_seeds_of_fits(self):
        for seeds in ("99999999999", "2147483647", "1,", "1-2147483647", "-1", "2-1"):
            with self.subTest(seeds=seeds):
                self.refuse(["identify", "scene.toml", "-o", "out", f"--seeds={seeds}"],
                            '--seeds ".*": allowed: up to 1000 numbers')

    def test_a_filter_that_takes_too_much_memory(self):
        # The least address space in which the program starts leaves too little for a million particles.
        for kilobytes in range(50_000, 2_000_000, 50_000):
            done = subprocess.run(
                ["bash", "-c", f"ulimit -v {kilobytes}; " 'exec "$0" estimate model.json data.h5 '
                 "--particles 1000000 --quiet", PROGRAM], cwd=self.folder, capture_output=True, text=True)
            if "AddressSanitizer" in done.stderr:
                self.skipTest("the sanitizer takes address space of its own")
            if done.stderr.startswith("fricid: "):
                break
        self.assert_refused(done, "the filter of 1000000 particles would take .* GB of memory; "
                                  "allowed: .* GB, half of what is free")


class Scenes(Limits):
    def test_recordings_beyond_the_memory(self):
        self.scene({"train = 1": "train = 1000", "repeats = 1": "repeats = 100",
                    "rate_hz = 100.0": "rate_hz = 10000.0", "step_s = 0.001": "step_s = 0.0001",
                    "base_rad_s = 1.5": "base_rad_s = 0.01"})
        self.refuse(["run", "scene.toml", "-o", "out"],
                    "simulating 100001 recordings of 6283185 samples would take .* GB of memory; "
                    "allowed: .* GB, half of what is free")

    def test_fits_beyond_the_memory(self):
        for changes in ({'method = "conventional"': 'method = "em"', "batch = 2048": "batch = 10000000",
                         "particles = 200": "particles = 1000000", "paths = 4": "paths = 1000",
                         "rate_hz = 100.0": "rate_hz = 1000.0", "base_rad_s = 1.5": "base_rad_s = 0.1"},
                        {'law = "coulomb_viscous"': 'law = "lvm_bristles"', 'method = "conventional"':
                         'method = "multi_step"', "batch = 32": "batch = 1000000",
                         "[model.train]": "[model.train]\n"}):
            with self.subTest(changes=changes):
                self.setUp()
                if "batch = 32" in changes:  # of the windows, behind those of the torque
                    text = (self.folder / "scene.toml").read_text()
                    at = text.index("[model.train]")
                    self.write("scene.toml", text[:at] + text[at:].replace("batch = 32", "batch = 1000000", 1))
                    changes = {k: v for k, v in changes.items() if "batch" not in k and "train" not in k}
                self.scene(changes)
                self.refuse(["run", "scene.toml", "-o", "out"],
                            "the fit of model simple would take .* GB of memory")

    def test_nothing_to_fit_or_to_judge_by(self):
        text = (self.folder / "scene.toml").read_text()
        begin, end = text.index("[[model]]"), text.index("[evaluate]")
        self.write("none.toml", text[:begin] + text[end:])
        for command in ("run", "identify"):
            self.refuse([command, "none.toml", "-o", "out"], r"no \[\[model\]\]")
        self.scene({"validation = 1": "validation = 0"})
        self.refuse(["run", "scene.toml", "-o", "out"], "excitation.validation = 0; allowed: 1 or more")

    def test_an_arm_at_rest(self):
        self.scene({"half_range = []": "half_range = 0.0"})
        done = self.fricid("run", "scene.toml", "-o", "out", "--quiet")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("allowed: training data in which the arm moves", done.stderr)

    def test_fewer_usable_rows_than_parameters(self):
        for changes in ({"base_rad_s = 1.5": "base_rad_s = 2.5"},
                        {"min_speed_rad_s = 0.02": "min_speed_rad_s = 4.0"},
                        {"base_rad_s = 1.5": "base_rad_s = 6.0", "rate_hz = 100.0": "rate_hz = 30.0",
                         "step_s = 0.001": "step_s = 0.0033333333333333335", "cutoff_hz = 10": "cutoff_hz = 8"}):
            with self.subTest(changes=changes):
                self.setUp()
                self.scene(changes)
                done = self.fricid("run", "scene.toml", "-o", "out", "--quiet", "--no-video")
                self.assertIn(done.returncode, (0, 1, 2), done.stderr)
                if done.returncode == 1:
                    self.assertIn("not to be trusted", done.stderr)

    def test_a_log_at_rest(self):
        rows = [line.split(",") for line in (self.folder / "log.csv").read_text().split()]
        for column in [i for i, name in enumerate(rows[0]) if name in ("q1", "q2")]:
            for row in rows[1:]:
                row[column] = "0.5"
        self.write("log.csv", "\n".join(map(",".join, rows)) + "\n")
        done = self.fricid("run", "logs.toml", "-o", "out", "--quiet", "--no-video")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("allowed: training data in which the arm moves", done.stderr)
        done = self.fricid("check", "log.csv", "--contract", "contract.toml", "--robot", "robot.urdf")
        self.assertIn(done.returncode, (0, 1), done.stderr)

    def test_a_scene_without_noise(self):
        self.scene({"torque_noise = 0.001": "torque_noise = 0.0",
                    "torque_step = 0.0005": "torque_step = 0.0"})
        done = self.fricid("run", "scene.toml", "-o", "out", "--quiet")
        self.assertIn(done.returncode, (0, 1), done.stderr)


class Files(Limits):
    def test_a_gap_of_a_hundred_million_samples(self):
        lines = (self.folder / "log.csv").read_text().splitlines()
        column = lines[0].split(",").index("t")
        for i in range(100, len(lines)):
            cells = lines[i].split(",")
            cells[column] = repr(float(cells[column]) + 1e6)
            lines[i] = ",".join(cells)
        self.write("log.csv", "\n".join(lines) + "\n")
        self.refuse(["import", "log.csv", "--contract", "contract.toml", "--fix", "gap", "-o", "out"],
                    r"log \(import log\.csv\): 1000\d+ samples of a log after its gaps are filled; allowed: up to 50000000")

    def test_files_that_never_end_or_lead_nowhere(self):
        for name, target in (("loop.toml", "loop.toml"), ("loop.json", "loop.json"),
                             ("zero.toml", "/dev/zero"), ("zero.json", "/dev/zero"),
                             ("zero.h5", "/dev/zero"), ("loop.h5", "loop.h5")):
            (self.folder / name).symlink_to(target)
            with self.subTest(name=name):
                self.refuse(["info", name], name)

    def test_a_model_of_the_whole_robot_is_shown(self):
        text = (self.folder / "scene.toml").read_text()
        begin, end = text.index("[[model]]"), text.index("[evaluate]")
        self.write("scene.toml", text[:begin] + '''[[model]]
name = "nn"
elements = 2
method = "torque"
starts = 1
[model.torque]
iterations = 20

''' + text[end:])
        done = self.fricid("identify", "scene.toml", "-o", "out", "--quiet")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        shown = self.fricid("info", "out/models/nn_s1.json")
        self.assertEqual(shown.returncode, 0, shown.stderr)
        self.assertIn("whole robot", shown.stdout)

    def test_json_nested_deeply(self):
        self.write("deep.json", "[" * 100_000 + "]" * 100_000)
        self.refuse(["info", "deep.json"], "deep.json: 33 levels")
        self.write("large.json", '{"a": 1e400}')
        self.refuse(["info", "large.json"], "large.json: not JSON: number overflow")


class Runs(Limits):
    """Run folders from others: what the manifest vouches for may still be anything."""

    def forge(self, name, change):
        file = self.folder / "run" / name
        before = file.read_bytes()
        after = change(before)
        self.assertNotEqual(before, after)
        file.write_bytes(after)
        manifest.vouch_for(self.folder / "run", name)

    def test_a_model_of_another_name(self):
        for old, new in ((b'"name": "simple"', b'"name": "other"'), (b'"seed": 1', b'"seed": 2'),
                         (b'"is_oracle": false', b'"is_oracle": true')):
            with self.subTest(new=new):
                self.setUp()
                self.forge("models/simple_s1.json", lambda data: data.replace(old, new, 1))
                done = self.fricid("evaluate", "run", "--quiet", "--fresh")
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertRegex(done.stderr, r"models/simple_s1\.json: found the model .*; allowed: simple, seed 1")

    def test_a_model_of_another_robot(self):
        self.forge("models/simple_s1.json", lambda data: data.replace(b'"shoulder"', b'"other"'))
        done = self.fricid("evaluate", "run", "--quiet", "--fresh")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertRegex(done.stderr, r"models/simple_s1\.json: found the joints other, elbow; allowed")

    def test_a_manifest_that_leaves_a_file_out(self):
        manifest_file = self.folder / "run" / "manifest.json"
        text = json.loads(manifest_file.read_text())
        for stage in text["stages"]:
            stage["outputs"] = [o for o in stage["outputs"] if o["name"] != "fit/simple_s1.json"]
        for sealed in False, True:
            manifest_file.write_text(json.dumps(text))
            if sealed:
                manifest.vouch_for(self.folder / "run")
            done = self.fricid("evaluate", "run", "--quiet")
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("run", done.stderr)

    def test_what_is_printed_shows(self):
        self.forge("table.md", lambda data: data + b"\x1b]0;title\x07\x1b[31m \xe2\x80\xae\n")
        done = self.fricid("evaluate", "run")
        self.assertIn("evaluate: up to date", done.stderr)
        self.assertIn("\\x1b]0;title\\x07\\x1b[31m \\u{202e}\n", done.stdout)
        self.forge("evaluation.json", lambda data: data.replace(b'"label": "simple"', b'"label": "simple\xc2\x9b"', 1))
        done = self.fricid("evaluate", "run", "--json")
        self.assertNotIn("\x9b", done.stdout + done.stderr)

    def test_files_of_another_robot(self):
        """Of the right kind and the wrong shape."""
        for name in ("models/simple_s1.json", "fit/simple_s1.json", "evaluation.json",
                     "data/train_0.h5", "data/validation_0.h5", "truth/validation_0.h5", "excitation.json",
                     "rollouts/simple_s1_validation_0.h5", "predictions/simple_s1_validation_0.h5"):
            other = (self.folder / "other" / name).read_bytes()
            for command in (["evaluate", "run"], ["identify", "run"], ["render", "run", "plots", "report"],
                            ["check", "run"]):
                with self.subTest(name=name, command=command[0]):
                    self.setUp()
                    self.forge(name, lambda _: other)
                    done = self.fricid(*command, "--quiet")
                    self.assertIn(done.returncode, (0, 1, 2), done.stderr)
                    self.assertNotIn("unexpected", done.stderr)
                    if name.startswith("truth/") and command[0] == "evaluate":
                        self.assertEqual(done.returncode, 2, done.stderr)
                        self.assertIn(f"{name}: found joints", done.stderr)


class Printing(Limits):
    COMMANDS = (["info", "scene.toml"], ["info", "data.h5"], ["info", "data.h5", "--csv"],
                ["info", "model.json"], ["info", "model.json", "--json"], ["template", "scene"],
                ["--version"], ["--help"], ["simulate", "scene.toml", "-o", "out"],
                ["evaluate", "run"], ["evaluate", "run", "--json"], ["compare", "run"],
                ["check", "data.h5"], ["check", "run"], ["estimate", "model.json", "data.h5"],
                ["import", "log.csv", "--contract", "contract.toml", "-o", "out"], [])

    def test_a_full_disk_a_reader_that_left_and_no_stdout(self):
        for redirection in ("> /dev/full", "| true", ">&-"):
            for command in self.COMMANDS:
                with self.subTest(redirection=redirection, command=command):
                    done = subprocess.run(
                        ["bash", "-c", f'set -o pipefail; {{ sleep 0.3; "$0" "$@"; }} {redirection}',
                         PROGRAM, *command], cwd=self.folder, text=True, stdin=subprocess.DEVNULL,
                        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
                    self.assertEqual(done.returncode, 3, done.stderr)
                    self.assertIn("fricid: stdout: cannot be written", done.stderr)

    def test_files_are_whole_without_standard_streams(self):
        done = subprocess.run(["bash", "-c", '"$0" simulate scene.toml -o out >&- 2>&- <&-', PROGRAM],
                              cwd=self.folder)
        self.assertEqual(done.returncode, 3)
        self.assertEqual(self.fricid("info", "out/data/train_0.h5").returncode, 0)


class Hanging(Limits):
    def test_a_program_that_hangs_does_not_keep_us(self):
        tools = self.folder / "tools"
        tools.mkdir()
        tool = tools / "gnuplot"
        tool.write_text("#!/bin/sh\ntrap '' TERM\ntouch started\nsleep 20\n")
        tool.chmod(0o755)
        subprocess.run(["rm", "-r", "run/plots"], cwd=self.folder, check=True)
        process = subprocess.Popen([PROGRAM, "render", "run", "plots"], cwd=self.folder,
                                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL,
                                   env=os.environ | {"PATH": f"{tools}:{os.environ['PATH']}"})
        while not list(self.folder.rglob("started")):
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(15), 130)
        self.assertEqual([p.name for p in (self.folder / "run").rglob(".*.tmp")], [])

    def test_a_pipe_that_nobody_writes_does_not_keep_us(self):
        os.mkfifo(self.folder / "pipe.toml")
        process = subprocess.Popen([PROGRAM, "info", "pipe.toml"], cwd=self.folder,
                                   stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        time.sleep(0.5)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(15), 130)

    def test_a_limit_on_the_size_of_files(self):
        done = subprocess.run(["bash", "-c", 'ulimit -f 8; exec "$0" simulate scene.toml -o out --quiet', PROGRAM],
                              cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertRegex(done.stderr, r"out/.*\.h5: .*File too large")
        self.assertEqual([p.name for p in self.folder.rglob(".*.tmp")], [])

    def test_plots_that_are_a_file(self):
        subprocess.run(["rm", "-r", "run/plots"], cwd=self.folder, check=True)
        self.write("run/plots", "")
        done = self.fricid("render", "run", "plots")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertRegex(done.stderr, "run/plots")


if __name__ == "__main__":
    unittest.main()
