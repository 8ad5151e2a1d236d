"""Motors that turn two joints: what is at the motors is found there, and missed where nobody says so."""
import csv
import io
import unittest

from fricid_program import NO_PLOTS, SOURCE, ProgramTest, fricid, load

COULOMB = [10, 11, 6, 2.8, 2.5, 1.6]
VISCOUS = [6, 6.5, 2.6, 1.4, 1.2, 0.5]
COUPLING = """
[[robot.coupling]]
joint = "joint_a6"
motor = "joint_a5"
factor = -1
"""
TRUTH = f"""
extends = "{SOURCE}/scenes/kr6_base.toml"
seed = 5
[plant]
step_s = 0.0005
[[friction.law]]
law = "coulomb_viscous"
Fc = {COULOMB}
Fv = {VISCOUS}
v0 = 0.01
[excitation]
harmonics = 10
base_rad_s = 0.5
train = 2
repeats = 1
validation = 1
restarts = 1
[[model]]
name = "simple"
[evaluate]
horizons_s = [0.1, 1]
starts = 1
min_headroom = 0
[render]
video = false
""" + COUPLING
LOGS = """
[robot]
urdf = "models/kr6_r700/kr6_r700.urdf"
mount = "ceiling"
[data]
contract = "contract.toml"
train = ["truth/data/train_0.h5", "truth/data/train_1.h5"]
validation = ["truth/data/validation_0.h5"]
[[model]]
name = "simple"
[evaluate]
horizons_s = [0.1, 1]
starts = 1
min_headroom = 0
[render]
video = false
"""
CONTRACT = """
joint_names = ["joint_a1", "joint_a2", "joint_a3", "joint_a4", "joint_a5", "joint_a6"]
format = "hdf5"
[position]
columns = "q{}"
[torque]
columns = "tau{}"
"""


