"""Two cells of the benchmark side by side, and the table that joins them; the table of the real arms."""
import json
import os
import re
import subprocess
import unittest
from pathlib import Path

from fricid_program import ProgramTest, fricid, load

SOURCE = Path(os.environ["FRICID_SOURCE_DIR"])


TOOLS = Path(os.environ["FRICID_BINARY_DIR"]) / "benchmark-tools"

# Residuals of a made-up run: one joint, 20 s. `twice` errs twice as much as `good` at any time; in the second half `late` errs
# less than `good` and more in the first. `copy` is `good`.
MAKE_RUN = """
import csv, pathlib, sys
import h5py, numpy as np
run = pathlib.Path(sys.argv[1])
(run / "predictions").mkdir(parents=True)
rng = np.random.default_rng(1)
t = np.arange(2000) / 100
e = rng.normal(size=(2000, 1))
ramp = np.where(t < 10, 1.5, 0.6)[:, None]
for name, residual in (("simple", 2 * e), ("good", e), ("copy", e), ("late", ramp * e)):
    with h5py.File(run / f"predictions/{name}_s1_validation_0.h5", "w") as file:
        tau = np.sin(t)[:, None]
        tau[5] = np.nan
        file["t"], file["tau"], file["tau_predicted"] = t, tau, tau - residual
        file.attrs["joint_names"] = ["elbow"]
with open(run / "table.csv", "w") as file:
    write = csv.writer(file)
    write.writerow("model,seed,trajectory,start_s,horizon_s,q_mse".split(","))
    for name, factor in (("simple", 2), ("good", 1), ("copy", 1), ("late", 1)):
        for start in range(8):
            spread = 10 ** rng.normal() if name == "late" else 1
            write.writerow([name, 1, "validation_0", start, 0.1, factor * spread * (1 + start) * 1e-6])
"""


class RealArms(ProgramTest):
    def test_bold_is_what_is_beyond_the_interval(self):
        subprocess.run([SOURCE / "scripts/venv.sh", TOOLS, SOURCE / "scenes/benchmark/requirements.txt"], check=True)
        run = self.folder / "out/arm"
        subprocess.run([TOOLS / "bin/python", "-c", MAKE_RUN, run], check=True)

        def rows(*names):
            summary = [{"name": name, "doubts": ["falls"] if name == "late" else []} for name in names]
            (run / "evaluation.json").write_text(json.dumps({"summary": summary, "horizons_s": [0.1, 0]}))
            (run / "manifest.json").write_text(json.dumps({"commit": "abc", "machine": {"cpu": "a CPU"}}))
            done = subprocess.run([TOOLS / "bin/python", SOURCE / "scenes/real_logs/join.py", self.folder / "out", "arm"],
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("over 20 s", done.stdout)
            self.assertIn("Commit abc, a CPU", done.stdout)
            return {cells[1].strip(): cells[2].strip() for line in done.stdout.splitlines() if len(cells := line.split("|")) > 4}

        found = rows("simple", "good", "copy")
        self.assertRegex(found["good"], r"^\*\*(0\.9|1|1\.0)\d*\*\* ± 0\.0\d")  # 1 / sqrt(2 x 2000) at 90 %: 0.026
        self.assertEqual(found["copy"], found["good"])
        self.assertRegex(found["simple"], r"^(1\.9|2|2\.0)\d* ±")
        found = rows("simple", "good", "late")
        self.assertNotIn("*", found["good"])
        self.assertNotIn("*", found["late (not to be trusted)"])


class Benchmark(ProgramTest):
    def test_cells_run_resume_and_join(self):
        scene = self.tiny()
        out = self.folder / "cells"

        def snakemake():
            return subprocess.run(
                [SOURCE / "scripts/benchmark.sh", "--cores", "2", "--directory", self.folder,
                 "--config", f"truths={scene.stem}", "seeds=1-2", f"scenes={scene.parent}",
                 f"out={out}", "against=lugre"],
                capture_output=True, text=True,
                env={**os.environ, "XDG_CACHE_HOME": str(self.folder / "cache"),
                     "FRICID_BENCHMARK_TOOLS": str(TOOLS)})

        done = snakemake()
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        table = (out / "table.md").read_text()
        self.assertIn("2 runs", table)
        self.assertIn("against lugre", table)
        cells = [load(out / f"{scene.stem}_{seed}" / "evaluation.json") for seed in (1, 2)]
        self.assertNotEqual(cells[0]["summary"][-1], cells[1]["summary"][-1])
        joined = fricid("compare", *(out / f"{scene.stem}_{seed}" for seed in (1, 2)),
                        "--against", "lugre")
        self.assertEqual(joined.stdout, table)

        again = snakemake()
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertTrue(re.search("Nothing to be done", again.stdout + again.stderr))

        # a cell that is gone is made again for a new table, alone
        (out / "table.md").unlink()
        (out / f"{scene.stem}_1" / "evaluation.json").unlink()
        other = (out / f"{scene.stem}_2" / "evaluation.json").stat().st_mtime_ns
        self.assertEqual(snakemake().returncode, 0)
        self.assertEqual((out / f"{scene.stem}_2" / "evaluation.json").stat().st_mtime_ns, other)
        self.assertEqual(load(out / f"{scene.stem}_1" / "evaluation.json")["summary"],
                         cells[0]["summary"])


if __name__ == "__main__":
    unittest.main()
