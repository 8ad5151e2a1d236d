"""Rollouts of another program join the evaluation as those of any model."""
import json
import pathlib
import shutil
import tempfile
import unittest

from fricid_program import SOURCE, TINY, ProgramTest, fricid, load


class External(ProgramTest):
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(holder.cleanup)
        cls.done = pathlib.Path(holder.name) / "run"
        # over the full length there are only rollouts from the first sample, which a run folder keeps
        scene = cls.done.with_name("scene.toml")
        scene.write_text(TINY.read_text().replace("../../scenes", str(SOURCE / "scenes"))
                         .replace("horizons_s = [0.1, 1, 0]", "horizons_s = [0]"))
        done = fricid("run", scene, "-o", cls.done)
        assert done.returncode == 0, done.stderr
        lugre = fricid("info", cls.done / "rollouts/lugre_s1_validation_0.h5", "--csv")
        cls.rollout = lugre.stdout.splitlines(keepends=True)

    def setUp(self):
        super().setUp()
        self.run_folder = shutil.copytree(self.done, self.folder / "run")
        self.before = (self.run_folder / "evaluation.json").read_text()
        self.mine = self.run_folder / "external" / "my_tool"
        self.mine.mkdir(parents=True)
        self.describe()

    def describe(self, label="my tool 1.0", seconds=1.5):
        (self.mine / "model.json").write_text(
            f'{{"format": "fricid.external/1", "label": "{label}",\n'
            f' "parameters": 7, "fit_seconds": {seconds}}}\n')

    def write_rollout(self, lines):
        (self.mine / "validation_0_0.csv").write_text("".join(lines))

    def refuse(self, pattern):
        self.assert_refused(fricid("evaluate", self.run_folder), pattern)
        self.assertEqual((self.run_folder / "evaluation.json").read_text(), self.before)

    def test_a_models_own_rollouts_give_its_very_figures(self):
        self.write_rollout(self.rollout)
        done = fricid("evaluate", self.run_folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"\| my tool 1\.0 .*\| +7 \|")
        rows = {row["name"]: row for row in load(self.run_folder / "evaluation.json")["summary"]}
        lugre, mine = rows["lugre"], rows["my_tool"]
        for key in ("seeds", "q_mse_geometric_mean", "q_mse_median", "q_mse_mean", "v_mse_geometric_mean",
                    "interval_90", "interval_over", "ratio_to_oracle", "headroom_closed", "diverged",
                    "rollouts", "friction_rollout"):
            self.assertEqual(mine[key], lugre[key], key)
        self.assertIsNone(mine["friction"])
        self.assertEqual(mine["stated_fit_seconds"], 1.5)
        self.assertEqual([rows[name] for name in rows if name != "my_tool"],
                         json.loads(self.before)["summary"])

        again = fricid("evaluate", self.run_folder)
        self.assertIn("up to date", again.stderr)
        drawn = fricid("render", self.run_folder, "plots", "report")
        self.assertEqual(drawn.returncode, 0, drawn.stderr)
        self.assertIn("my tool 1.0", (self.run_folder / "report.html").read_text())
        self.assertIn("my tool 1.0", (self.run_folder / "plots/tracking.gp").read_text())

    def test_without_its_folder_the_row_is_gone(self):
        self.write_rollout(self.rollout)
        self.assertEqual(fricid("evaluate", self.run_folder).returncode, 0)
        self.mine.rename(self.folder / "put_away")
        self.assertEqual(fricid("evaluate", self.run_folder).returncode, 0)
        self.assertEqual((self.run_folder / "evaluation.json").read_text(), self.before)

    def test_diverged_rollout_is_counted(self):
        columns = self.rollout[0].count(",")
        time = self.rollout[0].strip().split(",").index("t")
        broken = []
        for line in self.rollout[900:]:
            cells = ["nan"] * (columns + 1)
            cells[time] = line.strip().split(",")[time]
            broken.append(",".join(cells) + "\n")
        self.write_rollout(self.rollout[:900] + broken)
        done = fricid("evaluate", self.run_folder)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        self.assertRegex(done.stdout, r"\| my tool 1\.0 .*\| +1/1 \|")

    def test_truncated_rollout(self):
        self.write_rollout(self.rollout[:500])
        self.refuse(r"my_tool/validation_0_0\.csv:500: 499 rows; allowed: \d+, as starts\.csv says")

    def test_torn_line(self):
        self.write_rollout(self.rollout[:499] + [self.rollout[499][:40]])
        self.refuse(r"validation_0_0\.csv:500: \d+ cells; allowed: 19")

    def test_wrong_start(self):
        self.write_rollout([self.rollout[0], *self.rollout[2:], self.rollout[-1]])
        self.refuse(r"validation_0_0\.csv:2: t = 0\.004 s; allowed: 0, as in validation_0")

    def test_missing_rollout(self):
        self.refuse(r"validation_0_0\.csv: no such file.*allowed: one rollout per line of starts\.csv")

    def test_bad_description(self):
        self.write_rollout(self.rollout)
        self.describe(seconds=-1)
        self.refuse(r"my_tool/model\.json:2: fit_seconds = -1; allowed: 0 or more")

    def test_name_that_is_taken(self):
        self.mine.rename(self.mine.with_name("lugre"))
        self.refuse(r"external/lugre: a model of this run has this name")

    def test_stray_file(self):
        (self.run_folder / "external" / "rollout.csv").write_text("t\n")
        self.refuse(r"external/rollout\.csv: a file; allowed: one folder per model")


if __name__ == "__main__":
    unittest.main()
