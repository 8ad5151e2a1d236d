"""Closed loops: friction fed forward, and pushes found by an observer."""
import unittest

from fricid_program import TINY, ProgramTest, fricid, load

LOOPS = """
[controller]
kind = "computed_torque"

[compensation]
gains = [1.0]
bandwidths_hz = [4]
sizes = [0.5]
rest_s = 2.5
"""
CONTACT = """
[contact]
hours = 0.01
pushes = 4
particles = 40
"""


class Loops(ProgramTest):
    def scene(self, text):
        path = self.tiny()
        path.write_text(path.read_text() + text)
        return path

    def test_models_are_compared_in_closed_loop(self):
        scene, folder = self.scene(LOOPS + CONTACT), self.folder / "run"
        done = fricid("run", scene, "-o", folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("RMS at reversals", done.stdout)
        self.assertIn("external torque", done.stdout)
        loops = {loop["model"]: loop for loop in load(folder / "compensation.json")["loops"]}
        self.assertEqual(list(loops), ["none", "simple", "lugre", "truth"])
        rms = {name: sum(x * x for x in loop["reversal_rad"]) for name, loop in loops.items()}
        # LuGre is the truth's own family
        self.assertLess(rms["lugre"], rms["simple"])
        self.assertLess(rms["simple"], rms["none"])
        self.assertLess(rms["truth"], 0.1 * rms["none"])
        rows = load(folder / "contact.json")["models"]
        contact = {row["model"]: row for row in rows if row["method"] == "observer"}
        self.assertEqual(list(contact), ["simple", "lugre", "truth"])
        # a row more for each model that says how noisy it is
        filtered = {row["model"]: row for row in rows if row["method"] == "particles"}
        self.assertEqual([row["method"] for row in rows[3:]], ["particles"] * len(filtered))
        self.assertIn("lugre", filtered)
        self.assertEqual(filtered["lugre"]["label"], contact["lugre"]["label"] + " (particles)")
        for row in (contact["lugre"], filtered["lugre"]):
            self.assertLess(row["forces"][-1]["missed"], 4)
        self.assertNotEqual(filtered["lugre"]["rmse_Nm"], contact["lugre"]["rmse_Nm"])
        self.assertIn("(particles)", (folder / "contact.md").read_text())
        self.assertLess(sum(contact["truth"]["threshold_Nm"]), sum(contact["simple"]["threshold_Nm"]))
        for name in ("loops/lugre_path0_controller0.h5", "contact/lugre.h5", "contact/pushes.h5"):
            self.assertTrue((folder / name).exists(), name)
        self.assertIn('id="contact"', (folder / "report.html").read_text())
        # nothing changed: nothing is done again
        before = (folder / "compensation.json").stat().st_mtime_ns
        again = fricid("run", scene, "-o", folder)
        self.assertIn("compensate: up to date", again.stderr)
        self.assertIn("contact: up to date", again.stderr)
        self.assertEqual(before, (folder / "compensation.json").stat().st_mtime_ns)

        out = self.folder / "contact.h5"
        found = fricid("contact", folder / "models/lugre_s1.json", folder / "data/validation_0.h5",
                       "-o", out, "--json")
        self.assertEqual(found.returncode, 0, found.stderr)
        self.assertIn('"rms_Nm"', found.stdout)
        self.assertTrue(out.exists())
        log = folder / "data/validation_0.h5"
        self.assert_refused(fricid("contact", folder / "models/lugre_s1.json", log, "-o", log),
                            r"-o .*: would replace .*")
        self.assert_refused(fricid("contact", folder / "models/lugre_s1.json", log, "--bandwidth", 0),
                            r"--bandwidth")

    def test_mistakes(self):
        folder = self.folder / "run"
        for text, pattern in (
                (LOOPS.replace("[0.5]", "[]"), r"scene\.toml:\d+: compensation\.sizes = an empty array; allowed"),
                (LOOPS.replace("[4]", "[-1]"), r"scene\.toml:\d+: compensation\.bandwidths_hz.*allowed"),
                (LOOPS + 'drive = "wish"\n', r'drive = "wish"; allowed: reference or measured'),
                (CONTACT + "forces_N = []\n", r"scene\.toml:\d+: contact\.forces_N = an empty array; allowed"),
                (CONTACT + "force_N = [1]\n", r"force_N.*forces_N"),
                (LOOPS + '[[model]]\nname = "truth"\nlaw = "gms"\n', r'name = "truth"; allowed in closed loops')):
            with self.subTest(text):
                self.assert_refused(fricid("run", self.scene(text), "-o", folder), pattern, folder)


if __name__ == "__main__":
    unittest.main()
