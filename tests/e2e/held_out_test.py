"""Further recordings: told apart from those of the run, matched by the names of joints, and held out."""
import json
import math
import pathlib
import shutil
import tempfile
import unittest

from fricid_program import TINY, ProgramTest, fricid, load

CONTRACT = """
joint_names = [{}]
[position]
columns = [{}]
[torque]
columns = [{}]
"""
FINGERS = """
<link name="finger"><inertial><mass value="0.1"/><inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0"
 iyz="0"/></inertial></link>
<link name="thumb"><inertial><mass value="0.1"/><inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0"
 iyz="0"/></inertial></link>
<joint name="grip" type="prismatic"><parent link="forearm"/><child link="finger"/><axis xyz="0 1 0"/>
 <limit lower="0.01" upper="0.04" velocity="1" effort="20"/></joint>
<joint name="follows" type="prismatic"><parent link="forearm"/><child link="thumb"/><axis xyz="0 -1 0"/>
 <limit lower="0" upper="0.04" velocity="1" effort="20"/><mimic joint="grip"/></joint>
</robot>"""
SCENE = """
[robot]
urdf = "arm.urdf"
[data]
contract = "contract.toml"
train = ["train.csv"]
validation = ["validation.csv"]
[[model]]
name = "simple"
[evaluate]
horizons_s = [0.1]
starts = 1
"""


def log(amplitude, seconds=12, order=("shoulder", "elbow"), shift=0):
    """Both joints swing; the torque is gravity-like with Coulomb friction."""
    rows = ["t," + ",".join(f"{signal}_{joint}" for signal in ("q", "tau") for joint in order)]
    for k in range(250 * seconds):
        t = 0.004 * k + shift
        q = {"shoulder": 0.8 * math.sin(1.3 * t), "elbow": amplitude * math.sin(2.1 * t)}
        tau = {"shoulder": 20 * math.sin(q["shoulder"]) + 3 * math.copysign(1, math.cos(1.3 * t)),
               "elbow": 5 * math.sin(q["shoulder"] + q["elbow"]) + 3 * math.copysign(1, math.cos(2.1 * t))}
        rows.append(f"{0.004 * k:.3f}," + ",".join(f"{x:.7f}" for x in [*(q[j] for j in order),
                                                                        *(tau[j] for j in order)]))
    return "\n".join(rows) + "\n"


def contract(*joints):
    return CONTRACT.format(*(", ".join(f'"{kind}{joint}"' for joint in joints) for kind in ("", "q_", "tau_")))


