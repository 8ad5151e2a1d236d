"""A load from a run without it and a log with it."""
import pathlib
import unittest

from fricid_program import ProgramTest, fricid, load

TINY = pathlib.Path(__file__).with_name("tiny.toml")
LOAD = "payload_kg = 2\npayload_com = [0.01, -0.02, 0.09]\npayload_inertia = [0.02, 0.02, 0.01, 0, 0, 0]\n"


class Payload(ProgramTest):
    def simulate(self, name, seed, robot=""):
        scene = self.write(f"{name}.toml", f'extends = "{TINY}"\nname = "{name}"\nseed = {seed}\n'
                           f"[robot]\n{robot}[sensors]\nrate_hz = 500\n")
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

    def test_mistakes(self):
        bare = self.simulate("bare", 3)
        log = bare / "data/train_0.h5"
        self.assert_refused(fricid("payload", bare, log, "--frame", "gripper"),
                            r"--frame gripper: no frame of .*; allowed: .*flange")
        self.assert_refused(fricid("payload", log, log), r"payload: needs a robot: --robot URDF")
        self.assert_refused(fricid("payload", bare, log, "-o", log), r"-o .*train_0\.h5: would replace an input")


if __name__ == "__main__":
    unittest.main()
