"""A user's mistake gets one line, exit 2, and nothing is written."""
import unittest

from fricid_program import SOURCE, TINY, ProgramTest, fricid


class BadScene(ProgramTest):
    def refuse(self, changes, pattern):
        out = self.folder / "out"
        self.assert_refused(fricid("run", self.tiny(changes=changes), "-o", out), pattern, out)

    def test_unknown_key_names_the_nearest(self):
        self.refuse({"base_rad_s": "base_rad"}, r"scene\.toml:\d+: .*base_rad\b.*base_rad_s")

    def test_value_outside_its_range(self):
        self.refuse({"harmonics = 5": "harmonics = -5"}, r"scene\.toml:\d+: .*harmonics = -5")

    def test_law_parameter_outside_its_bounds(self):
        self.refuse({"vs = 0.05": "vs = -0.05"}, r"scene\.toml:\d+: .*vs = -0\.05 rad/s")

    def test_missing_law_parameter(self):
        self.refuse({"vs = 0.05\n": ""}, r"scene\.toml:\d+: .*vs")

    def test_unknown_law(self):
        self.refuse({'law = "lugre"': 'law = "lugrey"'}, r"scene\.toml:\d+: .*lugrey.*lugre")

    def test_wrong_joint_count(self):
        self.refuse({"sigma1 = [60, 60, 30, 8, 7, 4]": "sigma1 = [60, 60]"},
                    r"scene\.toml:\d+: .*sigma1.*2.*6")

    def test_not_toml(self):
        self.refuse({"[excitation]": "[excitation"}, r"scene\.toml:\d+")

    def test_missing_scene(self):
        self.assert_refused(fricid("run", self.folder / "none.toml"), r"none\.toml")

    def test_a_scene_of_the_share_folder_is_found_from_anywhere(self):
        done = fricid("info", "scenes/kr6_demo.toml", cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assert_refused(fricid("info", "scenes/none.toml", cwd=self.folder), r"scenes/none\.toml: cannot be read")

    def test_folder_instead_of_scene(self):
        self.assert_refused(fricid("run", self.folder), str(self.folder))

    def test_empty_scene(self):
        self.assert_refused(fricid("run", self.write("empty.toml", "")), r"empty\.toml")


class BadRobot(ProgramTest):
    def refuse(self, old, new, pattern):
        urdf = (SOURCE / "models/kr6_r700/kr6_r700.urdf").read_text()
        self.assertIn(old, urdf)
        self.write("arm.urdf", urdf.replace(old, new, 1))
        scene = self.tiny(changes={"[excitation]": '[robot]\nurdf = "arm.urdf"\n\n[excitation]'})
        out = self.folder / "out"
        self.assert_refused(fricid("simulate", scene, "-o", out), pattern, out)

    def test_link_without_inertial(self):
        urdf = (SOURCE / "models/kr6_r700/kr6_r700.urdf").read_text()
        link = urdf[urdf.index('<link name="link_2"'):]
        inertial = link[link.index("<inertial>"):link.index("</inertial>") + len("</inertial>")]
        self.refuse(inertial, "", r"arm\.urdf:\d+: .*link_2.*inertial")

    def test_negative_mass(self):
        urdf = (SOURCE / "models/kr6_r700/kr6_r700.urdf").read_text()
        link = urdf[urdf.index('<link name="link_2"'):]
        mass = link[link.index("<mass value="):]
        mass = mass[:mass.index(">") + 1]
        self.refuse(mass, '<mass value="-1"/>', r"arm\.urdf:\d+: .*link_2.*mass = -1")

    def test_missing_file(self):
        scene = self.tiny(changes={"[excitation]": '[robot]\nurdf = "none.urdf"\n\n[excitation]'})
        self.assert_refused(fricid("simulate", scene), r"none\.urdf")


class BadModel(ProgramTest):
    def scene(self, text, changes={}):
        scene = self.tiny(changes=changes)
        scene.write_text(scene.read_text() + text)
        return scene

    def simulated(self, name, scene):
        folder = self.folder / name
        done = fricid("simulate", scene, "-o", folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        return folder

    def test_latents_out_of_range(self):
        out = self.folder / "out"
        scene = self.scene('[[model]]\nname = "lvm_paper"\nn_z = 13\n')
        self.assert_refused(fricid("run", scene, "-o", out),
                            r"scene\.toml:\d+: model\[3\]\.n_z = 13; .* from 1 to 12", out)

    def test_law_of_the_whole_robot_on_too_many_joints(self):
        link = ('<link name="l{}"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>'
                '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>')
        joint = ('<joint name="j{1}" type="revolute"><parent link="l{0}"/><child link="l{1}"/>'
                 '<origin xyz="0.2 0 0"/><axis xyz="0 0 1"/>'
                 '<limit lower="-1" upper="1" velocity="2" effort="50"/></joint>')
        self.write("nine.urdf", '<robot name="nine">' + "".join(link.format(i) for i in range(10)) +
                   "".join(joint.format(i, i + 1) for i in range(9)) + "</robot>")
        scene = self.write("scene.toml", '[robot]\nurdf = "nine.urdf"\n[friction]\n'
                           '[[model]]\nname = "nn"\n')
        out = self.folder / "out"
        self.assert_refused(fricid("run", scene, "-o", out),
                            r"scene\.toml:\d+: .*\"nn\" on a robot of 9 joints; allowed: up to 8", out)

    def test_law_of_the_whole_robot_on_the_log_of_another(self):
        run = self.simulated("six", self.scene('[[model]]\nname = "lvm_paper"\nem = {iterations = 0}\n'))
        fricid("identify", run, "--model", "lvm_paper")
        model = run / "models/lvm_paper_s1.json"
        self.assertTrue(model.exists())
        urdf = SOURCE / "models/test/planar_2r.urdf"
        other = self.write("two.toml", f'[robot]\nurdf = "{urdf}"\n[friction]\n'
                           '[excitation]\nharmonics = 5\nbase_rad_s = 1.0\ntrain = 1\nrepeats = 1\n'
                           'validation = 1\nrestarts = 1\ncriterion = "none"\n')
        log = self.simulated("two", other) / "data/validation_0.h5"
        out = self.folder / "estimate.h5"
        self.assert_refused(fricid("estimate", model, log, "-o", out),
                            r"2 joints, model lvm_paper has 6", out)
        self.assert_refused(fricid("evaluate", run, "--data", log),
                            r"validation_0\.h5: 2 joints; allowed: 6", run / "evaluation.json")

    def test_em_on_less_than_a_second(self):
        run = self.simulated("short", self.scene(
            '[[model]]\nname = "em"\nlaw = "dahl"\nmethod = "em"\n[[model]]\nname = "lvm_paper"\n'
            '[identify]\nfirst_s = 0.9\n'))
        for name in ("em", "lvm_paper"):
            done = fricid("identify", run, "--model", name)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertRegex(done.stderr, r"\nfricid: train_0: 0\.9 s; allowed for expectation-maximisation: "
                             r"1 s or more\n$")
            self.assertFalse((run / f"models/{name}_s1.json").exists())


class BadLog(ProgramTest):
    HEADER = "t,q1,tau1\n"
    CONTRACT = ('joint_names = ["j1"]\n[position]\ncolumns = ["q{}"]\n'
                '[torque]\ncolumns = ["tau{}"]\n')

    def log(self, rows):
        return self.write("log.csv", self.HEADER + "".join(f"{t},{q},{tau}\n" for t, q, tau in rows))

    def import_log(self, rows=None, log=None):
        contract = self.write("contract.toml", self.CONTRACT)
        return fricid("import", log or self.log(rows), "--contract", contract, "-o", self.folder / "out")

    def refuse(self, pattern, **data):
        self.assert_refused(self.import_log(**data), pattern, self.folder / "out" / "log.h5")

    def good_rows(self):
        return [(round(0.004 * k, 6), 0.01 * k, 1 + 0.01 * (k % 7)) for k in range(50)]

    def test_good_log_is_imported(self):
        self.assertEqual(self.import_log(self.good_rows()).returncode, 0)
        self.assertTrue((self.folder / "out" / "log.h5").exists())

    def test_gap_in_time(self):
        rows = self.good_rows()
        del rows[20:23]
        self.refuse(r"log\.csv:22: ", rows=rows)

    def test_time_runs_backwards(self):
        rows = self.good_rows()
        rows[30] = (0.001, *rows[30][1:])
        self.refuse(r"log\.csv:32: ", rows=rows)

    def test_degrees_warn(self):
        done = self.import_log([(t, 57.3 * q * 50, tau) for t, q, tau in self.good_rows()])
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stderr, r"(?i)degree")

    def test_wrong_joint_count(self):
        self.CONTRACT = self.CONTRACT.replace('["j1"]', '["j1", "j2"]')
        self.refuse(r"q2", rows=self.good_rows())

    def test_not_a_number(self):
        rows = self.good_rows()
        rows[7] = (rows[7][0], "abc", 1.0)
        self.refuse(r"log\.csv:9: .*abc", rows=rows)

    def test_empty_file(self):
        self.refuse(r"empty\.csv", log=self.write("empty.csv", ""))

    def test_folder_instead_of_file(self):
        self.refuse(str(self.folder), log=self.folder)


class BadFile(ProgramTest):
    def test_truncated_dataset(self):
        contract = self.write("contract.toml", BadLog.CONTRACT)
        log = self.write("log.csv", BadLog.HEADER + "".join(f"{0.004 * k:.3f},0.1,1\n" for k in range(50)))
        self.assertEqual(fricid("import", log, "--contract", contract, "-o", self.folder).returncode, 0)
        whole = (self.folder / "log.h5").read_bytes()
        (self.folder / "torn.h5").write_bytes(whole[:len(whole) // 2])
        self.assert_refused(fricid("info", self.folder / "torn.h5"), r"torn\.h5")

    def test_evaluating_what_is_not_a_run_folder(self):
        for command in ("evaluate", "render"):
            self.assert_refused(fricid(command, TINY), r"tiny\.toml.*manifest\.json")
            self.assert_refused(fricid(command, self.folder), r"manifest\.json")

    def test_an_empty_text_is_no_path(self):
        # it would be the folder that the program runs in
        contract = self.write("contract.toml", BadLog.CONTRACT)
        log = self.write("log.csv", BadLog.HEADER + "".join(f"{0.004 * k:.3f},0.1,1\n" for k in range(50)))
        before = sorted(self.folder.iterdir())
        for words in (("import", log, "--contract", contract, "-o", ""), ("run", TINY, "-o", ""),
                      ("info", ""), ("export", "", "c")):
            self.assert_refused(fricid(*words, cwd=self.folder), r"is empty")
        self.assertEqual(sorted(self.folder.iterdir()), before)

    def test_unknown_option(self):
        self.assert_refused(fricid("run", "--bogus"), r"bogus|SCENE")

    def test_unknown_command(self):
        self.assert_refused(fricid("simulat"), r"simulat")


if __name__ == "__main__":
    unittest.main()
