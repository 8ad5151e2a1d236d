"""A run folder is one that a run made, an empty or a new one; inputs are never outputs."""
import pathlib
import unittest

from fricid_program import TINY, ProgramTest, fricid

CONTRACT = ('joint_names = ["j1"]\n[position]\ncolumns = ["q{}"]\n[torque]\ncolumns = ["tau{}"]\n')
LOG = "t,q1,tau1\n" + "".join(f"{round(0.004 * k, 6)},{0.01 * k},{1 + 0.01 * (k % 7)}\n" for k in range(50))


class RunFolderRule(ProgramTest):
    def test_a_folder_with_other_files_is_refused_and_untouched(self):
        precious = self.folder / "mine" / "data" / "train_0.h5"
        precious.parent.mkdir(parents=True)
        precious.write_text("precious")
        for command in ("run", "simulate", "identify"):
            done = fricid(command, TINY, "-o", self.folder / "mine")
            self.assert_refused(done, r"mine: found data and no manifest\.json; allowed: ")
        self.assertEqual(precious.read_text(), "precious")
        self.assertEqual(len(list((self.folder / "mine").rglob("*"))), 2)

    def test_the_folder_of_the_scene_is_refused(self):
        scene = self.tiny()
        before = scene.read_text()
        done = fricid("simulate", scene.name, "-o", ".", cwd=self.folder)
        self.assert_refused(done, r"found scene\.toml and no manifest\.json")
        self.assertEqual(scene.read_text(), before)

    def test_inputs_inside_of_the_run_are_refused(self):
        self.assertEqual(fricid("simulate", TINY, "-o", self.folder / "run").returncode, 0)
        inside = self.folder / "run" / "data" / "own.toml"
        inside.write_text(self.tiny().read_text())
        done = fricid("simulate", inside, "-o", self.folder / "run")
        self.assert_refused(done, r"own\.toml: lies in the run folder")

    def test_links_that_lead_out_are_refused(self):
        run = self.folder / "run"
        self.assertEqual(fricid("simulate", TINY, "-o", run).returncode, 0)
        precious = self.write("precious", "precious")
        (run / "data" / "train_0.h5").unlink()
        (run / "data" / "train_0.h5").symlink_to(precious)
        self.assert_refused(fricid("simulate", TINY, "-o", run), r"train_0\.h5: found a symbolic link")
        self.assertEqual(precious.read_text(), "precious")

    def test_what_a_check_finds_goes_through_no_link(self):
        run = self.folder / "run"
        self.assertEqual(fricid("simulate", TINY, "-o", run).returncode, 0)
        precious = self.write("precious", "precious")
        (run / "check.json").symlink_to(precious)
        self.assert_refused(fricid("check", run), r"check\.json: found a symbolic link")
        self.assertEqual(precious.read_text(), "precious")

    def test_names_lead_nowhere_else(self):
        for name in ("../../../x", "/abs", "..", ".", "a/b", "a\nb"):
            scene = self.tiny(changes={'name = "tiny"': f"name = {name!r}"
                                       if "\n" not in name else 'name = "a\\nb"'})
            with self.subTest(name=name):
                done = fricid("simulate", scene, cwd=self.folder)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertEqual(sorted(p.name for p in self.folder.iterdir()), ["scene.toml"])

    def test_a_run_of_an_earlier_version_is_refused(self):
        old = self.folder / "run"
        old.mkdir()
        (old / "manifest.json").write_text('{"format": "fricid.manifest/1", "stages": {}}')
        self.assert_refused(fricid("run", TINY, "-o", old), r"made by an earlier version of fricid")


class Imports(ProgramTest):
    def setUp(self):
        super().setUp()
        self.contract = self.write("contract.toml", CONTRACT)
        self.log = self.write("log.csv", LOG)

    def test_two_logs_of_one_name_are_refused(self):
        (self.folder / "other").mkdir()
        other = self.write("other/log.csv", LOG)
        done = fricid("import", self.log, other, "--contract", self.contract, "-o", self.folder / "out")
        self.assert_refused(done, r"other/log\.csv: its data set would go to .*log\.h5, which is",
                            self.folder / "out")

    def test_a_log_is_never_replaced(self):
        done = fricid("import", self.log, "--contract", self.contract, "-o", self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        made = self.folder / "log.h5"
        again = fricid("import", made, "--contract", self.contract, "-o", ".", cwd=self.folder)
        self.assert_refused(again, r"log\.h5: its data set would go to .*log\.h5")

    def test_what_a_killed_import_left_goes_with_the_next(self):
        (self.folder / "out").mkdir()
        left = self.write("out/.other.h5.2147483647.0.fricid.tmp", "half")  # no process has this number
        own = self.write("out/.other.h5.12.0.tmp", "not ours")
        done = fricid("import", self.log, "--contract", self.contract, "-o", self.folder / "out")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertFalse(left.exists())
        self.assertTrue(own.exists())

    def test_a_design_replaces_no_input(self):
        for name in ("next.csv", "next"):
            done = fricid("check", self.log, "--contract", self.contract, "--design", self.folder / name)
            self.assert_refused(done, r"--design .*allowed: a name that ends in \.toml")
        done = fricid("check", self.log, "--contract", self.contract, "--design", self.folder / "log.toml")
        self.assert_refused(done, r"--design .*log\.csv: would replace .*log\.csv")
        self.assertEqual(self.log.read_text(), LOG)

    def test_a_design_replaces_designs_alone(self):
        for name in ("other.toml", "other.csv"):
            other = self.write(name, "a = 1")
            done = fricid("check", self.log, "--contract", self.contract, "--design", self.folder / "other.toml")
            self.assert_refused(done, rf"--design .*other\.toml: would replace .*{name}; allowed: another name, or that of a design")
            self.assertEqual(other.read_text(), "a = 1")
            other.unlink()


if __name__ == "__main__":
    unittest.main()
