"""The exports in MuJoCo, FMPy and onnxruntime, against the engine: tools_test.py SAMPLES [--table].

SAMPLES is written by write_export_samples. --table prints the errors instead of testing them.
"""
import contextlib
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest

import fmpy
import fmpy.fmi3
import fmpy.validation
import mujoco
import numpy as np
import onnxruntime
import pinocchio

SAMPLES = pathlib.Path(sys.argv[1])
SOURCE = pathlib.Path(os.environ["FRICID_SOURCE_DIR"])
LAWS = json.loads((SAMPLES / "laws.json").read_text())
TABLE = [law for law in LAWS if "c" in law]  # without the held-out motions
FMU_BAR, ONNX_BAR = 1e-12, 1e-5

mujoco.mj_loadPluginLibrary(os.environ["FRICID_PLUGIN"])


def code_name(law):
    return re.sub(r"\W", "_", law["name"]) + "_s1"


def motion_of(law):
    return np.fromfile(SAMPLES / f"{law['name']}.motion").reshape(-1, len(law["joints"]), 4)


def engine(law):
    return np.fromfile(SAMPLES / f"{law['name']}.tau").reshape(-1, len(law["joints"]))


def share(tau, law):
    """Largest error as a share of the largest torque."""
    expected = engine(law)
    return float(np.abs(tau - expected).max() / max(np.abs(expected).max(), 1e-300))


class Fmu:
    """An FMU, ready to step."""

    def __init__(self, path):
        self.description = fmpy.read_model_description(str(path))
        self.folder = tempfile.TemporaryDirectory()
        fmpy.extract(str(path), self.folder.name)
        self.slave = fmpy.fmi3.FMU3Slave(
            guid=self.description.instantiationToken, unzipDirectory=self.folder.name,
            modelIdentifier=self.description.coSimulation.modelIdentifier, instanceName="friction")
        self.slave.instantiate()
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}

    def of_joints(self, law, field):
        return [self.references[f"{joint}.{field}"] for joint in law["joints"]]

    def close(self):
        self.slave.terminate()
        self.slave.freeInstance()
        self.folder.cleanup()


def fmu_torques(law):
    motion, dt = motion_of(law), law["dt"]
    fmu = Fmu(SAMPLES / "fmu" / f"{code_name(law)}.fmu")
    inputs = [r for field in ("q", "v", "load", "temperature") for r in fmu.of_joints(law, field)]
    outputs = fmu.of_joints(law, "tau_f")
    tau = np.empty(motion.shape[:2])
    for k, instant in enumerate(motion):
        fmu.slave.setFloat64(inputs, instant.T.ravel().tolist())
        fmu.slave.doStep(k * dt, dt)
        tau[k] = fmu.slave.getFloat64(outputs)
    fmu.close()
    return tau


class Onnx:
    def __init__(self, law):
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = 1
        self.session = onnxruntime.InferenceSession(
            SAMPLES / "onnx" / f"{code_name(law)}_friction.onnx", options)
        self.states = law["states"]

    def __call__(self, instants, z, dt=1e-3):
        """tau_f and z_next of a batch: instants (batch, joints, 4), z (batch, states)."""
        feed = {name: instants[:, :, i].astype(np.float32)
                for i, name in enumerate(("q", "v", "load", "temperature"))}
        feed["dt"] = np.array([dt], np.float32)
        if self.states:
            feed["z"] = z
        result = self.session.run(None, feed)
        return result if self.states else (result[0], z)


def onnx_torques(law):
    motion, dt = motion_of(law), law["dt"]
    friction = Onnx(law)
    z = np.zeros((1, law["states"]), np.float32)
    tau = np.empty(motion.shape[:2])
    for k, instant in enumerate(motion):
        tau[k], z = friction(instant[None], z, dt)
    return tau


def plugin_model(law):
    return mujoco.MjModel.from_xml_path(str(SAMPLES / "plugin" / f"{code_name(law)}_plugin.xml"))


def moved(model, data, steps):
    for k in range(steps):
        data.qfrc_applied[:] = 9 * np.sin(0.012 * data.time / model.opt.timestep + np.arange(2))
        mujoco.mj_step(model, data)
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_INTEGRATION))
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_INTEGRATION)
    return state


