"""fricid export: what it writes, and what it refuses in one line."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import unittest
import zipfile

from fricid_program import ProgramTest, fricid

FORMATS = {"c": "simple_s1_friction.h", "csv": "simple_s1_friction.csv", "urdf": "simple_s1.urdf",
           "mjcf": "simple_s1.xml", "mjcf_friction": "simple_s1_friction.xml", "fmu": "simple_s1.fmu",
           "onnx": "simple_s1_friction.onnx"}


def parameter(value, unit):
    return {"value": value, "unit": unit}


def model(**changes):
    """A model file of one joint."""
    identity = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    link = {"mass": 2.0, "first_moment": [0.2, 0, 0],
            "inertia": {"Ixx": 0.02, "Ixy": 0, "Iyy": 0.05, "Ixz": 0, "Iyz": 0, "Izz": 0.05}}
    joint = {"name": "joint 1", "link": "l1", "type": "revolute", "continuous": False, "parent": -1,
             "R0": identity, "p0": [0, 0, 0], "axis": [0, 0, 1], "lower": -3, "upper": 3,
             "velocity": 2, "effort": 50, "acceleration": 0, "jerk": 0, "armature": 0.1,
             "moves": link}
    law = {"law": "lugre", "elements": 0, "modifiers": [], "parameters": {
        "Fc": parameter(5, "N m"), "Fs": parameter(6, "N m"), "vs": parameter(0.05, "rad/s"),
        "sigma0": parameter(1.5e4, "N m/rad"), "sigma1": parameter(20, "N m s/rad"),
        "sigma2": parameter(2.5, "N m s/rad")}}
    content = {"format": "fricid.model/1", "name": "simple", "label": "Simple", "seed": 1,
               "is_oracle": False, "free_parameters": 6, "budget": "",
               "robot": {"name": "one", "gravity": [0, 0, -9.81], "joints": [joint], "frames": [],
                         "linear_torques": []},
               "friction": [[law]]}
    return content | changes


class Export(ProgramTest):
    def model(self, text=None, **changes):
        return self.write("model.json", text or json.dumps(model(**changes)))

    def refuse(self, pattern, file, format="c"):
        out = self.folder / "out"
        self.assert_refused(fricid("export", file, format, "-o", out), pattern, out)

    def test_a_model_that_is_not_to_be_trusted_says_so(self):
        doubtful = self.model(doubts=["joint 1: R2 -2 on its own training torque; look for a wrong sign"])
        sentence = "simple is NOT TO BE TRUSTED: joint 1: R2 -2"
        for format, name in FORMATS.items():
            out = self.folder / format
            done = fricid("export", doubtful, format, "-o", out)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn(sentence, done.stdout + done.stderr)
            if format == "fmu":
                text = zipfile.ZipFile(out / name).read("modelDescription.xml")
            else:
                text = (out / name).read_bytes()
            if format != "csv":  # numbers alone
                self.assertIn(sentence.encode(), text, format)

    def test_units_of_an_fmu_are_those_of_its_joints(self):
        robot = model()["robot"]
        robot["joints"][0]["type"] = "prismatic"
        law = {"law": "coulomb_viscous", "elements": 0, "modifiers": [],
               "parameters": {"Fc": parameter(5, "N"), "Fv": parameter(2, "N s/m"), "v0": parameter(0.01, "m/s")}}
        out = self.folder / "out"
        done = fricid("export", self.model(robot=robot, friction=[[law]]), "fmu", "-o", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        text = zipfile.ZipFile(out / "simple_s1.fmu").read("modelDescription.xml").decode()
        for variable, unit in {"q": "m", "v": "m/s", "load": "N", "tau_f": "N"}.items():
            self.assertRegex(text, f'name="joint 1.{variable}" [^>]* unit="{unit}"')
        for unit in ("m", "m/s", "N"):
            self.assertIn(f'<Unit name="{unit}">', text)

    def test_every_format_is_written_with_the_same_bytes(self):
        for format, name in FORMATS.items():
            texts = []
            for folder in ("one", "two"):
                out = self.folder / folder
                done = fricid("export", self.model(), format, "-o", out)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn(name, done.stdout)
                self.assertEqual([p.name for p in out.iterdir()], [name])
                texts.append((out / name).read_bytes())
                (out / name).unlink()
            self.assertEqual(*texts)

    def test_formats_in_one_folder_keep_their_files(self):
        out, written = self.folder / "out", []
        for format in (*FORMATS, "plugin"):
            done = fricid("export", self.model(), format, "-o", out, "--json")
            self.assertEqual(done.returncode, 0, done.stderr)
            written += json.loads(done.stdout)["files"]
        self.assertEqual(len(written), len(set(written)), written)

    def test_plugin_is_named(self):
        out = self.folder / "out"
        done = fricid("export", self.model(), "plugin", "-o", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(sorted(p.name for p in out.iterdir()),
                         ["simple_s1_extension.xml", "simple_s1_plugin.xml"])
        library = re.search("note: load (.*) before the model", done.stdout)[1]
        self.assertTrue(pathlib.Path(library).exists(), library)

    def mjcf(self, joint="joint 1", attributes=""):
        return self.write("robot.xml", f"""<mujoco><worldbody><body><joint name="{joint}" {attributes}/>
            <geom size="1"/></body></worldbody></mujoco>""")

    def test_plugin_for_an_mjcf(self):
        out = self.folder / "out"
        done = fricid("export", self.model(), "plugin", "--mjcf", self.mjcf(), "-o", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([p.name for p in out.iterdir()], ["simple_s1_extension.xml"])
        self.assertIn('add <include file="simple_s1_extension.xml"/> to', done.stdout)

    def test_mjcf_of_another_robot(self):
        out = self.folder / "out"
        for made, pattern in ((dict(joint="elbow"), r"robot\.xml: joint joint 1 of one is missing"),
                              (dict(attributes='damping="1"'), r"robot\.xml: joint joint 1 has .*damping 1"),
                              (dict(attributes='type="slide"'), r"robot\.xml: joint joint 1 has another type")):
            done = fricid("export", self.model(), "plugin", "--mjcf", self.mjcf(**made), "-o", out)
            self.assert_refused(done, pattern, out)
        done = fricid("export", self.model(), "plugin", "--mjcf", self.folder / "none.xml", "-o", out)
        self.assert_refused(done, r"none\.xml", out)
        done = fricid("export", self.model(), "c", "--mjcf", self.mjcf(), "-o", out)
        self.assert_refused(done, r"--mjcf: found with c; allowed: with plugin", out)

    def test_json_names_files_and_losses(self):
        done = fricid("export", self.model(), "urdf", "-o", self.folder / "out", "--json")
        result = json.loads(done.stdout)
        self.assertEqual(result["files"], [str(self.folder / "out" / "simple_s1.urdf")])
        self.assertIn("friction is left out", result["losses"])

    def test_run_folder_gives_all_models_but_the_truth(self):
        models = self.folder / "run" / "models"
        models.mkdir(parents=True)
        for seed in (1, 2):
            (models / f"simple_s{seed}.json").write_text(json.dumps(model(seed=seed)))
        (models / "oracle_s1.json").write_text(
            json.dumps(model(name="oracle", is_oracle=True)))
        done = fricid("export", self.folder / "run", "c", "-o", self.folder / "out")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(sorted(p.name for p in (self.folder / "out").iterdir()),
                         ["simple_s1_friction.h", "simple_s2_friction.h"])

    def test_header_is_used_as_the_documents_say(self):
        compiler = shutil.which("cc") or shutil.which("gcc")
        text = (pathlib.Path(os.environ["FRICID_SOURCE_DIR"]) / "docs/use_it.md").read_text()
        program = text.split("```c\n")[1].split("```")[0].replace("lvm_s1", "simple_s1")
        self.write("main.c", program)
        fricid("export", self.model(), "c", "-o", self.folder)
        built = subprocess.run([compiler, "-std=c99", "-Wall", "-Wextra", "-Werror", "main.c", "-o",
                                "main", "-lm"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(built.returncode, 0, built.stderr)
        said = subprocess.run([self.folder / "main"], capture_output=True, text=True).stdout
        # after sliding for a second: the Stribeck level and viscous friction at 0.5 rad/s
        self.assertAlmostEqual(float(said.split()[-1]), 5 + 2.5 * 0.5, places=3)

    def test_commands_of_the_documents(self):
        """Every `fricid export` of docs/use_it.md, in a folder that has the run which it names."""
        text = (pathlib.Path(os.environ["FRICID_SOURCE_DIR"]) / "docs/use_it.md").read_text()
        commands = re.findall(r"^(?:    |# export: )fricid (export .*)$", text, re.M)
        self.assertGreaterEqual(len(commands), 5)
        models = self.folder / "run" / "kr6_demo" / "models"
        models.mkdir(parents=True)
        (models / "lvm_s1.json").write_text(json.dumps(model(name="lvm")))
        for command in commands:
            done = fricid(*command.split(), cwd=self.folder)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue((self.folder / done.stdout.splitlines()[0]).exists(), command)

    def test_unknown_format(self):
        self.refuse(r"matlab.*c, csv, urdf, mjcf, mjcf_friction, plugin, fmu, onnx", self.model(), "matlab")

    def test_missing_model(self):
        self.refuse(r"none\.json", self.folder / "none.json")

    def test_folder_without_models(self):
        (self.folder / "empty").mkdir()
        self.refuse(r"empty.*models", self.folder / "empty")

    def test_model_of_another_version(self):
        self.refuse(r"model\.json.*fricid\.model/2 is newer", self.model(format="fricid.model/2"))

    def test_parameter_that_is_no_number(self):
        self.refuse(r"model\.json:1: not JSON, or torn: invalid literal NaN", self.model(json.dumps(model()).replace("0.05, \"unit\"", "NaN, \"unit\"")))

    def test_parameter_out_of_bounds(self):
        self.refuse(r"model\.json.*vs.*-1", self.model(json.dumps(model()).replace("0.05, \"unit\"", "-1, \"unit\"")))

    def test_inertia_that_no_body_has(self):
        text = json.dumps(model()).replace('"mass": 2.0', '"mass": -2.0')
        self.refuse(r"model\.json: robot\.joints\[0\]\.moves\.mass: found -2; allowed: above 0", self.model(text), "urdf")

    def test_output_that_is_a_file(self):
        taken = self.write("taken", "")
        done = fricid("export", self.model(), "c", "-o", taken)
        self.assert_refused(done, r"taken.*a folder")
        self.assertEqual(taken.read_text(), "")

    def test_folder_that_cannot_be_written(self):
        done = fricid("export", self.model(), "c", "-o", "/proc/fricid")
        self.assert_refused(done, r"/proc/fricid")


if __name__ == "__main__":
    unittest.main()
