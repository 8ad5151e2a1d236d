"""Other robots from a URDF alone: simulated, checked, identified with a network, evaluated."""
import math
import re
import unittest

from fricid_program import NO_PLOTS, SOURCE, ProgramTest, fricid, load

SCENE = """
name = "{robot}"
seed = 2
[robot]
urdf = "{urdf}"
mount = "{mount}"
[friction]
[excitation]
harmonics = 5
base_rad_s = 0.8
train = 2
repeats = 1
validation = 1
restarts = 2
criterion = "none"
[sensors]
encoder_noise_rad = 2e-6
torque_noise = 0.0005
[identify]
min_speed_rad_s = 0.05
[[model]]
name = "simple"
[[model]]
name = "lugre"
starts = 1
[[model]]
name = "lvm"
[model.train]
iterations = 30
batch = 8
window_s = 0.2
[evaluate]
horizons_s = [0.1, 1]
starts = 2
min_headroom = 0
[render]
video = false
"""


class Robots(ProgramTest):
    def job(self, robot, mount="ceiling"):
        urdf = SOURCE / "models" / "test" / f"{robot}.urdf"
        scene = self.write("scene.toml", SCENE.format(robot=robot, urdf=urdf, mount=mount))
        out = self.folder / "run"
        done = fricid("run", scene, "-o", out, environment=NO_PLOTS)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        for name in ("data/train_0.h5", "truth/train_0.h5", "models/lvm_s1.json", "fit/lugre_s1.json",
                     "rollouts/lvm_s1_validation_0.h5", "table.md", "report.html"):
            self.assertTrue((out / name).exists(), name)
        models = {m["name"]: m for m in load(out / "evaluation.json")["models"]}
        self.assertTrue({"oracle", "simple", "lugre", "lvm"} <= set(models))
        for name, model in models.items():
            for trajectory in model["trajectories"]:
                self.assertFalse(trajectory["diverged"], name)
                self.assertTrue(all(math.isfinite(x) for x in trajectory["q_mse"]), name)
        # the family that was injected is fitted better than Coulomb and viscous friction
        error = {name: model["trajectories"][0]["q_mse"][0] for name, model in models.items()}
        self.assertLess(error["lugre"], error["simple"])

        check = fricid("check", out, "--verbose")
        self.assertEqual(check.returncode, 0, check.stdout)
        self.assertIn("Coulomb friction: identified", check.stdout)
        self.assertTrue((out / "check.json").exists())
        return out

    def test_planar_arm_of_two_joints(self):
        out = self.job("planar_2r")
        design = self.folder / "next.toml"
        done = fricid("check", out, "--design", design)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, r"next\.toml and .*next\.csv: \d.* s of motion that, .* raise the information .*log det")
        before, start, designed = (float(x) for x in re.findall(r"(-?[\d.]+)(?= without it| with a random| as designed)", done.stderr))
        self.assertLess(before, start)  # motion is added
        self.assertLessEqual(start, designed)
        self.assertIn('name = "elbow"', design.read_text())
        rows = (self.folder / "next.csv").read_text().splitlines()
        self.assertEqual(rows[0], "t,q_shoulder,q_elbow,v_shoulder,v_elbow")
        first, last = ([float(x) for x in row.split(",")] for row in (rows[1], rows[-1]))
        self.assertEqual([round(v, 3) for v in first[3:]], [0, 0])
        for value, limit in zip(first[1:3], (3.1, 2.8)):
            self.assertLess(abs(value), limit)

    def test_scara_with_a_prismatic_joint(self):
        self.job("scara", mount="floor")

    def test_a_joint_without_limits(self):
        urdf = (SOURCE / "models/test/planar_2r.urdf").read_text()
        turned = urdf.replace('<joint name="shoulder" type="revolute">',
                              '<joint name="shoulder" type="continuous">').replace('lower="-3.1" upper="3.1" ', "")
        self.assertNotEqual(turned, urdf)
        scene = SCENE.format(robot="round", urdf=self.write("round.urdf", turned), mount="ceiling")
        out = self.folder / "run"
        done = fricid("run", self.write("scene.toml", scene), "-o", out, environment=NO_PLOTS)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        joint = load(out / "models/lvm_s1.json")["robot"]["joints"][0]
        self.assertEqual((joint["continuous"], joint["lower"], joint["upper"]), (True, None, None))
        for model in load(out / "evaluation.json")["models"]:
            self.assertFalse(model["trajectories"][0]["diverged"], model["name"])

    def test_arm_of_seven_joints(self):
        self.job("arm_7r")


if __name__ == "__main__":
    unittest.main()
