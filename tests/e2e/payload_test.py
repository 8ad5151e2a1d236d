"""A load from a run without it and a log with it."""
import math
import pathlib
import unittest

from fricid_program import NO_PLOTS, ProgramTest, fricid, load

TINY = pathlib.Path(__file__).with_name("tiny.toml")
LOAD = "payload_kg = 2\npayload_com = [0.01, -0.02, 0.09]\npayload_inertia = [0.02, 0.02, 0.01, 0, 0, 0]\n"
SECTION = """
[payload]
mass_kg = 2
com = [0.01, -0.02, 0.09]
inertia = [0.02, 0.02, 0.01, 0, 0, 0]
"""
JOINTS = [f"joint_a{i}" for i in range(1, 7)]
LOG_CONTRACT = f"""
joint_names = {JOINTS}
[time]
column = "t"
[position]
columns = "q{{}}"
[torque]
columns = "tau{{}}"
"""
PENDULUM = """<robot name="bench"><link name="base"/><link name="l1"><inertial><origin xyz="0 0 -0.1"/><mass value="0.2"/>
<inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link><link name="end"/>
<joint name="j" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" velocity="9" effort="90"/><fricid armature="0.002"/></joint>
<joint name="at_end" type="fixed"><parent link="l1"/><child link="end"/><origin xyz="0 0 -0.3"/></joint></robot>"""
LOGS = """
[robot]
urdf = "models/kr6_r700/kr6_r700.urdf"
mount = "ceiling"
[data]
contract = "contract.toml"
train = ["bare/log.csv"]
validation = ["bare/held_out.csv"]
[[model]]
name = "simple"
[payload]
logs = ["loaded/log.csv"]
"""


