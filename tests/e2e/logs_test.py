"""Real logs: the doctor speaks on import, repairs only what is named, and says so."""
import json
import math
import shutil
import unittest

from fricid_program import SOURCE, TINY, ProgramTest, fricid, load

CONTRACT = """
joint_names = ["shoulder", "elbow"]
[position]
columns = "q{}"
[torque]
columns = "tau{}"
"""


class Logs(ProgramTest):
    def setUp(self):
        super().setUp()
        self.contract = self.write("contract.toml", CONTRACT)

    def log(self, name, lost=(), torque_sign=1, late=None):
        """12 s of two swinging joints with inertia, gravity and friction; some rows lost, or taken late [s]."""
        rows = ["t,q1,q2,tau1,tau2"]
        for k in range(3000):
            t = 0.004 * k + (late(k) if late else 0)
            q = [0.8 * math.sin(1.3 * t), 0.9 * math.sin(2.1 * t)]
            a = [-0.8 * 1.69 * math.sin(1.3 * t), -0.9 * 4.41 * math.sin(2.1 * t)]
            friction = [3 * math.copysign(1, math.cos(w * t)) for w in (1.3, 2.1)]
            tau = [20 * math.sin(q[0]) + 2 * a[0] + friction[0],
                   torque_sign * (5 * math.sin(q[0] + q[1]) + a[1] + friction[1])]
            if k not in lost:
                rows.append(f"{t:.{7 if late else 3}f}," + ",".join(f"{x:.7f}" for x in q + tau))
        return self.write(name, "\n".join(rows) + "\n")

    def findings(self, path):
        return {f["name"] for f in load(path)["findings"] if f["severity"] == "damage"}

    def test_clean_log(self):
        done = fricid("import", self.log("a.csv"), "--contract", self.contract, "-o", self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("damage", done.stderr)
        self.assertEqual(self.findings(self.folder / "a.doctor.json"), set())
        self.assertEqual(fricid("check", self.folder / "a.h5").returncode, 0)

    def test_torque_that_is_measured_at_its_samples_is_told_from_held_torque(self):
        pendulum = self.write("pendulum.urdf", """<robot name="pendulum"><link name="base"/>
            <link name="arm"><inertial><mass value="4"/><origin xyz="0 0 -0.5"/>
              <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
            <joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
              <limit lower="-3" upper="3" effort="100" velocity="10"/></joint></robot>""")

        def check(late_s, timing):
            rows = ["t,q1,tau1"]
            for k in range(5000):
                def motion(t, order):
                    return sum(size * w**order * math.sin(w * t + order * math.pi / 2)
                               for size, w in ((0.8, 1.3), (0.5, 3.1), (0.2, 6.7)))
                t = 0.008 * k
                at = t + late_s
                tau = (4 * 0.5 * 9.81 * math.sin(motion(at, 0)) + 1.1 * motion(at, 2) + 2 * motion(at, 1)
                       + 3 * math.copysign(1, motion(at, 1)))
                rows.append(f"{t:.3f},{motion(t, 0):.8f},{tau:.6f}")
            contract = self.write("one.toml", 'joint_names = ["shoulder"]\n[position]\ncolumns = "q{}"\n'
                                  f'[torque]\ncolumns = "tau{{}}"\ntiming = "{timing}"\n')
            done = fricid("check", self.write("one.csv", "\n".join(rows) + "\n"), "--contract", contract,
                          "--robot", pendulum)
            return done.stdout + done.stderr

        said = "the torque is measured at its samples (0.5"
        self.assertIn(said, check(0, "auto"))
        self.assertNotIn("measured at its samples", check(0, "held"))
        self.assertNotIn("measured at its samples", check(0.004, "auto"))  # as one held over 8 ms

    def test_a_log_of_the_same_name_keeps_its_data_set(self):
        logs = []
        for folder in ("one", "two"):
            (self.folder / folder).mkdir()
            logs.append(self.log(f"{folder}/a.csv"))
        importing = ["--contract", self.contract, "-o", self.folder / "data"]
        for _ in range(2):
            self.assertEqual(fricid("import", logs[0], *importing).returncode, 0)
        self.assert_refused(fricid("import", logs[1], *importing),
                            r"two/a\.csv: its data set would replace .*a\.h5, that of .*one/a\.csv; "
                            "allowed: another folder with -o, or another name")
        (self.folder / "data/a.doctor.json").unlink()
        self.assert_refused(fricid("import", logs[0], *importing), r"would replace .*a\.h5, a file that")

    def test_a_repair_is_examined(self):
        self.assertEqual(fricid("simulate", TINY, "-o", self.folder / "truth").returncode, 0)
        rows = [row.split(",") for row in fricid("info", "--csv", self.folder / "truth/data/train_0.h5").stdout.split()]
        torque = [k for k, name in enumerate(rows[0]) if name.startswith("tau")]
        contract = self.write("kr6.toml", 'joint_names = ["joint_a1", "joint_a2", "joint_a3", "joint_a4", "joint_a5", '
                              '"joint_a6"]\n[position]\ncolumns = "q{}"\n[torque]\ncolumns = "tau{}"\n')
        urdf = SOURCE / "models/kr6_r700/kr6_r700.urdf"
        right = []
        for name, moved in (("wrist", [0, 1, 2, 4, 5, 3]), ("all", [1, 2, 3, 4, 5, 0])):
            wrong = [list(row) for row in rows]
            for row, given in zip(wrong[1:], rows[1:]):
                for k, at in zip(torque, moved):
                    row[k] = given[torque[at]]
            log = self.write(f"{name}.csv", "\n".join(map(",".join, wrong)) + "\n")
            done = fricid("import", log, "--contract", contract, "--robot", urdf, "--mount", "ceiling", "--fix", "swapped",
                          "-o", self.folder / "out")
            self.assertIn("repaired: swapped", done.stderr)
            table = [row.split(",") for row in
                     fricid("info", "--csv", self.folder / f"out/{name}.h5").stdout.split()]
            mended = all(abs(float(a[table[0].index(f"tau{j}")]) - float(b[rows[0].index(f"tau{j}")])) < 1e-9
                         for a, b in zip(table[1:], rows[1:]) for j in range(1, 7))
            self.assertEqual(done.returncode, 0 if mended else 1, done.stderr)
            self.assertEqual("damaged still" in done.stderr, not mended)
            right.append(mended)
        self.assertTrue(right[0])

    def test_lost_samples_are_found_and_filled_when_named(self):
        log = self.log("a.csv", lost=range(900, 940))
        refused = fricid("import", log, "--contract", self.contract, "-o", self.folder)
        self.assertEqual(refused.returncode, 2)
        self.assertRegex(refused.stderr, r"a\.csv:\d+: gap in time: .*--fix")
        self.assertEqual(refused.stderr.count("\n"), 1)
        found = fricid("check", log, "--contract", self.contract).stdout
        self.assertIn("a: damage: gap: t, 3.596 to 3.76 s: 40 samples", found)
        self.assertIn("--fix gap", found)
        self.assertFalse((self.folder / "a.h5").exists())
        done = fricid("import", log, "--contract", self.contract, "-o", self.folder, "--fix", "gap")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("fixed gap", load(self.folder / "a.doctor.json")["source"])
        again = json.loads(fricid("check", self.folder / "a.h5", "--json").stdout)
        findings = again["doctor"][0]["findings"]
        self.assertEqual([f["signal"] for f in findings if f["name"] == "missing"], ["q, tau"], findings)

    def test_samples_of_a_loop_that_sleeps_are_interpolated_when_named(self):
        log = self.log("a.csv", late=lambda k: 0.0016 * (k * 0.6180339887 % 1))
        refused = fricid("import", log, "--contract", self.contract, "-o", self.folder)
        self.assert_refused(refused, r"a\.csv:\d+: jitter in time: .*--fix")
        self.assertRegex(fricid("check", log, "--contract", self.contract).stdout, "damage: uneven: t.*--fix uneven")
        done = fricid("import", "--contract", self.contract, "-o", self.folder, "--fix", "uneven", log)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.findings(self.folder / "a.doctor.json"), {"uneven"})
        self.assertEqual(fricid("check", self.folder / "a.h5").returncode, 0)

    def test_a_repaired_data_set_is_what_a_scene_takes_without_a_contract(self):
        shutil.copy(SOURCE / "models/test/planar_2r.urdf", self.folder / "arm.urdf")
        scene = """
            [robot]
            urdf = "arm.urdf"
            [data]
            contract = "contract.toml"
            train = ["a.csv[:8]"]
            validation = ["a.csv[8:]"]
            [[model]]
            name = "simple"
            [evaluate]
            horizons_s = [0.1]
            """.replace("            ", "")
        self.log("a.csv", lost=range(900, 940))
        refused = fricid("run", self.write("scene.toml", scene), "-o", self.folder / "run")
        self.assert_refused(refused, r"a\.csv:\d+: gap in time: .*; `fricid check` lists what `fricid import --fix` repairs")
        done = fricid("import", self.folder / "a.csv", "--contract", self.contract, "-o", self.folder, "--fix", "gap")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.write("scene.toml", scene.replace('contract = "contract.toml"\n', "").replace("a.csv", "a.h5"))
        done = fricid("identify", self.folder / "scene.toml", "-o", self.folder / "run")
        self.assertIn(done.returncode, (0, 1), done.stderr)  # the log is of another arm
        self.assertTrue((self.folder / "run/fit/simple_s1.json").exists(), done.stderr)

    def test_a_sign_is_found_and_turned_when_named(self):
        log = self.log("a.csv", torque_sign=-1)
        found = fricid("check", log, "--contract", self.contract)
        self.assertEqual(found.returncode, 1, found.stderr)
        self.assertRegex(found.stdout, "damage: sign: tau of elbow")
        done = fricid("import", log, "--contract", self.contract, "-o", self.folder, "--fix", "sign")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(fricid("check", self.folder / "a.h5").returncode, 0)

    def test_what_one_log_of_several_has_is_mended_there(self):
        logs = [self.log("a.csv"), self.log("b.csv", lost=range(900, 940))]
        importing = ["--contract", self.contract, "-o", self.folder / "data"]
        self.assertEqual(fricid("import", *logs, *importing, "--fix", "gap").returncode, 0)
        sources = [load(self.folder / f"data/{name}.doctor.json")["source"] for name in "ab"]
        self.assertEqual(["fixed gap" in source for source in sources], [False, True])
        self.assert_refused(fricid("import", *logs, *importing, "--fix", "sign"), "--fix sign: nothing of that name")

    def test_a_repair_that_is_not_needed_is_refused(self):
        log = self.log("a.csv")
        for name, message in (("delay", "nothing of that name"), ("magic", "allowed: gap")):
            done = fricid("import", log, "--contract", self.contract, "--fix", name)
            self.assertEqual(done.returncode, 2)
            self.assertRegex(done.stderr.splitlines()[-1], message)

    def test_what_the_torque_is_taken_for_is_said(self):
        done = fricid("import", self.log("a.csv"), "--contract", self.contract, "-o", self.folder)
        self.assertRegex(done.stderr, r'contract\.toml: torque\.kind = "joint_torque": taken as motor torque')

    def test_a_decimal_comma_is_named(self):
        text = self.log("a.csv").read_text().replace(",", ";").replace(".", ",")
        done = fricid("import", self.write("comma.csv", text), "--contract", self.contract, "-o", self.folder)
        self.assert_refused(done, r"comma\.csv:2: t = \"0,000\"; allowed: a number, and with decimal_comma = true in "
                                  r"the contract it is one", self.folder / "comma.h5")
        self.write("contract.toml", "decimal_comma = true\n" + CONTRACT)
        self.assertEqual(fricid("import", self.folder / "comma.csv", "--contract", self.contract, "-o",
                                self.folder).returncode, 0)

    def test_a_coupling_without_effect_is_refused(self):
        self.write("contract.toml", CONTRACT + '[[coupling]]\njoint = "elbow"\nmotor = "shoulder"\nfactor = 0.5\n')
        done = fricid("import", self.log("a.csv"), "--contract", self.contract, "-o", self.folder)
        self.assert_refused(done, r'contract\.toml:\d+: coupling without effect: position\.unit = "rad" and '
                                  r'torque\.kind = "joint_torque" are of the joints', self.folder / "a.h5")

    def test_couplings_that_leave_a_joint_without_a_motor_are_refused(self):
        one = '[[coupling]]\njoint = "{}"\nmotor = "{}"\nfactor = 1\n'
        text = CONTRACT.replace("[position]", "gear_ratio = [50, 50]\n[position]\nunit = \"motor_rad\"")
        self.write("contract.toml", text + one.format("elbow", "shoulder") + one.format("shoulder", "elbow"))
        log, out = self.log("a.csv"), self.folder / "a.h5"
        for command in (("import", log, "-o", self.folder), ("check", log),
                        ("payload", log, log, "--robot", log)):
            done = fricid(*command, "--contract", self.contract)
            self.assert_refused(done, r"contract\.toml:\d+: coupling\[2\], with those before it, leaves a joint that no "
                                      r"motor turns alone; allowed: factors by which the motors turn every joint", out)

    def test_check_names_what_it_takes(self):
        self.assert_refused(fricid("check", self.contract), r"contract\.toml: a TOML file; allowed: a run folder")
        log = self.log("a.csv").rename(self.folder / "a.dat")
        self.assert_refused(fricid("check", log), r"a\.dat: a log needs --contract FILE")


if __name__ == "__main__":
    unittest.main()