class Fmpy(unittest.TestCase):
    def test_every_law(self):
        for law in LAWS:
            with self.subTest(law["name"]):
                path = SAMPLES / "fmu" / f"{code_name(law)}.fmu"
                self.assertEqual(fmpy.validation.validate_fmu(str(path)), [])
                self.assertLessEqual(share(fmu_torques(law), law), FMU_BAR)

    def test_simulated_by_fmpy(self):
        law = next(law for law in LAWS if law["name"] == "gms")
        path = SAMPLES / "fmu" / f"{code_name(law)}.fmu"
        joint = law["joints"][0]
        signals = np.array([(1e-3 * k, 0.1 * np.sin(1e-3 * k)) for k in range(1000)],
                           dtype=[("time", float), (f"{joint}.v", float)])
        result = fmpy.simulate_fmu(str(path), stop_time=0.5, output_interval=1e-3, input=signals,
                                   output=[f"{joint}.tau_f"])
        self.assertGreater(abs(result[f"{joint}.tau_f"][-1]), 1)

    def test_state_is_kept_and_serialised(self):
        law = next(law for law in LAWS if law["name"] == "sum")
        fmu = Fmu(SAMPLES / "fmu" / f"{code_name(law)}.fmu")
        inputs, outputs = fmu.of_joints(law, "v"), fmu.of_joints(law, "tau_f")

        def run():
            fmu.slave.setFloat64(inputs, [0.03, -0.02])  # 0.3 mrad in all: nothing slips
            for k in range(10):
                fmu.slave.doStep(1e-3 * k, 1e-3)
            return fmu.slave.getFloat64(outputs)

        run()
        state = fmu.slave.getFMUState()
        saved = fmu.slave.serializeFMUState(state)
        after = run()
        fmu.slave.setFMUState(fmu.slave.deserializeFMUState(saved))
        self.assertEqual(run(), after)
        fmu.slave.reset()
        self.assertNotEqual(run(), after)
        fmu.close()


class Onnxruntime(unittest.TestCase):
    def test_every_law(self):
        for law in LAWS:
            with self.subTest(law["name"]):
                self.assertLessEqual(share(onnx_torques(law), law), ONNX_BAR)

    def test_batch_is_its_rows(self):
        for law in LAWS:
            with self.subTest(law["name"]):
                friction = Onnx(law)
                z = np.zeros((5, law["states"]), np.float32)
                rows = [z[:1]] * 5
                motion = motion_of(law)
                for k in range(0, 500, 100):
                    instants = motion[k:k + 2500:500]
                    tau, z = friction(instants, z)
                    for i in range(5):
                        one, rows[i] = friction(instants[i:i + 1], rows[i])
                        np.testing.assert_allclose(tau[i], one[0], rtol=2e-6, atol=1e-6)

    def test_no_step_keeps_the_state(self):
        for law in LAWS:
            friction = Onnx(law)
            z = np.full((1, law["states"]), 1e-3, np.float32)
            np.testing.assert_array_equal(friction(motion_of(law)[700:701], z, dt=0)[1], z)

    def test_a_lost_sample_keeps_the_state(self):
        for law in LAWS:
            with self.subTest(law["name"]):
                instants = np.repeat(motion_of(law)[700:701], 2, axis=0)
                instants[0] = np.nan
                z = np.full((2, law["states"]), 1e-3, np.float32)
                after = Onnx(law)(instants, z)[1]
                np.testing.assert_array_equal(after[0], z[0])
                self.assertTrue(np.isfinite(after[1]).all())