class Payload(ProgramTest):
    def simulate(self, name, seed, robot="", more=""):
        scene = self.write(f"{name}.toml", f'extends = "{TINY}"\nname = "{name}"\nseed = {seed}\n'
                           f"[robot]\n{robot}[sensors]\nrate_hz = 500\n{more}")
        done = fricid("simulate", scene, "-o", self.folder / name, "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.folder / name

    def test_a_load_is_found(self):
        bare, loaded = self.simulate("bare", 3), self.simulate("loaded", 4, LOAD)
        out = self.folder / "payload.json"
        done = fricid("payload", bare, loaded / "data/train_0.h5", "-o", out)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        found = load(out)
        self.assertEqual(found["format"], "fricid.payload/1")
        self.assertEqual(found["frame"], "flange")
        self.assertAlmostEqual(found["mass_kg"], 2, delta=0.04)
        for value, truth in zip(found["com_m"], [0.01, -0.02, 0.09], strict=True):
            self.assertAlmostEqual(value, truth, delta=0.004)
        # what it prints are keys of a scene
        scene = self.write("next.toml", f'extends = "{TINY}"\n' + done.stdout)
        self.assertEqual(fricid("info", scene).returncode, 0)

    def test_a_scene_finds_the_load_that_it_simulates(self):
        scene = self.write("run.toml", f'extends = "{TINY}"\n[[model]]\nname = "simple"\n' + SECTION)
        folder = self.folder / "run"
        done = fricid("run", scene, "-o", folder, "--no-video", environment=NO_PLOTS)
        self.assertEqual(done.returncode, 0, done.stderr)
        found = load(folder / "payload.json")
        self.assertEqual(found["with"], ["loaded_0"])
        self.assertAlmostEqual(found["mass_kg"], 2, delta=0.04)
        self.assertIn(f"payload_kg = {found['mass_kg']:.5g}", done.stdout)
        self.assertIn('id="payload"', (folder / "report.html").read_text())
        again = fricid("run", scene, "-o", folder, "--no-video", environment=NO_PLOTS)
        self.assertIn("payload: up to date", again.stderr)

    def test_a_scene_finds_the_load_of_its_logs(self):
        bare, loaded = self.simulate("bare", 3), self.simulate("loaded", 4, LOAD)
        for run, recording, log in (bare, "train_0", "log"), (bare, "validation_0", "held_out"), (loaded, "train_0", "log"):
            (run / f"{log}.csv").write_text(fricid("info", run / f"data/{recording}.h5", "--csv").stdout)
        self.write("contract.toml", LOG_CONTRACT)
        scene = self.write("logs.toml", LOGS)
        folder = self.folder / "run"
        done = fricid("run", scene, "-o", folder, "--no-video", environment=NO_PLOTS)
        self.assertIn(done.returncode, (0, 1), done.stderr)
        found = load(folder / "payload.json")
        self.assertAlmostEqual(found["mass_kg"], 2, delta=0.04)
        for value, truth in zip(found["com_m"], [0.01, -0.02, 0.09], strict=True):
            self.assertAlmostEqual(value, truth, delta=0.004)

    def test_mistakes_in_a_scene(self):
        for text, why in (
                (SECTION.replace("mass_kg = 2", 'logs = ["a.csv"]'), r"payload\.logs beside \[friction\]; allowed"),
                (SECTION + 'frame = "gripper"\n', r'payload\.frame = "gripper"; allowed: .*flange'),
                (SECTION.replace("0.02, 0.02, 0.01", "0.02, 0.02, 0.1"), r"payload\.inertia has principal moments"),
                ("[robot]\npayload_kg = 1\n" + SECTION, r"payload\.mass_kg beside robot\.payload_kg; allowed")):
            scene = self.write("run.toml", f'extends = "{TINY}"\n' + text)
            self.assert_refused(fricid("run", scene, "-o", self.folder / "run"), r"run\.toml:\d+: " + why)

    def test_swapped_logs(self):
        bare, loaded = self.simulate("bare", 3), self.simulate("loaded", 4, LOAD)
        done = fricid("payload", loaded, bare / "data/train_0.h5")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, r"show (1\.9|2)\S* \+- \S+ kg less than those without it: swap the two")
        self.assertNotIn("payload_kg", done.stdout)

    def as_csv(self, run, change=lambda torques: torques, every=1):
        """A recording of a run as a log, with its torques changed, of every `every`-th row."""
        head, *rows = fricid("info", run / "data/train_0.h5", "--csv").stdout.splitlines()
        columns = [i for i, name in enumerate(head.split(",")) if name.startswith("tau")]
        for k, row in enumerate(rows):
            cells = row.split(",")
            for i, torque in zip(columns, change([float(cells[i]) for i in columns]), strict=True):
                cells[i] = repr(torque)
            rows[k] = ",".join(cells)
        self.write("contract.toml", LOG_CONTRACT)
        return self.write(f"{run.name}.csv", "\n".join([head, *rows[::every]]) + "\n")

    def test_what_is_wrong_with_a_log_is_said(self):
        bare, loaded = self.simulate("bare", 3), self.simulate("loaded", 4, LOAD)
        contract = ("--contract", self.folder / "contract.toml")
        self.assertEqual(fricid("payload", bare, self.as_csv(loaded), *contract).returncode, 0)
        turned = self.as_csv(loaded, lambda tau: [tau[0], tau[1], -tau[2], *tau[3:]])
        done = fricid("payload", bare, turned, *contract)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, r"not to be trusted: loaded: damage: sign: tau of joint_a3")
        done = fricid("payload", bare, self.as_csv(loaded, lambda tau: [1.1 * x for x in tau]), *contract)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, r"show 1\.\d+ \+- \S+ times the torque of the arm .* scale of \[torque\]")
        self.assertNotIn("payload_kg", done.stdout)

    def test_the_log_with_the_load_tells_when_its_torque_was_measured(self):
        bare, loaded = self.simulate("bare", 3), self.simulate("loaded", 4, LOAD, "[excitation]\nbase_rad_s = 0.3\n")
        last = []

        def measured(tau):
            """What a torque that is held between samples is at them: the mean of the two beside."""
            before, last[:] = list(last) or tau, tau
            return [(a + b) / 2 for a, b in zip(before, tau, strict=True)]

        done = fricid("payload", bare, self.as_csv(loaded, measured, every=2), "--contract", self.folder / "contract.toml")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("the torque is measured at its samples", done.stderr)

    def pendulum(self, name, load_kg):
        """A log of a light pendulum that carries a load at its end."""
        times = [0.004 * k for k in range(5000)]
        rows = ["t,q1,tau1"]
        for t in times:
            q = v = a = 0.0
            for h in range(1, 6):
                w, x = 0.5 * h, 0.5 * h * t + h * h
                q, v, a = q + 0.4 * math.sin(x), v + 0.4 * w * math.cos(x), a - 0.4 * w * w * math.sin(x)
            inertia, moment = 0.05 + 0.002 + load_kg * 0.09, 9.81 * (0.02 + 0.3 * load_kg)
            tau = inertia * a + moment * math.sin(q) + 0.3 * math.tanh(v / 0.01) + 0.1 * v
            rows.append(f"{t:.3f},{q:.9f},{tau:.9f}")
        return self.write(name, "\n".join(rows) + "\n")

    def test_a_load_far_heavier_than_its_link_is_no_wrong_unit(self):
        robot = self.write("robot.urdf", PENDULUM)
        contract = self.write("contract.toml", LOG_CONTRACT.replace(str(JOINTS), '["j"]'))
        bare, loaded = self.pendulum("bare.csv", 0), self.pendulum("loaded.csv", 12)
        options = ("--contract", contract, "--robot", robot)
        self.assertIn("torque_unit", fricid("check", loaded, *options).stdout)
        done = fricid("payload", bare, loaded, *options, "--frame", "end")
        self.assertIn("no load is seen: mass 12 ", done.stdout)  # one axis does not tell a mass from its place
        self.assertNotIn("torque_unit", done.stderr)

    def test_output_replaces_its_like_alone(self):
        bare, loaded = self.simulate("bare", 3), self.simulate("loaded", 4, LOAD)
        model, out = self.write("model.json", '{"format": "fricid.model/1"}'), self.folder / "out.json"
        command = ("payload", bare, loaded / "data/train_0.h5", "-o")
        self.assert_refused(fricid(*command, model), r"model\.json: would replace a file that is no fricid\.payload; allowed: another name")
        for _ in range(2):
            self.assertEqual(fricid(*command, out).returncode, 0)

    def test_a_run_has_its_own_robot(self):
        bare = self.simulate("bare", 3)
        for command in (("payload", bare, bare / "data/train_0.h5"), ("check", bare)):
            self.assert_refused(fricid(*command, "--mount", "ceiling"), r"a run with --robot, --mount .*; allowed: its own robot")

    def test_parts_of_logs(self):
        bare, loaded = self.simulate("bare", 3), self.simulate("loaded", 4, LOAD)
        log = loaded / "data/train_0.h5"
        done = fricid("payload", bare, f"{log}[0.5:]", "-o", self.folder / "out.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertAlmostEqual(load(self.folder / "out.json")["mass_kg"], 2, delta=0.1)
        self.assertRegex(fricid("check", f"{log}[1:4]").stdout, r"train_0: (3|2\.99\d) s at 500 Hz")
        self.assert_refused(fricid("payload", bare, f"{log}[4:1]"), r"\[4:1\] is no part of a log; allowed: seconds")
        self.assert_refused(fricid("check", f"{log}[0:1e5]"), r"ends at 100000 s; the log has")
        self.assert_refused(fricid("payload", bare, f"{log}[1:]", "-o", log), r"-o .*: would replace .*train_0\.h5;")

    def test_mistakes(self):
        bare = self.simulate("bare", 3)
        log = bare / "data/train_0.h5"
        self.assert_refused(fricid("payload", bare, log, "--frame", "gripper"),
                            r"--frame gripper: no frame of .*; allowed: .*flange")
        self.assert_refused(fricid("payload", log, log), r"payload: needs a robot: --robot URDF")
        self.assert_refused(fricid("payload", bare, log, "-o", log), r"-o .*train_0\.h5: would replace .*train_0\.h5")


if __name__ == "__main__":
    unittest.main()
