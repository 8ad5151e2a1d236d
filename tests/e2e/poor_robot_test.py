"""An arm as it is found in public: a short log, a URDF without armatures whose last link has no inertia, a
wrist whose motors rub against each other. Right, or said not to be trusted."""
import csv
import io
import math
import re
import unittest

from fricid_program import NO_PLOTS, SOURCE, ProgramTest, fricid, load

JOINTS = [f"joint_a{j}" for j in range(1, 7)]
COULOMB = [10, 11, 6, 2.8, 2.5, 1.6]
VISCOUS = [6, 6.5, 2.6, 1.4, 1.2, 0.5]

CONTRACT = f"""
joint_names = {JOINTS!r}
[position]
columns = "q{{}}"
[torque]
columns = "tau{{}}"
kind = "joint_torque"
"""

SCENE = """
[robot]
urdf = "{urdf}"
mount = "ceiling"
[data]
contract = "contract.toml"
train = {train}
validation = {validation}
[[model]]
name = "simple"
[evaluate]
horizons_s = [0.1]
starts = 1
min_headroom = 0
[render]
video = false
"""


def without_armature(urdf, kept=()):
    """The URDF with the armatures of all joints but those kept taken out, and link_6 a point on its axis."""
    def strip(match):
        joint = match.group(1)
        return match.group(0) if joint in kept else re.sub(r'armature="[^"]*" ?', "", match.group(0))
    urdf = re.sub(r'<joint name="(\w+)".*?</joint>', strip, urdf, flags=re.S)
    head, tail = urdf.split('<link name="link_6">')
    zero = '<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/>'
    return head + '<link name="link_6">' + re.sub(r"<inertia [^>]*/>", zero, tail, count=1)


