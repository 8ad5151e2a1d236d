"""No text that came from a file, and no name of a folder, becomes code, a path or markup."""
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

from fricid_program import SOURCE, ProgramTest, fricid

sys.path.insert(0, str(SOURCE / "tests" / "attack"))
import manifest  # noqa: E402

HOSTILE = {
    "newline": "a&#10;system('touch marker')&#10;#",
    "quotes": "a'; system('touch marker'); '",
    "backtick": "`touch marker`",
    "dollar": "$(touch marker)",
    "pipe": "| touch marker",
    "less": "&lt; touch marker",
    "markup": "&lt;script&gt;",
    "percent": "100 %d",
    "line end of a terminal": "a&#13;b",
    "long": "x" * 300,
    "empty": "",
}


def plots_of(run):
    return sorted(path.name for path in (run / "plots").glob("*"))


class HostileNames(ProgramTest):
    def no_marker(self):
        self.assertEqual([str(p) for p in self.folder.rglob("marker*")], [])

    def test_joint_and_link_of_a_urdf(self):
        urdf = (SOURCE / "models/kr6_r700/kr6_r700.urdf").read_text()
        for word in ("joint_a2", "link_2"):
            for what, text in HOSTILE.items():
                with self.subTest(word=word, what=what):
                    self.write("arm.urdf", urdf.replace(f'"{word}"', f'"{text}"'))
                    scene = self.tiny(changes={
                        "[excitation]": '[robot]\nurdf = "arm.urdf"\nmjcf = ""\n\n[excitation]'})
                    out = self.folder / "out"
                    self.assert_refused(fricid("run", scene, "-o", out, cwd=self.folder),
                                        r"arm\.urdf:\d+: ", out)
                    self.no_marker()

    def test_scene_names_stay_inside_run(self):
        for name in ("../../../x", "/abs", "..", ".", "-x", "a/b", "a\\nb", "\\u001b[1m"):
            with self.subTest(name=name):
                scene = self.tiny(changes={'name = "tiny"': f'name = "{name}"'})
                self.assert_refused(fricid("simulate", scene, cwd=self.folder),
                                    r"scene\.toml:\d+: name of a scene", self.folder / "run")

    def test_models_are_not_the_truth(self):
        for name in ("oracle", "simulator"):
            scene = self.tiny(changes={'name = "lugre"\n': f'name = "{name}"\nlaw = "lugre"\n'})
            self.assert_refused(fricid("run", scene, "-o", self.folder / "out"),
                                r"scene\.toml:\d+: .*stands for the truth", self.folder / "out")


class HostileRun(ProgramTest):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        scene = pathlib.Path(cls.holder.name) / "scene.toml"
        text = (SOURCE / "tests/e2e/tiny.toml").read_text()
        scene.write_text(text.replace("../../scenes", str(SOURCE / "scenes")))
        cls.run_folder = pathlib.Path(cls.holder.name) / "run"
        done = fricid("run", scene, "-o", cls.run_folder)
        assert done.returncode in (0, 1), done.stderr

    def copy(self, name="run"):
        folder = self.folder / name
        shutil.copytree(self.run_folder, folder)
        shutil.rmtree(folder / "plots")
        return folder

    def test_folders_of_any_name_hold_their_plots(self):
        usual = plots_of(self.run_folder)
        self.assertTrue(usual)
        for name in ("|touch marker", "<touch marker", "-x", "'q' \"x\" `touch marker`", "100 %d",
                     "a\nb", "$(touch marker)"):
            with self.subTest(name=name):
                run = self.copy(name)
                done = fricid("render", f"./{name}" if name[0] == "-" else name, "plots",
                              cwd=self.folder)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(plots_of(run), usual)
                self.assertEqual([p for p in self.folder.rglob("marker*")], [])

    def forge(self, run, name, old, new):
        """Edits a result and the manifest, so that it passes for what the program wrote."""
        before = (run / name).read_text()
        self.assertIn(old, before)
        (run / name).write_text(before.replace(old, new))
        manifest.vouch_for(run, name)

    def test_an_edited_evaluation_is_refused(self):
        run = self.copy()
        evaluation = run / "evaluation.json"
        evaluation.write_text(evaluation.read_text().replace("lugre", "other"))
        for what in ("plots", "video", "report"):
            self.assert_refused(fricid("render", run, what, cwd=self.folder),
                                r"evaluation\.json: changed since the stage evaluate wrote it")

    def test_names_in_an_evaluation_are_refused(self):
        for text in ("a\nsystem('touch marker')\n#", "../../x", "\x1b[1m", "-x", "a/b"):
            with self.subTest(text=text):
                run = self.copy()
                self.forge(run, "evaluation.json", '"name": "lugre"', '"name": ' + json.dumps(text))
                done = fricid("render", run, "plots", cwd=self.folder)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertRegex(done.stderr.splitlines()[-1], r"evaluation\.json: name of a model")
                self.assertNotIn("\x1b", done.stderr)
                self.assertEqual([p for p in self.folder.rglob("marker*")], [])
                shutil.rmtree(run)

    def test_labels_are_drawn_as_they_are(self):
        run = self.copy()
        self.forge(run, "evaluation.json", '"label": "lugre"',
                   '"label": "</text><x-hostile> \' ` %d | & |"')
        done = fricid("render", run, "plots", "report", cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("<x-hostile", (run / "report.html").read_text())

    def test_scripts_beside_the_plots_are_runnable(self):
        plots = self.run_folder / "plots"
        for script in sorted(plots.glob("*.gp"))[:3]:
            out = self.folder / "own.svg"
            subprocess.run(["gnuplot", "-e", f"set terminal svg; set output '{out}'", script.name],
                           cwd=plots, check=True, stderr=subprocess.DEVNULL)
            self.assertTrue(out.read_text().rstrip().endswith("</svg>"))


if __name__ == "__main__":
    unittest.main()