class Mujoco(unittest.TestCase):
    def test_every_law_loads_and_moves(self):
        for law in TABLE:
            with self.subTest(law["name"]):
                model = plugin_model(law)
                self.assertTrue(np.isfinite(moved(model, mujoco.MjData(model), 200)).all())

    def test_threads_and_reset(self):
        model = plugin_model(next(law for law in LAWS if law["name"] == "sum"))
        ends = [None] * 4

        def run(i):
            ends[i] = moved(model, mujoco.MjData(model), 500)

        threads = [threading.Thread(target=run, args=(i,)) for i in range(4)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        data = mujoco.MjData(model)
        moved(model, data, 50)
        mujoco.mj_resetData(model, data)
        for end in ends:
            np.testing.assert_array_equal(end, moved(model, data, 500))
            mujoco.mj_resetData(model, data)

    def test_wrong_joint_is_a_sentence(self):
        text = (SAMPLES / "plugin" / "gms_s1_plugin.xml").read_text().replace("joint 2", "elbow")
        wrong = SAMPLES / "plugin" / "wrong.xml"
        wrong.write_text(text)
        with self.assertRaisesRegex(Exception, "the MJCF has no joint joint 2"):
            mujoco.MjData(mujoco.MjModel.from_xml_path(str(wrong)))


class Pinocchio(unittest.TestCase):
    """The rigid body of an arm, by another program for rigid bodies."""

    ARM = "kr6_demo_s1"

    def setUp(self):
        self.model = mujoco.MjModel.from_xml_path(str(SAMPLES / "mjcf" / f"{self.ARM}.xml"))
        self.data = mujoco.MjData(self.model)

    def mass_and_bias(self, q, v):
        """M (n, n) with armatures, h (n) of MuJoCo."""
        self.data.qpos, self.data.qvel = q, v
        mujoco.mj_forward(self.model, self.data)
        M = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, M)
        return M, self.data.qfrc_bias

    def test_urdf_and_mjcf_are_the_robot_in_mujoco(self):
        rng = np.random.default_rng(1)
        for arm in (pinocchio.buildModelFromUrdf(str(SAMPLES / "urdf" / f"{self.ARM}.urdf")),
                    pinocchio.buildModelFromMJCF(str(SAMPLES / "mjcf" / f"{self.ARM}.xml"))):
            arm.gravity.linear = self.model.opt.gravity  # of the mount
            arm.armature = self.model.dof_armature       # which URDF has not
            data = arm.createData()
            for q, v in rng.normal(size=(20, 2, self.model.nv)):
                M, h = self.mass_and_bias(q, v)
                upper = np.triu(pinocchio.crba(arm, data, q))
                np.testing.assert_allclose(upper, np.triu(M), rtol=0, atol=1e-12 * np.abs(M).max())
                np.testing.assert_allclose(pinocchio.nle(arm, data, q, v), h, rtol=0, atol=1e-12 * np.abs(h).max())