class PoorRobot(ProgramTest):
    @classmethod
    def setUpClass(cls):
        """6.3 s of training, 6.3 s to judge by, of the KR 6."""
        import tempfile
        import pathlib
        holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(holder.cleanup)
        tiny = SOURCE / "tests" / "e2e" / "tiny.toml"
        done = fricid("simulate", tiny, "-o", holder.name + "/run")
        assert done.returncode == 0, done.stderr
        cls.logs = {}
        for name in ("train", "validation"):
            text = fricid("info", pathlib.Path(holder.name) / "run/data" / f"{name}_0.h5", "--csv").stdout
            cls.logs[name] = [{k: float(v) for k, v in row.items()}
                              for row in csv.DictReader(io.StringIO(text))]
        cls.urdf = re.sub(r"<visual>.*?</visual>", "", (SOURCE / "models/kr6_r700/kr6_r700.urdf").read_text(),
                          flags=re.S)

    def setUp(self):
        super().setUp()
        self.write("contract.toml", CONTRACT)
        self.out = self.folder / "run"

    def log(self, name, of, change=lambda rows: rows):
        rows = change([dict(row) for row in self.logs[of]])
        columns = ["t"] + [f"{x}{j}" for x in ("q", "tau") for j in range(1, 7)]
        lines = [",".join(columns)] + [",".join(f"{row[c]:.9g}" for c in columns) for row in rows]
        return self.write(name, "\n".join(lines) + "\n")

    def scene(self, urdf, train='["train.csv"]', validation='["validation.csv"]', more=""):
        self.write("arm.urdf", urdf)
        return self.write("scene.toml", SCENE.format(urdf="arm.urdf", train=train, validation=validation) + more)

    def fit(self, name="simple"):
        return load(self.out / "fit" / f"{name}_s1.json")

    def test_a_joint_that_nothing_resists_is_refused_at_once(self):
        scene = self.scene(without_armature(self.urdf))
        log = self.log("train.csv", "train")
        self.log("validation.csv", "validation")
        pattern = r"arm\.urdf: joint joint_a6 has no armature.*link_6.*<fricid armature="
        for command in (["run", scene, "-o", self.out], ["identify", scene, "-o", self.out],
                        ["check", log, "--contract", self.folder / "contract.toml", "--robot",
                         self.folder / "arm.urdf", "--design", self.folder / "next.toml"]):
            self.assert_refused(fricid(*command), pattern, self.out)

    def test_an_inertia_that_no_body_has_is_mended_where_asked_for(self):
        """As in vendors' files: one principal moment above the sum of the others."""
        head, tail = self.urdf.split('<link name="link_3">')
        broken = '<inertia ixx="0.2" iyy="0.01" izz="0.005" ixy="0" ixz="0" iyz="0"/>'
        urdf = head + '<link name="link_3">' + re.sub(r"<inertia [^>]*/>", broken, tail, count=1)
        log = self.log("train.csv", "train")
        self.log("validation.csv", "validation")
        scene = self.scene(urdf)
        check = ["check", log, "--contract", self.folder / "contract.toml", "--robot", self.folder / "arm.urdf",
                 "--mount", "ceiling"]
        for command in (["run", scene, "-o", self.out], check):
            self.assert_refused(fricid(*command), r"arm\.urdf:\d+: link link_3: principal moments .*mend_inertia = true in "
                                                  r"\[robot\] of a scene, --mend-inertia", self.out)
        checked = fricid(*check, "--mend-inertia")
        self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)
        self.assertRegex(checked.stdout, "rigid body: .*; inertia mended of link_3\n")
        mending = self.write("mending.toml", scene.read_text().replace("[robot]", "[robot]\nmend_inertia = true"))
        done = fricid("run", mending, "-o", self.out, environment=NO_PLOTS)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.fit()["rigid_body"]["mended_links"], ["link_3"])
        self.assertIn("no body has the inertia of link_3", (self.out / "report.html").read_text())
        for joint, Fc in zip(self.fit()["joints"], COULOMB, strict=True):
            found = {p["symbol"]: p["value"] for p in joint["parameters"]}
            self.assertAlmostEqual(found["Fc"] / Fc, 1, delta=0.1, msg=joint["joint"])

    def test_a_short_log_and_a_poor_file_give_the_friction_of_the_arm(self):
        """A wrist with friction in the sum of its speeds, which no law of ours has: joints 1 to 4 are right
        all the same."""
        def rub(rows):
            for k in range(1, len(rows) - 1):
                speed = sum(rows[k + 1][q] - rows[k - 1][q] for q in ("q5", "q6")) / 0.008
                for tau in ("tau5", "tau6"):
                    rows[k][tau] += 1.2 * math.tanh(speed / 0.02) + 0.3 * speed
            return rows
        self.log("train.csv", "train", rub)
        self.log("validation.csv", "validation", rub)
        scene = self.scene(without_armature(self.urdf, kept=("joint_a6",)))
        done = fricid("identify", scene, "-o", self.out)
        joints = self.fit()["joints"]
        for j in range(4):
            parameters = {p["symbol"]: p["value"] for p in joints[j]["parameters"]}
            self.assertAlmostEqual(parameters["Fc"] / COULOMB[j], 1, delta=0.1, msg=JOINTS[j])
            self.assertAlmostEqual(parameters["Fv"] / VISCOUS[j], 1, delta=0.1, msg=JOINTS[j])
            self.assertGreater(joints[j]["r2"], 0.97, JOINTS[j])
        self.assertEqual(done.returncode, 1, done.stderr)
        for joint, other in (("joint_a5", "joint_a6"), ("joint_a6", "joint_a5")):
            self.assertRegex(done.stderr, rf"simple_s1: {joint}: friction depends on the speed of {other} too .*; "
                                          r"a coupled wrist, differential or belt with friction at its motors and at its joints")
        self.assertEqual({fault["joint"] for fault in self.fit()["faults"]}, {"joint_a5", "joint_a6"})

    def test_a_model_that_explains_nothing_is_not_called_best(self):
        def scrambled(rows):
            for k, row in enumerate(rows):
                row["tau2"] = 30 * math.sin(37.0 * k)
            return rows
        self.log("train.csv", "train", scrambled)
        self.log("validation.csv", "validation")
        done = fricid("run", self.scene(self.urdf), "-o", self.out, environment=NO_PLOTS)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, r"NOT TO BE TRUSTED.*\nsimple_s1: joint_a2: R2 -?[\d.e+]+ on its own training torque; look for")
        fit = self.fit()
        self.assertFalse(fit["usable"])
        self.assertIn("joint_a2", [fault["joint"] for fault in fit["faults"]])
        evaluation = load(self.out / "evaluation.json")
        self.assertFalse(evaluation["trusted"])
        self.assertIn("simple (not to be trusted)", (self.out / "table.md").read_text())
        page = (self.out / "report.html").read_text()
        self.assertIn("simple is not to be trusted:</b> fit: joint_a2: R2", page)
        self.assertNotIn("follows the held-out trajectory best", page)

    def test_a_model_that_fails_on_held_out_torque_is_not_trusted(self):
        def scrambled(rows):
            for k, row in enumerate(rows):
                row["tau2"] = 30 * math.sin(37.0 * k)
            return rows
        self.log("train.csv", "train")
        self.log("validation.csv", "validation", scrambled)
        done = fricid("run", self.scene(self.urdf), "-o", self.out, environment=NO_PLOTS)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertTrue(self.fit()["usable"])
        self.assertRegex((self.out / "report.html").read_text(),
                         r"simple is not to be trusted:</b> validation_0: R2 -[\d.e+]+ of the torque of joint_a2: worse "
                         r"than predicting its mean")

    def test_check_begins_with_a_verdict_of_five_lines(self):
        self.write("arm.urdf", self.urdf)
        log = self.log("train.csv", "train")
        check = ["check", log, "--contract", self.folder / "contract.toml", "--robot", self.folder / "arm.urdf",
                 "--mount", "ceiling"]
        done = fricid(*check)
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = done.stdout.splitlines()
        for line, start in zip(lines, ("train: ", "rigid body: ", "friction: ", "laws: ", "next: ", "")):
            self.assertEqual(line[:len(start)], start, done.stdout)
        self.assertEqual([line.split()[0] for line in lines[6:]], ["joint", *JOINTS], done.stdout)
        every = fricid(*check, "--verbose").stdout
        self.assertGreater(len(every.splitlines()), 60)
        self.assertIn("N m, no temperature", every)
        self.assertNotIn("293.1", every)

    def test_damage_that_misleads_marks_import_and_run(self):
        def reversed_torque(rows):
            for row in rows:
                row["tau5"] = -row["tau5"]
            return rows
        log = self.log("train.csv", "train", reversed_torque)
        self.log("validation.csv", "validation")
        scene = self.scene(self.urdf)
        importing = ["import", log, "--contract", self.folder / "contract.toml", "-o", self.folder / "imported"]
        done = fricid(*importing)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, "train: damage: sign: tau of joint_a5")
        fixed = fricid(*importing, "--fix", "sign")
        self.assertEqual(fixed.returncode, 0, fixed.stderr)
        self.assertRegex(fixed.stderr, "train: repaired: sign: tau of joint_a5")
        self.assertNotIn("damage: sign", fixed.stderr)
        for command in (["identify", scene, "-o", self.out], ["run", scene, "-o", self.out], ["evaluate", self.out]):
            done = fricid(*command)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertRegex(done.stderr, r"not to be trusted: train_0: sign of joint_a5: friction would drive")

    def test_one_log_serves_both_ways_in_parts_only(self):
        self.log("train.csv", "train")
        self.log("copy.csv", "train")
        for validation in ('["train.csv"]', '["copy.csv"]', '["copy.csv[6:]"]'):
            self.assert_refused(fricid("run", self.scene(self.urdf, validation=validation), "-o", self.out),
                                r"data\.validation has .*, which is trained on as .*train\.csv", self.out)
        self.log("validation.csv", "validation")
        for train in ('["train.csv", "train.csv"]', '["train.csv", "copy.csv"]', '["train.csv[:4]", "train.csv[3:]"]'):
            self.assert_refused(fricid("run", self.scene(self.urdf, train=train), "-o", self.out),
                                r"data\.train has .*, whose samples are in .*train\.csv.* too; allowed: each sample once",
                                self.out)
        # the same samples in files that differ: another line at the end, the data set that was made of it
        (self.folder / "copy.csv").write_text((self.folder / "train.csv").read_text() + "\n")
        done = fricid("import", self.folder / "train.csv", "--contract", self.folder / "contract.toml", "-o", self.folder / "made")
        self.assertEqual(done.returncode, 0, done.stderr)
        for validation in ('["copy.csv"]', '["made/train.h5[6:]"]'):
            self.assert_refused(fricid("run", self.scene(self.urdf, validation=validation), "-o", self.out),
                                r"data\.validation has .*, [\d.]+ s of which are in .*train\.csv, which is trained on", self.out)
        parts = self.scene(self.urdf, train='["train.csv[:4.2]"]', validation='["train.csv[4.2:]"]')
        done = fricid("run", parts, "-o", self.out, environment=NO_PLOTS)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        length = len(self.logs["train"])
        rows = [len(fricid("info", self.out / "data" / f"{name}_0.h5", "--csv").stdout.splitlines()) - 1
                for name in ("train", "validation")]
        self.assertEqual(rows, [1050, length - 1050])

    def test_a_joint_that_stands_still_is_named(self):
        def rest(rows):
            for row in rows:
                row["q4"] = 0.25
            return rows
        self.log("train.csv", "train", rest)
        self.log("validation.csv", "validation", rest)
        done = fricid("identify", self.scene(self.urdf), "-o", self.out)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, r"joint_a4: moves by .* in all training data; move it, or .*hold = ")
        scene = self.scene(self.urdf).read_text()
        held = self.write("held.toml", scene.replace("[robot]", '[robot]\nhold = ["joint_a4"]'))
        done = fricid("run", held, "-o", self.folder / "held", environment=NO_PLOTS)
        self.assertEqual(done.returncode, 0, done.stderr)
        fit = load(self.folder / "held" / "fit" / "simple_s1.json")
        self.assertEqual([joint["joint"] for joint in fit["joints"]],
                             [j for j in JOINTS if j != "joint_a4"])
        self.assertIn('fix = {"joint_a4" = 0.25}', (self.folder / "held" / "scene.toml").read_text())
        self.log("validation.csv", "validation")
        self.assert_refused(fricid("run", held, "-o", self.folder / "moving"),
                            r"validation\.csv: joint_a4 is welded at 0\.25 and here at", self.folder / "moving")


if __name__ == "__main__":
    unittest.main()
