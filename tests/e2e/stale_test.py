"""Results whose inputs changed are made again, or left out and named."""
import shutil
import unittest

from fricid_program import NO_PLOTS, SOURCE, TINY, ProgramTest, fricid, load

KR6 = SOURCE / "models" / "kr6_r700"
SECOND_MODEL = '[[model]]\nname = "lugre"\nstarts = 1\n'


class Stale(ProgramTest):
    def run_scene(self, scene, environment=NO_PLOTS):
        done = fricid("run", scene, "-o", self.folder / "run", environment=environment)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        return done.stderr

    def names(self):
        return {model["name"] for model in load(self.folder / "run" / "evaluation.json")["models"]}

    def own_robot(self):
        """A scene whose URDF and MJCF are copies beside it."""
        shutil.copytree(KR6, self.folder / "kr6")
        base = (SOURCE / "scenes" / "kr6_base.toml").read_text().replace("models/kr6_r700", "kr6")
        self.write("kr6_base.toml", base)
        text = TINY.read_text().replace("../../scenes/", "").replace(SECOND_MODEL, "")
        return self.write("scene.toml", text)

    def test_a_second_run_does_nothing(self):
        scene = self.own_robot()
        self.run_scene(scene, {})
        again = self.run_scene(scene, {})
        for stage in ("data", "identify simple_s1", "evaluate", "plots", "report"):
            self.assertIn(f"{stage}: up to date", again)

    def test_a_model_that_left_the_scene_leaves_the_table(self):
        with_both = self.tiny()
        self.run_scene(with_both, {})
        self.assertIn("lugre", self.names())
        said = self.run_scene(self.tiny(changes={SECOND_MODEL: ""}), {})
        self.assertIn("lugre_s1: left out", said)
        self.assertNotIn("lugre", self.names())
        for kind in ("rollouts", "bands", "plots"):
            self.assertEqual(list((self.folder / "run" / kind).glob("*lugre*")), [], kind)

    def test_a_model_of_another_scene_with_its_name_is_left_out(self):
        self.run_scene(self.tiny())
        scene = (self.folder / "run" / "scene.toml")
        text = scene.read_text()
        self.assertIn("cutoff_hz = ", text)
        scene.write_text(text.replace("cutoff_hz = 10", "cutoff_hz = 9"))
        done = fricid("evaluate", self.folder / "run")
        self.assert_refused_after_notes(done, r"found no models")

    def assert_refused_after_notes(self, done, pattern):
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertRegex(done.stderr.splitlines()[-1], pattern)

    def test_fits_asked_for_by_name_stay(self):
        self.run_scene(self.tiny(changes={SECOND_MODEL: ""}))
        run = self.folder / "run"
        self.assertEqual(fricid("identify", run, "--model", "dahl", "--seeds", "2").returncode, 0)
        self.assertIn(fricid("evaluate", run).returncode, (0, 1))
        self.assertEqual(self.names(), {"oracle", "simulator", "simple", "dahl"})

    def test_results_of_former_data_are_not_handed_on(self):
        self.run_scene(self.tiny())
        run = self.folder / "run"
        other = self.tiny(changes={"seed = 3": "seed = 4"})
        self.assertIn(fricid("identify", other, "-o", run, "--model", "simple").returncode, (0, 1))
        done = fricid("export", run, "c", "-o", self.folder / "out")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, r"models/lugre_s1\.json: left out: made from another data/train_0\.h5")
        self.assertEqual({file.name.split("_")[0] for file in (self.folder / "out").iterdir()}, {"simple"})
        done = fricid("export", run / "models" / "lugre_s1.json", "c", "-o", self.folder / "one")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("made from another data/train_0.h5", done.stderr)
        self.assert_refused(fricid("compare", run), r"evaluation\.json: made from another .*; `fricid evaluate")
        self.assert_refused(fricid("render", run, "report"), r"evaluate was done with another .*; `fricid evaluate")
        self.assertIn(fricid("evaluate", run).returncode, (0, 1))
        self.assertIn(fricid("compare", run).returncode, (0, 1))
        self.assertEqual(fricid("render", run, "report").returncode, 0)

    def test_a_model_edited_by_hand_is_left_out(self):
        self.run_scene(self.tiny())
        model = self.folder / "run" / "models" / "lugre_s1.json"
        model.write_text(model.read_text() + "\n")
        done = fricid("export", self.folder / "run", "c", "-o", self.folder / "out")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, r"left out: changed since the stage identify lugre_s1 wrote it")

    def test_recordings_beyond_the_new_number_go(self):
        self.run_scene(self.tiny(changes={"train = 1": "train = 2", SECOND_MODEL: ""}))
        self.assertTrue((self.folder / "run" / "data" / "train_1.h5").exists())
        self.run_scene(self.tiny(changes={SECOND_MODEL: ""}))
        self.assertFalse((self.folder / "run" / "data" / "train_1.h5").exists())
        self.assertFalse((self.folder / "run" / "truth" / "train_1.h5").exists())

    def test_an_edited_urdf_is_fitted_again_and_old_data_are_refused(self):
        scene = self.own_robot()
        self.run_scene(scene)
        urdf = self.folder / "kr6" / "kr6_r700.urdf"
        urdf.write_text(urdf.read_text() + "<!-- -->\n")
        self.assert_refused(fricid("evaluate", self.folder / "run"), r"data are damaged, or made from another scene")
        again = self.run_scene(scene)
        for stage in ("data", "identify simple_s1", "evaluate"):
            self.assertNotIn(f"{stage}: up to date", again)

    def test_a_file_that_the_mjcf_includes_counts(self):
        scene = self.own_robot()
        self.run_scene(scene)
        body = self.folder / "kr6" / "kr6_r700_body.xml"
        text = body.read_text()
        self.assertIn('range="', text)
        body.write_text(text.replace('range="-', 'range="-0', 1))
        self.assertIn("data: up to date", self.run_scene(scene))  # the same model in other letters
        first = text.index('range="-') + len('range="-')
        body.write_text(text[:first] + "1" + text[first + 1:])
        if text[first] == "1":
            body.write_text(text[:first] + "2" + text[first + 1:])
        self.assertNotIn("data: up to date", self.run_scene(scene))

    def test_plots_and_films_before_the_evaluation_are_refused(self):
        run = self.folder / "run"
        self.assertEqual(fricid("simulate", TINY, "-o", run).returncode, 0)
        for what in ("plots", "video"):
            self.assert_refused(fricid("render", run, what), r"evaluate was not done; run `fricid run")

    def test_damaged_data_are_refused_and_made_again(self):
        scene = self.tiny(changes={SECOND_MODEL: ""})
        self.run_scene(scene)
        data = self.folder / "run" / "data" / "validation_0.h5"
        whole = data.read_bytes()
        data.write_bytes(whole[:-200])
        self.assert_refused(fricid("evaluate", self.folder / "run"), r"data are damaged, or made from another scene")
        self.run_scene(scene)
        self.assertEqual(data.read_bytes(), whole)