class Documents(unittest.TestCase):
    """The blocks of docs/use_it.md that need other programs, on exports of a sample."""

    PAGE = (SOURCE / "docs/use_it.md").read_text()
    SAMPLE = "lugre_s1"

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(self.folder)

    def copy(self, *formats):
        """The sample's exports under the name that the page uses."""
        for format in formats:
            for path in (SAMPLES / format).glob(f"{self.SAMPLE}*"):
                text = path.read_bytes()
                if path.suffix in (".xml", ".h"):
                    text = text.replace(self.SAMPLE.encode(), b"lvm_s1")
                (self.folder / path.name.replace(self.SAMPLE, "lvm_s1")).write_bytes(text)

    def test_python(self):
        blocks = [block for block in re.findall(r"^```python\n(.*?)^```", self.PAGE, re.M | re.S)
                  if "# export:" in block]
        self.assertEqual(len(blocks), 3)
        self.copy("fmu", "onnx", "plugin")
        for block in blocks:
            exec(compile(block, "use_it.md", "exec"), {"__name__": "__main__"})

    def loaded(self, extension, prefix=""):
        """A robot of the user with the extension."""
        joints = [f'<joint name="{prefix}joint {j}"/><geom size="1"/>' for j in (1, 2)]
        (self.folder / "robot.xml").write_text(
            f"<mujoco>{extension}<worldbody><body>{joints[0]}<body>{joints[1]}</body></body></worldbody></mujoco>")
        return mujoco.MjModel.from_xml_path("robot.xml")

    def test_extension_and_its_attributes(self):
        self.copy("plugin")
        include, = re.findall(r"<include file=.*?/>", self.PAGE)
        model = self.loaded(include)
        usual = moved(model, mujoco.MjData(model), 200)
        self.assertEqual(model.npluginstate, 2)

        attributes = {key: line for line, key in re.findall(r'^    (<config key="(\w+)".*?/>)', self.PAGE, re.M)}
        self.assertEqual(set(attributes), {"prefix", "temperature", "model"})
        text = (self.folder / "lvm_s1_extension.xml").read_text()
        (self.folder / "lvm_s1_extension.xml").write_text(
            text.replace("</instance>", attributes["prefix"] + attributes["temperature"] + "</instance>"))
        model = self.loaded(include, "left_")
        np.testing.assert_array_equal(usual, moved(model, mujoco.MjData(model), 200))

        (self.folder / "lvm_s1.json").write_text((SAMPLES / "model" / "lugre.json").read_text())
        (self.folder / "lvm_s1_extension.xml").write_text(
            re.sub(r"<config key=.content.*?/>", attributes["model"], text))
        model = self.loaded(include)
        np.testing.assert_array_equal(usual, moved(model, mujoco.MjData(model), 200))

    def test_header_by_hand_is_the_plugin(self):
        self.copy("plugin", "c")
        (self.folder / "body.xml").write_text(
            (SAMPLES / "mjcf" / f"{self.SAMPLE}.xml").read_text())
        block, = (b for b in re.findall(r"^```c\n(.*?)^```", self.PAGE, re.M | re.S) if "mj_step1" in b)
        (self.folder / "main.c").write_text("""
#include <math.h>
#include <stdio.h>
#include <mujoco/mujoco.h>
#include "lvm_s1_friction.h"

int main(void) {
  enum { n = lvm_s1_JOINTS };
  char error[1000];
  mjModel *m = mj_loadXML("body.xml", NULL, error, sizeof error);
  mjData *d;
  lvm_s1_state state;
  double load[n], temperature[n], tau_f[n];
  int j, k;
  if (!m) return puts(error), 1;
  d = mj_makeData(m);
  lvm_s1_init(&state);
  for (k = 0; k < 500; ++k) {
    for (j = 0; j < n; ++j) {
      load[j] = 9 * sin(0.012 * d->time / m->opt.timestep + j);
      temperature[j] = 293.15;
    }
""" + block + """  }
  for (j = 0; j < n; ++j) printf("%.17g\\n", d->qpos[j]);
  return 0;
}
""")
        package = pathlib.Path(mujoco.__file__).parent
        library, = package.glob("libmujoco.so*")
        built = subprocess.run([shutil.which("cc") or "gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", f"-isystem{package}/include",
                                "main.c", "-o", "main", str(library), f"-Wl,-rpath,{package}", "-lm"],
                               capture_output=True, text=True)
        self.assertEqual(built.returncode, 0, built.stderr)
        said = subprocess.run(["./main"], capture_output=True, text=True).stdout
        model = mujoco.MjModel.from_xml_path("lvm_s1_plugin.xml")
        data = mujoco.MjData(model)
        moved(model, data, 500)
        self.assertGreater(np.ptp(data.qpos), 1e-3)
        np.testing.assert_allclose([float(x) for x in said.split()], data.qpos, rtol=0, atol=1e-9)

    def test_simulate_loads_the_plugin_from_its_folder(self):
        """simulate calls mj_loadAllPluginLibraries on its folder mujoco_plugin."""
        self.copy("plugin")
        (self.folder / "mujoco_plugin").mkdir()
        shutil.copy(os.environ["FRICID_PLUGIN"], "mujoco_plugin")
        program = ("import mujoco\nmujoco.mj_loadAllPluginLibraries('mujoco_plugin')\n"
                   "m = mujoco.MjModel.from_xml_path('lvm_s1_plugin.xml')\nprint(m.npluginstate)")
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
        self.assertEqual(done.stdout.split(), ["2"], done.stderr)

    def test_the_table_is_that_of_the_page(self):
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            print_table(TABLE[:2])
        page = (SOURCE / "docs/exports.md").read_text().splitlines()
        header, _, *rows = said.getvalue().splitlines()
        self.assertIn(header, page)
        table = page[page.index(header):]
        table = table[:table.index("")]
        for row in rows:
            self.assertEqual([line.count("|") for line in table if line.startswith(row.split("|")[0] + "|" + row.split("|")[1] + "|")],
                             [row.count("|")])
        for law in TABLE:
            self.assertTrue(any(line.startswith(f"| {law['name']} |") for line in table), law["name"])


def print_table(laws):
    """Largest error along the motion as a share of the largest torque; mjcf_friction: RMS."""
    columns = {"c": lambda law: law["c"], "c, float": lambda law: law["c_float"],
               "plugin": lambda law: law["plugin_error"],
               "fmu": lambda law: share(fmu_torques(law), law),
               "onnx, float": lambda law: share(onnx_torques(law), law)}
    print("| law or modifier | parameters | states |", " | ".join(columns), "| mjcf_friction |")
    print("|---" * (len(columns) + 4) + "|")
    for law in laws:
        said = law["mjcf_friction"]
        if isinstance(said, list):
            shares = [float(a) / float(b) for loss in said
                      for a, b in re.findall(r"([\d.e+-]+) N m RMS from the law's ([\d.e+-]+) N m", loss)]
            said = f"{max(shares):.1e}" if shares else "the law"
        else:
            said = "refused"
        errors = " | ".join(f"{error(law):.1e}" for error in columns.values())
        print(f"| {law['name']} | {law['parameters']} | {law['states']} | {errors} | {said} |",
              flush=True)


if __name__ == "__main__":
    if "--table" in sys.argv:
        print_table(TABLE)
    else:
        unittest.main(argv=sys.argv[:1])
