"""What `fricid template` prints is accepted as it is: a robot, a scene on it, a contract."""
import unittest

from fricid_program import ProgramTest, fricid, load

# The template's robot for MuJoCo.
MJCF = """
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="base_link">
      <body name="upper_arm" pos="0 0 1.2">
        <joint name="shoulder" axis="0 1 0" armature="{armature}"/>
        <inertial pos="0.01 0 -0.22" mass="6" diaginertia="0.12 0.12 0.02"/>
        <body name="forearm" pos="0 0 -0.45">
          <joint name="elbow" axis="0 1 0" armature="0.1"/>
          <inertial pos="0 0.01 -0.15" mass="2.5" diaginertia="0.03 0.03 0.004"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""

SCENE = """
[robot]
urdf = "my_robot.urdf"
mjcf = "my_robot.xml"
mount = "floor"

[[friction.law]]
law = "coulomb_viscous"
Fc = [8, 3]
Fv = [5, 2]
v0 = 0.01

[excitation]
harmonics = 5
base_rad_s = 1.0
half_range = [0.6, 0.8]
train = 1
validation = 1
restarts = 2

[[model]]
name = "simple"

[evaluate]
horizons_s = [0.1, 1]
starts = 1
min_headroom = 0
"""


class Template(ProgramTest):
    def template(self, kind, name):
        done = fricid("template", kind)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.write(name, done.stdout)

    def run_on_robot(self, armature):
        self.template("robot", "my_robot.urdf")
        self.write("my_robot.xml", MJCF.format(armature=armature))
        return fricid("run", self.write("scene.toml", SCENE), "-o", self.folder / "run")

    def test_robot_is_identified_as_described(self):
        done = self.run_on_robot(armature=0.4)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(load(self.folder / "run/evaluation.json")["models"][-1]["name"], "simple")
        model = load(self.folder / "run/models/simple_s1.json")
        self.assertEqual([joint["name"] for joint in model["robot"]["joints"]], ["shoulder", "elbow"])

    def test_its_armature_is_read(self):
        done = self.run_on_robot(armature=0.3)
        self.assert_refused(done, r"my_robot\.xml.*my_robot", self.folder / "run")

    def test_scene_and_contract_load(self):
        self.assertEqual(fricid("info", self.template("scene", "scene.toml")).returncode, 0)
        contract = self.template("contract", "contract.toml")
        header = ",".join(["t"] + [f"q{j}" for j in range(1, 7)] + [f"tau{j}" for j in range(1, 7)])
        rows = [",".join(f"{0.004 * k + 0.1 * j:.3f}" if j else f"{0.004 * k:.3f}" for j in range(13))
                for k in range(50)]
        log = self.write("log.csv", "\n".join([header, *rows]) + "\n")
        done = fricid("import", log, "--contract", contract, "-o", self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    unittest.main()
