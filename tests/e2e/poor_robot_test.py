"""An arm as it is found in public: a short log, a URDF without armatures whose last link has no inertia."""
import csv
import io
import math
import re
import unittest

from fricid_program import SOURCE, ProgramTest, fricid, load

JOINTS = [f"joint_a{j}" for j in range(1, 7)]

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

    def test_a_joint_that_nothing_resists_is_refused_at_once(self):
        scene = self.scene(without_armature(self.urdf))
        log = self.log("train.csv", "train")
        self.log("validation.csv", "validation")
        pattern = r"arm\.urdf: joint joint_a6 has no armature.*link_6.*<fricid armature="
        for command in (["run", scene, "-o", self.out], ["identify", scene, "-o", self.out],
                        ["check", log, "--contract", self.folder / "contract.toml", "--robot",
                         self.folder / "arm.urdf", "--design", self.folder / "next.toml"]):
            self.assert_refused(fricid(*command), pattern, self.out)

    def test_a_fit_that_explains_nothing_says_so(self):
        def scrambled(rows):
            for k, row in enumerate(rows):
                row["tau2"] = 30 * math.sin(37.0 * k)
            return rows
        self.log("train.csv", "train", scrambled)
        self.log("validation.csv", "validation")
        done = fricid("identify", self.scene(self.urdf), "-o", self.out)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, r"simple seed 1: NOT TO BE TRUSTED: .*; "
                                      r"joint_a2: R2 -?[\d.e-]+ on its own training torque; look for")
        fit = load(self.out / "fit/simple_s1.json")
        self.assertFalse(fit["usable"])
        self.assertIn("joint_a2: R2", fit["message"])

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
        for command in ("identify", "run"):
            done = fricid(command, scene, "-o", self.out)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertRegex(done.stderr, r"not to be trusted: train_0: sign of joint_a5: friction would drive")

    def test_one_log_serves_both_ways_in_parts_only(self):
        self.log("train.csv", "train")
        self.log("copy.csv", "train")
        for validation in ('["train.csv"]', '["copy.csv"]', '["copy.csv[6:]"]'):
            self.assert_refused(fricid("run", self.scene(self.urdf, validation=validation), "-o", self.out),
                                r"data\.validation has .*, which is trained on as .*train\.csv", self.out)
        parts = self.scene(self.urdf, train='["train.csv[:4.2]"]', validation='["train.csv[4.2:]"]')
        done = fricid("run", parts, "-o", self.out)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        length = len(self.logs["train"])
        rows = [len(fricid("info", self.out / "data" / f"{name}_0.h5", "--csv").stdout.splitlines()) - 1
                for name in ("train", "validation")]
        self.assertEqual(rows, [1050, length - 1050])


if __name__ == "__main__":
    unittest.main()
