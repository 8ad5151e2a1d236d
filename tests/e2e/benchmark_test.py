"""Two cells of the benchmark side by side, and the table that joins them."""
import os
import re
import subprocess
import unittest
from pathlib import Path

from fricid_program import ProgramTest, fricid, load

SOURCE = Path(os.environ["FRICID_SOURCE_DIR"])


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
                     "FRICID_BENCHMARK_TOOLS":
                         str(Path(os.environ["FRICID_BINARY_DIR"]) / "benchmark-tools")})

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