class Transmission(ProgramTest):
    def parameters(self, run):
        """Coulomb and viscous friction with their standard errors, by motor."""
        fit = load(run / "fit" / "simple_s1.json")
        return fit, [{p["symbol"]: p for p in joint["parameters"]} for joint in fit["joints"]]

    def at_the_motors(self, recording):
        """The recording as motors see it, with its contract."""
        rows = list(csv.DictReader(io.StringIO(fricid("info", recording, "--csv").stdout)))
        columns = ["t"] + [f"{x}{j}" for x in ("q", "tau") for j in range(1, 7)]
        lines = [",".join(columns)]
        for row in rows:
            value = {c: float(row[c]) for c in columns}
            value["q6"] += value["q5"]
            value["tau5"] -= value["tau6"]
            lines.append(",".join(f"{value[c]:.10g}" for c in columns))
        contract = CONTRACT.replace('format = "hdf5"', "gear_ratio = [1, 1, 1, 1, 1, 1]")
        contract = contract.replace('"q{}"', '"q{}"\nunit = "motor_rad"').replace('"tau{}"', '"tau{}"\nkind = "motor_torque"')
        return (self.write("motors.csv", "\n".join(lines) + "\n"),
                self.write("motors.toml", contract + COUPLING.replace("robot.coupling", "coupling")))

    def test_a_coupled_wrist_is_found_at_its_motors_and_named_where_nobody_says_so(self):
        truth = self.folder / "truth"
        done = fricid("run", self.write("truth.toml", TRUTH), "-o", truth, environment=NO_PLOTS)
        self.assertEqual(done.returncode, 0, done.stderr)
        fit, found = self.parameters(truth)
        for j, motor in enumerate(found):
            self.assertAlmostEqual(motor["Fc"]["value"] / COULOMB[j], 1, delta=0.02, msg=f"Fc {j}")
            self.assertAlmostEqual(motor["Fv"]["value"] / VISCOUS[j], 1, delta=0.02, msg=f"Fv {j}")
        # the engine's oracle is the simulator's: q and friction torque went to the motors and back
        models = {m["name"]: m for m in load(truth / "evaluation.json")["models"]}
        self.assertLess(models["oracle"]["trajectories"][0]["q_mse"][1], 1e-7)
        for j, motor in enumerate(COULOMB):
            error = models["oracle"]["trajectories"][0]["friction_rmse"][j]
            self.assertLess(error, 0.2 * motor)  # what filtering the motion costs at reversals

        # as logs of joints: the same with the coupling, a fault that names it without
        self.write("contract.toml", CONTRACT)
        coupled = self.folder / "coupled"
        done = fricid("run", self.write("coupled.toml", LOGS + COUPLING), "-o", coupled, environment=NO_PLOTS)
        self.assertEqual(done.returncode, 0, done.stderr)
        _, again = self.parameters(coupled)
        for one, other in zip(found, again):
            self.assertAlmostEqual(one["Fc"]["value"], other["Fc"]["value"], places=6)
        done = fricid("run", self.write("plain.toml", LOGS), "-o", self.folder / "plain", environment=NO_PLOTS)
        self.assertEqual(done.returncode, 1, done.stderr)
        for joint, other in (("joint_a5", "joint_a6"), ("joint_a6", "joint_a5")):
            self.assertRegex(
                done.stderr, rf'simple_s1: {joint}: friction depends on the speed of {other} too .*'
                             r'\[\[robot\.coupling\]\] joint = "joint_a6", motor = "joint_a5", factor = -1')

        # check names it too, and nothing where it is declared
        check = ["check", truth / "data" / "train_0.h5", "--robot", SOURCE / "models/kr6_r700/kr6_r700.urdf",
                 "--mount", "ceiling"]
        done = fricid(*check)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertRegex(
            done.stdout, r'\nfriction: .*; that of joint_a5 depends on the speed of joint_a6 too: '
                         r'\[\[robot\.coupling\]\] joint = "joint_a6", motor = "joint_a5", factor = -1, if one motor turns both; '
                         r'that of joint_a6 ')
        self.assertNotIn("depends on the speed", fricid("check", coupled).stdout)
        log, contract = self.at_the_motors(truth / "data" / "train_0.h5")
        done = fricid("check", log, "--contract", contract, *check[2:])
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("\nfriction: Coulomb and viscous identified on every joint\n", done.stdout)

        # torques of motors beside positions of joints are no torques about the joints
        rows = (self.folder / "motors.csv").read_text().splitlines()
        mixed = [rows[0]]
        for row in rows[1:]:
            value = row.split(",")
            value[6] = f"{float(value[6]) - float(value[5]):.10g}"
            mixed.append(",".join(value))
        self.write("mixed.csv", "\n".join(mixed) + "\n")
        self.write("mixed.toml", CONTRACT.replace('format = "hdf5"\n', ""))
        scene = LOGS.replace("contract.toml", "mixed.toml").replace('"truth/data/train_0.h5", "truth/data/train_1.h5"', '"mixed.csv"')
        done = fricid("identify", self.write("mixed_scene.toml", scene + COUPLING), "-o", self.folder / "mixed")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, r"simple_s1: the torque leaves \d\S* times less unexplained if its columns are those of the coupled motors; "
                                      r'in the contract \[\[coupling\]\] and kind = "motor_torque"')

        # models carry the coupling into what is made of them
        model = coupled / "models" / "simple_s1.json"
        self.assertEqual(load(model)["robot"]["couplings"], [{"joint": 5, "motor": 4, "factor": -1.0}])
        self.assert_refused(fricid("export", model, "urdf", "-o", self.folder / "urdf"),
                            "urdf cannot represent that the motor of joint_a6 turns by joint_a6 \\+ joint_a5",
                            self.folder / "urdf")
        done = fricid("estimate", model, truth / "data" / "validation_0.h5", "-o", self.folder / "along.h5")
        self.assertIn(done.returncode, (0, 2), done.stderr)

    def test_both_motors_of_a_differential(self):
        """Logs of its joints name the two couplings that declare it, with which the friction of both motors is found."""
        second = """
[[robot.coupling]]
joint = "joint_a5"
motor = "joint_a6"
factor = 1
"""
        truth = self.folder / "truth"
        done = fricid("simulate", self.write("truth.toml", TRUTH + second), "-o", truth)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.write("contract.toml", CONTRACT)
        done = fricid("identify", self.write("plain.toml", LOGS), "-o", self.folder / "plain")
        self.assertEqual(done.returncode, 1, done.stderr)
        for joint in ("joint_a5", "joint_a6"):
            self.assertRegex(
                done.stdout + done.stderr,
                rf'simple_s1: {joint}: friction depends on the speed of .*declare it, '
                r'\[\[robot\.coupling\]\] joint = "joint_a6", motor = "joint_a5", factor = -1 and '
                r'\[\[robot\.coupling\]\] joint = "joint_a5", motor = "joint_a6", factor = 1, or')
        declared = self.folder / "declared"
        done = fricid("identify", self.write("declared.toml", LOGS + COUPLING + second), "-o", declared)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        _, found = self.parameters(declared)
        for j, motor in enumerate(found):
            self.assertAlmostEqual(motor["Fc"]["value"] / COULOMB[j], 1, delta=0.03, msg=f"Fc {j}")

    def test_the_couplings_of_a_contract_are_those_of_the_robot(self):
        scene = LOGS.replace("truth/", str(self.folder) + "/")
        at_motors = "gear_ratio = [1, 1, 1, 1, 1, 1]\n" + CONTRACT.replace('[position]', '[position]\nunit = "motor_rad"') + """
[[coupling]]
joint = "joint_a6"
motor = "joint_a5"
factor = 0.5
"""
        self.write("contract.toml", at_motors)
        self.assert_refused(fricid("run", self.write("both.toml", scene + COUPLING), "-o", self.folder / "run"),
                            r"both\.toml:\d+: robot\.coupling differs from \[\[coupling\]\] of .*contract\.toml",
                            self.folder / "run")


if __name__ == "__main__":
    unittest.main()
