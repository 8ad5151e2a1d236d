"""A scene on logs: no truth, so no oracle and no headroom; the verdict is that of the fits."""
import math
import os
import unittest

from fricid_program import NO_PLOTS, SOURCE, ProgramTest, fricid, load

LOGS = os.environ.get("FRICID_REALLOGS")

CONTRACT = """
joint_names = ["shoulder", "elbow"]
[position]
columns = "q{}"
[torque]
columns = "tau{}"
"""

SCENE = """
[robot]
urdf = "my_robot.urdf"
mount = "floor"
[data]
contract = "contract.toml"
train = ["$E2E_LOGS/train.csv"]
validation = ["$E2E_LOGS/validation.csv"]
[[model]]
name = "simple"
[evaluate]
horizons_s = [0.1]
starts = 1
"""


class RealLog(ProgramTest):
    def setUp(self):
        super().setUp()
        self.out = self.folder / "run"
        self.write("my_robot.urdf", fricid("template", "robot").stdout)
        self.write("contract.toml", CONTRACT)
        self.scene = self.write("scene.toml", SCENE)
        self.write_log("validation.csv", elbow_rad=0.8)

    def write_log(self, name, elbow_rad=0.9):
        """12 s of a log: both joints swing, the torque is gravity-like plus Coulomb friction."""
        rows = ["t,q1,q2,tau1,tau2"]
        for k in range(3000):
            t = 0.004 * k
            q = [0.8 * math.sin(1.3 * t), elbow_rad * math.sin(2.1 * t)]
            friction = [3 * math.copysign(1, math.cos(w * t)) for w in (1.3, 2.1)]
            tau = [20 * math.sin(q[0]) + friction[0], 5 * math.sin(q[0] + q[1]) + friction[1]]
            rows.append(f"{t:.3f}," + ",".join(f"{x:.7f}" for x in q + tau))
        self.write(name, "\n".join(rows) + "\n")

    def run_scene(self, command="run"):
        return fricid(command, self.scene, "-o", self.out, environment={"E2E_LOGS": str(self.folder)})

    def test_without_truth_there_is_no_verdict_on_horizons(self):
        self.write_log("train.csv")
        done = self.run_scene()
        self.assertEqual(done.returncode, 0, done.stderr)
        evaluation = load(self.out / "evaluation.json")
        self.assertEqual(evaluation["headroom"], [None])
        self.assertEqual([m["name"] for m in evaluation["models"]], ["simple"])
        self.assertNotIn("headroom", (self.out / "table.md").read_text())

    def test_a_fit_that_fails_its_health_test_is_a_no(self):
        self.write_log("train.csv", elbow_rad=0)
        for command in ("identify", "run"):
            done = self.run_scene(command)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertFalse(load(self.out / "fit/simple_s1.json")["usable"])

    def test_absent_logs_are_refused_and_leave_no_folder(self):
        for command in ("run", "identify"):
            done = self.run_scene(command)
            self.assert_refused(done, r"scene\.toml:7: .*train\.csv does not exist")
            self.assertFalse(self.out.exists())

    def test_a_broken_log_leaves_no_folder(self):
        self.write("train.csv", "t,q1,q2,tau1,tau2\n0,0,0,0,0\n0.004,0,x,0,0\n")
        self.assert_refused(self.run_scene(), r"train\.csv:3: .*x", self.out)
        self.write_log("train.csv")
        self.write("validation.csv", "t,q1,q2,tau1\n0,0,0,0\n0.004,0,0,0\n")
        self.assert_refused(self.run_scene(), r"validation\.csv.*tau2", self.out)

    def test_what_is_not_ours_stays_when_a_run_fails(self):
        self.write("train.csv", "")
        (self.out / "external").mkdir(parents=True)
        self.assert_refused(self.run_scene(), r"run: found external and no manifest\.json")
        self.assertTrue((self.out / "external").exists())
        (self.out / "external").rmdir()
        self.assert_refused(self.run_scene(), r"train\.csv", self.out / "manifest.json")


class PublicLog(ProgramTest):
    def scene_with(self, name, models):
        """A copy of a scene of scenes/ with these models alone."""
        head, others = (SOURCE / f"scenes/{name}.toml").read_text().split("[[model]]", 1)
        (self.folder / f"{name}_contract.toml").write_text((SOURCE / f"scenes/{name}_contract.toml").read_text())
        tables = "".join(f'[[model]]\nname = "{model}"\n' for model in models)
        return self.write(f"{name}.toml", head + tables + others[others.index("[evaluate]"):])


@unittest.skipUnless(LOGS, "FRICID_REALLOGS is not set")
class Ur10(PublicLog):
    """A real arm whose wrist shows no inertia in its torque: held, said, and no rollout falls."""

    def test_rollouts_stay_on_a_log_that_lies_about_inertia(self):
        out = self.folder / "run"
        done = fricid("run", self.scene_with("ur10", ["simple", "lugre"]), "-o", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        for name in ("simple", "lugre"):
            held = load(out / f"fit/{name}_s1.json")["rigid_body"]["held_armatures"]
            self.assertEqual([h["joint"] for h in held], [f"wrist_{k}_joint" for k in (1, 2, 3)])
        for model in load(out / "evaluation.json")["summary"]:
            self.assertEqual(model["diverged"], 0, model["name"])
        self.assertIn("its torque shows no inertia", (out / "report.html").read_text())


@unittest.skipUnless(LOGS, "FRICID_REALLOGS is not set")
class KinovaGen3(PublicLog):
    """Seven joints, some of which turn without end, in six short motions of which four move one joint alone."""

    def test_another_motion_is_predicted(self):
        out = self.folder / "run"
        done = fricid("run", self.scene_with("kinova_gen3", ["simple"]), "-o", out, "--no-video", environment=NO_PLOTS)
        self.assertLessEqual(done.returncode, 1, done.stderr)  # 1: of a motion of one joint the others are doubted
        evaluation = load(out / "evaluation.json")
        self.assertEqual(evaluation["summary"][0]["diverged"], 0)
        for r2 in evaluation["models"][0]["torque"][0]["r2"]:
            self.assertGreater(r2, 0.7)


@unittest.skipUnless(LOGS, "FRICID_REALLOGS is not set")
class KukaKr300(PublicLog):
    """Ten seconds of training data and a law of the table, gms, that is hard to beat there."""

    def test_the_lvm_is_no_worse_than_gms_on_any_axis(self):
        out = self.folder / "run"
        scene = self.scene_with("kuka_kr300", ["gms", "lvm"])
        done = fricid("run", scene, "-o", out, "--no-video", environment=NO_PLOTS)
        self.assertLessEqual(done.returncode, 1, done.stderr)
        models = {model["name"]: model["torque"] for model in load(out / "evaluation.json")["models"]}
        self.assertEqual(len(models["lvm"]), 2)
        for of_gms, of_lvm in zip(models["gms"], models["lvm"]):
            for axis, (gms, lvm) in enumerate(zip(of_gms["r2"], of_lvm["r2"])):
                self.assertGreater(lvm, gms - 0.002, f"axis {axis + 1}")


if __name__ == "__main__":
    unittest.main()