class OfLogs(ProgramTest):
    def test_an_edited_contract_imports_again(self):
        self.assertEqual(fricid("simulate", TINY, "-o", self.folder / "truth").returncode, 0)
        data = self.folder / "truth" / "data"
        for name in ("train_0", "validation_0"):
            csv = fricid("info", "--csv", data / f"{name}.h5").stdout
            self.write(f"{name}.csv", csv)
        self.write("contract.toml", CONTRACT)
        scene = self.write("scene.toml", LOG_SCENE)
        run = self.folder / "run"
        first = fricid("run", scene, "-o", run)
        self.assertIn(first.returncode, (0, 1), first.stderr)
        before = (run / "data" / "train_0.h5").read_bytes()
        self.write("contract.toml", CONTRACT + "sign = [-1, 1, 1, 1, 1, 1]\n")
        second = fricid("run", scene, "-o", run)
        self.assertNotIn("data: up to date", second.stderr)
        self.assertNotEqual((run / "data" / "train_0.h5").read_bytes(), before)


CONTRACT = """joint_names = ["joint_a1", "joint_a2", "joint_a3", "joint_a4", "joint_a5", "joint_a6"]
[position]
columns = ["q{}"]
[torque]
columns = ["tau{}"]
"""
LOG_SCENE = """name = "logs"
[robot]
urdf = "models/kr6_r700/kr6_r700.urdf"
mount = "ceiling"
[data]
contract = "contract.toml"
train = ["train_0.csv"]
validation = ["validation_0.csv"]
[[model]]
name = "simple"
[evaluate]
horizons_s = [0.1]
starts = 1
draws = 0
[render]
video = false
"""

if __name__ == "__main__":
    unittest.main()
