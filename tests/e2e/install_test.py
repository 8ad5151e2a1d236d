"""What is installed works away from the source tree: program, scenes, headers, find_package(fricid)."""
import os
import pathlib
import subprocess
import unittest

from fricid_program import SOURCE, ProgramTest


class Installed(ProgramTest):
    def call(self, *command, **options):
        done = subprocess.run([*map(str, command)], capture_output=True, text=True, **options)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_program_scene_and_consumer(self):
        prefix = self.folder / "prefix"
        self.call("cmake", "--install", os.environ["FRICID_BINARY_DIR"], "--prefix", prefix)

        self.assertTrue(list((prefix / "share/fricid/licences").glob("libmujoco*/LICENSE*")))

        scene = prefix / "share/fricid/scenes/kr6_demo.toml"
        out = self.folder / "run"
        self.call(prefix / "bin/fricid", "simulate", scene, "-o", out)
        self.assertTrue((out / "data/train_0.h5").exists())

        build = self.folder / "build"
        self.call("cmake", "-S", SOURCE / "tests/e2e/consumer", "-B", build, "-G", "Ninja",
                  f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_BUILD_TYPE=Release")
        self.call("cmake", "--build", build)
        printed = self.call(build / "consumer", scene)
        angles = [float(word) for word in printed.split()[:-1]]
        self.assertEqual(len(angles), 6)
        self.assertGreater(max(abs(a - 0.1) for a in angles), 1e-3)


if __name__ == "__main__":
    unittest.main()
