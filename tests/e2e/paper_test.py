"""scripts/paper.py prints one rollout per model beside the paper's numbers."""
import subprocess
import sys
import unittest

from fricid_program import SOURCE, TINY, ProgramTest, fricid, load

HEAD = "model,label,seed,is_oracle,trajectory,start_s,horizon_s,diverged,q_mse,q_mae,v_mse,v_mae\n"


class Paper(ProgramTest):
    def table(self, rows):
        self.write("table.csv", HEAD + "".join(f"{','.join(map(str, row))}\n" for row in rows))
        done = subprocess.run([sys.executable, SOURCE / "scripts/paper.py", self.folder],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return {line.split(" | ")[0].strip("| "): [cell.strip(" |") for cell in line.split(" | ")[1:]]
                for line in done.stdout.splitlines()[2:]}

    def test_one_rollout_from_the_first_sample(self):
        def row(model, seed, start, horizon, diverged, mse, mae, trajectory="validation_0"):
            return model, model, seed, 0, trajectory, start, horizon, diverged, mse, mae, 0, 0
        found = self.table([
            row("simple", 1, 0, 10, 1, 0.5, 0.25), row("simple", 1, 0, 31.4, 1, 7, 3),
            row("lugre", 1, 0, 1, 0, 9, 9), row("lugre", 1, 0, 10, 0, 0.01, 0.02),
            row("lugre", 1, 5.3, 10, 0, 9, 9),
            row("lugre", 1, 0, 10, 0, 9, 9, "validation_1"), row("lugre", 1, 0, 31.4, 0, 0.03, 0.04),
            row("lugre", 2, 0, 10, 0, 9, 9),
            row("other", 1, 0, 10, 0, 9, 9)])
        self.assertEqual(found["simple"], ["0.5", "0.25", "-", "-", "2", "0.96", "-", "-"])
        self.assertEqual(found["lugre"], ["0.01", "0.02", "0.03", "0.04", "0.027", "0.12", "0.66", "0.42"])
        self.assertNotIn("other", found)

    def test_reads_a_run_of_the_program(self):
        run = self.folder / "run"
        done = fricid("run", TINY, "-o", run)
        self.assertEqual(done.returncode, 0, done.stderr)
        table = subprocess.run([sys.executable, SOURCE / "scripts/paper.py", run], capture_output=True, text=True)
        self.assertEqual(table.returncode, 0, table.stderr)
        models = [m["name"] for m in load(run / "evaluation.json")["models"]]
        for name in ("oracle", "simple", "lugre"):
            self.assertIn(name, models)
            self.assertRegex(table.stdout, rf"(?m)^\| {name} \|")

    def test_a_folder_that_is_no_run(self):
        done = subprocess.run([sys.executable, SOURCE / "scripts/paper.py", self.folder / "none"],
                              capture_output=True, text=True)
        self.assertNotEqual(done.returncode, 0)
        self.assertRegex(done.stderr, r"^\S*none/table\.csv: not found; allowed: .*\n$")


if __name__ == "__main__":
    unittest.main()
