"""Fits by windows and by EM, and the online estimator, as a user meets them."""
import json
import subprocess
import time
import unittest

from fricid_program import PROGRAM, ProgramTest, fricid, load

MODELS = """
[[model]]
name = "windows"
law = "dahl"
method = "multi_step"
train = {iterations = 20, window_s = 0.1, batch = 16}
[[model]]
name = "em"
law = "dahl"
method = "em"
em = {iterations = 4, m_steps = 10, batch = 64}
[[model]]
name = "lvm_bristles"
elements = 4
train = {iterations = 10, window_s = 0.1, batch = 16}
"""


class Learning(ProgramTest):
    def run_folder(self):
        scene = self.tiny()
        scene.write_text(scene.read_text() + MODELS)
        folder = self.folder / "run"
        done = fricid("simulate", scene, "-o", folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        return folder

    def test_methods_write_models_and_histories_alike_for_any_jobs(self):
        folder = self.run_folder()
        histories = []
        for jobs in (1, 3):
            done = fricid("identify", folder, "--fresh", "--jobs", jobs, "--model", "windows",
                          "--model", "em", "--model", "lvm_bristles")
            self.assertEqual(done.returncode, 0, done.stderr)
            fits = {name: load(folder / "fit" / f"{name}_s1.json")
                    for name in ("windows", "em", "lvm_bristles")}
            histories.append((fits["windows"]["multi_step"]["held_out"],
                              fits["em"]["em"]["iterations"],
                              fits["lvm_bristles"]["multi_step"]["loss"]))
            for name in ("windows", "lvm_bristles"):
                held_out = fits[name]["multi_step"]["held_out"]
                self.assertEqual(held_out[fits[name]["multi_step"]["chosen"]], min(held_out))
        self.assertEqual(histories[0], histories[1])

    def test_lvm_needs_no_options_and_is_no_worse_than_any_candidate(self):
        scene = self.tiny()
        scene.write_text(scene.read_text() + '\n[[model]]\nname = "lvm"\n'
                         'train = {iterations = 20, window_s = 0.1, batch = 16}\n')
        folder = self.folder / "run"
        self.assertEqual(fricid("simulate", scene, "-o", folder).returncode, 0)
        tables = []
        for jobs in (1, 3):
            done = fricid("identify", folder, "--fresh", "--jobs", jobs, "--model", "lvm")
            self.assertIn(done.returncode, (0, 1), done.stderr)
            fit = load(folder / "fit" / "lvm_s1.json")
            tables.append((fit["candidates"], fit["parts"]))
            taken = [c for c in fit["candidates"] if c["taken"]]
            self.assertEqual(len(taken), 1)
            eligible = [c for c in fit["candidates"] if c["eligible"]]
            self.assertIn(min(fit["candidates"], key=lambda c: c["held_out_q_mse"]), eligible)
            self.assertIn(taken[0], eligible)
            for other in eligible:
                self.assertFalse(all(other[error] < taken[0][error] for error in ("held_out_q_mse", "held_out_torque")),
                                 other)
            self.assertTrue({"sum", "lugre", "gms"} <= {c["name"] for c in fit["candidates"]})
            names = {"bristle": "lugre", "memoryless": "stribeck", "power_flow": "load_dependent", "stribeck": "stribeck_peak"}
            model = load(folder / "models" / "lvm_s1.json")
            laws = dict(zip([joint["joint"] for joint in fit["joints"]], map(json.dumps, model["friction"]), strict=True))
            for part in fit["parts"]:
                if part["part"] in (*names, "gear_load", "asymmetry", "backlash", "temperature"):
                    name = names.get(part["part"], part["part"])
                    self.assertEqual(part["on"], f'"{name}"' in laws[part["joint"]], part)
            # a few seconds held out do not tell what networks are worth
            self.assertNotIn("network", {part["part"] for part in fit["parts"]})
            self.assertNotIn("memory_network", (folder / "models" / "lvm_s1.json").read_text())
        self.assertEqual(tables[0], tables[1])

    def test_a_fit_killed_in_its_middle_goes_on(self):
        folder = self.run_folder()
        command = ("identify", folder, "--model", "em")
        self.assertEqual(fricid(*command).returncode, 0)
        names = ("models/em_s1.json", "fit/em_s1.json")
        reference = [(folder / name).read_text() for name in names]
        self.assertFalse((folder / "checkpoint").exists())
        for name in names:
            (folder / name).unlink()

        checkpoint = folder / "checkpoint" / "em_s1.json"
        job = subprocess.Popen([PROGRAM, *map(str, command)], stderr=subprocess.DEVNULL)
        while not checkpoint.exists() and job.poll() is None:
            time.sleep(0.002)
        job.kill()
        job.wait()
        self.assertTrue(checkpoint.exists(), "the fit was over before it could be killed")
        self.assertGreaterEqual(load(checkpoint)["numbers"]["iteration"], [1])
        self.assertFalse((folder / names[0]).exists())
        done = fricid(*command)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([(folder / name).read_text() for name in names],
                         reference)
        self.assertFalse((folder / "checkpoint").exists())

    def test_only_conventional_fits_are_the_convention_to_beat(self):
        folder = self.run_folder()
        for model in ("simple", "windows", "dahl"):
            done = fricid("identify", folder, "--model", model)
            self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(load(folder / "fit" / "dahl_s1.json")["method"], "conventional")
        fricid("evaluate", folder)
        report = load(folder / "evaluation.json")
        error = {s["name"]: s["q_mse_geometric_mean"] for s in report["summary"]}
        for h, best in enumerate(report["best_conventional"]):
            self.assertEqual(best, min(error["simple"][h], error["dahl"][h]))

    def test_estimate_follows_a_log(self):
        folder = self.run_folder()
        done = fricid("identify", folder, "--model", "windows")
        self.assertEqual(done.returncode, 0, done.stderr)
        model, log = folder / "models" / "windows_s1.json", folder / "data" / "validation_0.h5"
        out = self.folder / "estimate.h5"
        done = fricid("estimate", model, log, "-o", out, "--particles", 50)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("brought back to the measured motion 0 times", done.stdout)
        listed = fricid("info", out)
        self.assertEqual(listed.returncode, 0, listed.stderr)
        for name in ("tau_f", "tau_f_sd", "log_likelihood"):
            self.assertIn(name, listed.stdout)

        self.assert_refused(fricid("estimate", folder / "scene.toml", log, "-o", out), "not JSON")
        self.assert_refused(fricid("estimate", model, model, "-o", out), "not an HDF5 file")
        for taken in log, model:
            self.assert_refused(fricid("estimate", model, log, "-o", taken), r"-o .*: would replace .*")

    def test_a_network_cannot_be_fitted_conventionally(self):
        scene = self.tiny()
        scene.write_text(scene.read_text() +
                         '\n[[model]]\nname = "lvm_bristles"\nmethod = "conventional"\n')
        self.assert_refused(fricid("run", scene, "-o", self.folder / "run"),
                            r"scene\.toml:\d+: model\[\d+\]\.method = \"conventional\"; "
                            "allowed for lvm_bristles: torque, multi_step, em", self.folder / "run")


if __name__ == "__main__":
    unittest.main()