class HeldOut(ProgramTest):
    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(holder.cleanup)
        cls.made = pathlib.Path(holder.name)
        files = {"arm.urdf": fricid("template", "robot").stdout, "contract.toml": contract("shoulder", "elbow"),
                 "turned.toml": contract("elbow", "shoulder"), "scene.toml": SCENE, "train.csv": log(0.9),
                 "validation.csv": log(0.8), "other/validation_0.csv": log(0.7), "third/other/validation_0.csv": log(0.6),
                 "turned.csv": log(0.7, order=("elbow", "shoulder"))}
        for name, text in files.items():
            (cls.made / name).parent.mkdir(parents=True, exist_ok=True)
            (cls.made / name).write_text(text)
        for name, columns in (("other/validation_0", "contract"), ("third/other/validation_0", "contract"),
                              ("turned", "turned"), ("train", "contract")):
            file = cls.made / f"{name}.csv"
            done = fricid("import", file, "--contract", cls.made / f"{columns}.toml", "-o", file.parent)
            assert done.returncode == 0, done.stderr
        done = fricid("identify", cls.made / "scene.toml", "-o", cls.made / "run")
        assert done.returncode == 0, done.stderr

    def setUp(self):
        super().setUp()
        shutil.copytree(self.made, self.folder, dirs_exist_ok=True)
        self.run = self.folder / "run"

    def evaluate(self, *files, **options):
        return fricid("evaluate", self.run, *(x for file in files for x in ("--data", self.folder / file)), **options)

    def trajectories(self):
        return load(self.run / "evaluation.json")["trajectories"]

    def test_recordings_of_one_name_stay_apart(self):
        self.assertEqual(self.evaluate().returncode, 0)
        own = {path: path.read_bytes() for path in self.run.rglob("*validation_0.h5")}
        self.assertGreater(len(own), 2)
        for again in (False, True):
            done = self.evaluate("other/validation_0.h5", "third/other/validation_0.h5")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(self.trajectories(), ["validation_0", "other_validation_0", "other_validation_0_2"])
            self.assertRegex(done.stderr, "evaluate: up to date" if again else r"third/other/validation_0\.h5: called other_validation_0_2")
            for name in self.trajectories():
                self.assertRegex(done.stdout, rf"\| +{name} \|")
                self.assertTrue((self.run / f"predictions/simple_s1_{name}.h5").exists(), name)
            for path, data in own.items():
                self.assertEqual(path.read_bytes(), data, path)
        self.assertEqual(self.evaluate().returncode, 0)
        self.assertEqual(self.trajectories(), ["validation_0"])
        self.assertEqual(sorted(self.run.rglob("*validation_0*.h5")), sorted(own))

    def test_one_recording_counts_once(self):
        shutil.copy(self.folder / "other/validation_0.h5", self.folder / "copy.h5")
        self.assert_refused(self.evaluate("other/validation_0.h5", "copy.h5"),
                            r"copy\.h5: all of it is in other_validation_0; allowed: each recording once")
        self.assert_refused(self.evaluate("turned.h5", "copy.h5"), r"copy\.h5: all of it is in turned")
        self.assert_refused(self.evaluate("run/data/validation_0.h5"), r"all of it is in validation_0;")

    def test_a_recording_that_does_not_belong_is_named(self):
        rows = log(0.7).splitlines()
        for k in range(251 * 7, 251 * 8):  # a collision
            *others, elbow = rows[k].split(",")
            rows[k] = ",".join([*others, str(float(elbow) + 60)])
        self.write("hit.csv", "\n".join(rows) + "\n")
        fricid("import", self.folder / "hit.csv", "--contract", self.folder / "contract.toml", "-o", self.folder)
        done = self.evaluate("hit.h5")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, r"does not belong: hit, elbow: from \d\S* to [78]\S* s \d+\S* N m of its torque are "
                                      r"unexplained, .*; remedy: check that recording")
        self.assertIn("Recordings that do not belong", (self.run / "table.md").read_text())
        found = load(self.run / "evaluation.json")
        self.assertFalse(found["trusted"])
        self.assertEqual([(x["recording"], x["joint"]) for x in found["unexplained"]], [("hit", "elbow")])
        fricid("render", self.run, "report")
        self.assertIn("hit, elbow", (self.run / "report.html").read_text())
        self.assertEqual(self.evaluate("other/validation_0.h5").returncode, 0)

    def test_a_prior_of_another_robot_is_refused_before_any_fit(self):
        model = self.run / "models/simple_s1.json"
        scene = self.write("tiny.toml", f'extends = "{TINY}"\n[[model]]\nname = "late"\nlaw = "lugre"\nmethod = "joint"\n'
                                        f'prior = "{model}"\n')
        for command in ("identify", "run", "simulate"):
            self.assert_refused(fricid(command, scene, "-o", self.folder / "out"),
                                r"simple_s1\.json: joints shoulder, elbow; allowed as a prior: those of this robot, joint_a1",
                                self.folder / "out")

    def test_a_prior_of_the_same_robot(self):
        scene = f'extends = "{TINY}"\n[[model]]\nname = "lugre"\nmethod = "joint"\n'
        first = fricid("identify", self.write("first.toml", scene), "-o", self.folder / "first")
        self.assertEqual(first.returncode, 0, first.stderr)
        with_prior = f'{scene}prior = "{self.folder / "first/models/lugre_s1.json"}"\n'
        second = fricid("identify", self.write("second.toml", with_prior), "-o", self.folder / "second")
        self.assertEqual(second.returncode, 0, second.stderr)

    def test_training_data_are_not_held_out(self):
        for name in ("run/data/train_0.h5", "train.h5"):
            self.assert_refused(self.evaluate(name), r"12 s of it are in train_0, which is trained on",
                                self.run / "evaluation.json")
        # a part of it with other times
        self.write("late.csv", log(0.9, seconds=4, shift=2))
        fricid("import", self.folder / "late.csv", "--contract", self.folder / "contract.toml", "-o", self.folder)
        self.assert_refused(self.evaluate("late.h5"), r"4 s of it are in train_0")

    def test_a_manifest_that_lists_an_output_twice(self):
        self.assertEqual(self.evaluate().returncode, 0)
        manifest = self.run / "manifest.json"
        text = json.loads(manifest.read_text())
        outputs = next(stage for stage in text["stages"] if stage["name"] == "evaluate")["outputs"]
        outputs.append(outputs[-1])
        manifest.write_text(json.dumps(text))
        self.assert_refused(self.evaluate(), r"is there twice; allowed: once; with --fresh what is wrong there is done again")
        fits = (self.run / "fit/simple_s1.json").stat().st_mtime_ns
        done = fricid("evaluate", self.run, "--fresh")  # the fits stand
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual((self.run / "fit/simple_s1.json").stat().st_mtime_ns, fits)
        self.assertIn("evaluate: up to date", self.evaluate().stderr)
        manifest.write_text("{")  # nothing stands
        self.assert_refused(self.evaluate(), r"manifest\.json:1: not JSON.*; with --fresh")
        done = fricid("identify", self.run, "--fresh")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.evaluate().returncode, 0)

    def test_joints_are_matched_by_name(self):
        self.assertEqual(self.evaluate("other/validation_0.h5").returncode, 0)
        errors = [model["torque"][1]["rmse"] if "torque" in model else model["trajectories"][1]
                  for model in load(self.run / "evaluation.json")["models"]]
        done = self.evaluate("turned.h5")
        self.assertEqual(done.returncode, 0, done.stderr)
        again = [model["torque"][1]["rmse"] if "torque" in model else model["trajectories"][1]
                 for model in load(self.run / "evaluation.json")["models"]]
        self.assertEqual(json.dumps(again).replace("turned", "other_validation_0"), json.dumps(errors))
        model = self.run / "models/simple_s1.json"
        for command in ("contact", "estimate"):
            said = []
            for name in ("other/validation_0.h5", "turned.h5"):
                done = fricid(command, model, self.folder / name, "-o", self.folder / f"{command}.h5", "--json")
                self.assertIn(done.returncode, (0, 1), done.stderr)
                said.append(json.loads(done.stdout))
            self.assertEqual(*said, command)

    def test_joints_of_another_robot_are_refused(self):
        self.write("foo.toml", contract("foo", "bar"))
        self.write("foo.csv", log(0.7, order=("shoulder", "elbow")).replace("shoulder", "foo").replace("elbow", "bar"))
        fricid("import", self.folder / "foo.csv", "--contract", self.folder / "foo.toml", "-o", self.folder)
        pattern = r"foo\.h5: found foo bar; allowed: those of {}, shoulder elbow, in any order"
        self.assert_refused(self.evaluate("foo.h5"), pattern.format("the robot of the run"))
        for command in ("contact", "estimate"):
            done = fricid(command, self.run / "models/simple_s1.json", self.folder / "foo.h5", "-o", self.folder / "out.h5")
            self.assert_refused(done, pattern.format("model simple"), self.folder / "out.h5")

    def test_runs_of_other_robots_are_compared_apart(self):
        self.assertEqual(self.evaluate().returncode, 0)
        urdf = self.folder / "arm.urdf"
        urdf.write_text(urdf.read_text().replace('mass value="2.5"', 'mass value="3"'))
        other = self.folder / "heavier"
        self.assertEqual(fricid("identify", self.folder / "scene.toml", "-o", other).returncode, 0)
        self.assertEqual(fricid("evaluate", other).returncode, 0)
        done = fricid("compare", "run", "heavier", cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        for folder in ("run", "heavier"):
            self.assertIn(f"## scene ({folder}): 1 run\n", done.stdout)
        self.assert_refused(fricid("compare", self.run, f"{other}/../run/"), r"each run once")

    def test_joints_that_nobody_logs_are_fixed(self):
        urdf = self.folder / "arm.urdf"
        urdf.write_text(urdf.read_text().replace("</robot>", FINGERS))
        robot = ("--contract", self.folder / "contract.toml", "--robot", urdf)
        said = r"contract\.toml: not logged, taken as fixed: grip at 0\.01\n"
        done = fricid("check", self.folder / "train.csv", *robot)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        self.assertRegex(done.stderr, said)
        done = fricid("import", self.folder / "train.csv", *robot, "-o", self.folder / "out")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        self.assertRegex(done.stderr, said)
        done = fricid("payload", self.folder / "train.csv", self.folder / "validation.csv", *robot, "--frame", "flange")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        self.assertRegex(done.stderr, said)
        # a joint that the file does not have is no joint to be fixed
        self.write("wrong.toml", contract("shoulder", "elbow").replace('"elbow"', '"elbw"'))
        done = fricid("check", self.folder / "train.csv", "--contract", self.folder / "wrong.toml", "--robot", urdf)
        self.assert_refused(done, r"joint elbw; allowed: those that move in the robot's file, elbow grip shoulder")
        # scenes say where
        done = fricid("identify", self.folder / "scene.toml", "-o", self.folder / "new")
        self.assert_refused(done, r"fix both at a position by \[robot\] fix")


if __name__ == "__main__":
    unittest.main()
