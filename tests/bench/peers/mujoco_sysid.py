"""mujoco.sysid in the table of a fricid run: fits on its training data, rolls out, leaves the rollouts.

Reads scene.toml and data/train_*.h5 of the run, and of its held-out data the torque and the starts that
`fricid evaluate` wrote to starts.csv; truth/ is not opened. Fits frictionloss, damping and armature of
every joint and the mass of every link over chunks spread evenly over the training data, prints them with
the intervals that mujoco.sysid states, and writes external/mujoco_sysid.

What it is given, so that the row is about the model: the initial state of each chunk from the zero-phase
filter that fricid uses; a torque held over each sample, which mujoco.sysid would interpolate; the truth's
time step in the rollouts; and the rigid body of the MJCF, in the benchmark the true one, as its start.
For a log (a scene without an MJCF) `--mjcf` names it; what fricid's `simple` found is one: `fricid export MODEL mjcf`.
"""
import argparse
import csv
import dataclasses
import json
import pathlib
import time
import tomllib

import h5py
import mujoco
import mujoco.rollout
import numpy as np
import scipy.signal
from absl import logging
from mujoco import sysid

ROOT = pathlib.Path(__file__).resolve().parents[3]
NAME = "mujoco_sysid"


def hold(x):
    """Missing values replaced by the last one, zero before the first: what fricid's models are driven by."""
    x = x.copy()
    for column in x.T:
        last = 0.0
        for k, value in enumerate(column):
            column[k] = last = value if np.isfinite(value) else last
    return x


@dataclasses.dataclass
class Recording:
    t: np.ndarray  # (T) [s]
    q: np.ndarray  # (T, n) measured [rad]
    tau: np.ndarray  # (T, n) held [N m]
    joints: list[str]
    q_smooth: np.ndarray | None = None  # (T, n) filtered [rad], and its derivative [rad/s]
    v_smooth: np.ndarray | None = None

    @property
    def period(self):
        return self.t[1] - self.t[0]


def read_recording(path):
    with h5py.File(path) as file:
        return Recording(file["t"][:], file["q"][:], hold(file["tau"][:]), list(file.attrs["joint_names"]))


def smoothed(recording, cutoff_hz):
    """Position by a zero-phase Butterworth filter of order 4, velocity by central differences."""
    q = recording.q.copy()
    for column in q.T:
        known = np.isfinite(column)
        column[~known] = np.interp(np.flatnonzero(~known), np.flatnonzero(known), column[known])
    sections = scipy.signal.butter(4, cutoff_hz, fs=1 / recording.period, output="sos")
    q = scipy.signal.sosfiltfilt(sections, q, axis=0)
    return dataclasses.replace(recording, q_smooth=q, v_smooth=np.gradient(q, recording.period, axis=0))


def make_spec(mjcf, joints, step_s):
    """The arm of the scene: a motor per joint, no contacts, limits or shapes, which the truth has not either."""
    spec = mujoco.MjSpec.from_file(str(mjcf))
    for unused in (*spec.geoms, *spec.meshes, *spec.materials, *spec.textures, *spec.keys):
        spec.delete(unused)
    for name in joints:
        joint = spec.joint(name)
        joint.actfrclimited = False
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.gear[0] = 1
    spec.option.timestep = step_s
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    return spec


def make_parameters(spec, recordings):
    """frictionloss and damping from a share of the effort (where the MJCF has none, the largest torque of the
    data), armature and mass from those of the model."""
    joints = recordings[0].joints
    largest = np.max([np.abs(recording.tau).max(axis=0) for recording in recordings], axis=0)
    strength = dict(zip(joints, largest))
    parameters = sysid.ParameterDict()

    def add(name, start, low, high, modify):
        parameters.add(sysid.Parameter(name, start, low, high, modifier=modify))

    def on_joint(field, name):
        def modify(spec, parameter):
            joint = spec.joint(name)
            values = np.array(getattr(joint, field), dtype=float, ndmin=1)  # of damping a polynomial
            values[0] = parameter.value[0]
            setattr(joint, field, values if values.size > 1 else float(values[0]))
        return modify

    def effort(joint):
        limit = float(joint.actfrcrange[1])
        return limit if limit > 0 else strength[joint.name]

    def on_body(name):
        return lambda spec, parameter: setattr(spec.body(name), "mass", float(parameter.value[0]))

    for name in joints:
        joint = spec.joint(name)
        most = effort(joint)
        add(f"frictionloss {name}", 0.05 * most, 0.0, 0.5 * most, on_joint("frictionloss", name))
        add(f"damping {name}", 0.02 * most, 0.0, 0.5 * most, on_joint("damping", name))
        add(f"armature {name}", joint.armature, 0.1 * joint.armature, 10 * joint.armature,
            on_joint("armature", name))
    for name in joints:
        body = spec.joint(name).parent
        add(f"mass {body.name}", body.mass, 0.1 * body.mass, 10 * body.mass, on_body(body.name))
    return parameters


def make_chunks(spec, recordings, rows, count, substeps):
    """`count` chunks of `rows` samples, none missing, spread evenly over the recordings."""
    model = spec.compile()
    starts = [(recording, k) for recording in recordings
              for k in range(0, len(recording.t) - rows - 1, rows)
              if np.isfinite(recording.q[k:k + rows + 1]).all()]
    names, states, controls, sensors = [], [], [], []
    for i in np.linspace(0, len(starts) - 1, min(count, len(starts))).astype(int):
        recording, k = starts[i]
        held = np.repeat(recording.tau[k:k + rows], substeps, axis=0)
        held = np.vstack([held, held[-1:]])
        names.append(f"chunk {i}")
        states.append(sysid.create_initial_state(model, recording.q_smooth[k], recording.v_smooth[k]))
        controls.append(sysid.TimeSeries.from_control_names(
            model.opt.timestep * np.arange(len(held)), held, model))
        sensors.append(sysid.TimeSeries.from_names(
            recording.period * np.arange(rows + 1), recording.q[k:k + rows + 1], model,
            [(f"{name}_qpos", sysid.SignalType.MjStateQPos) for name in recording.joints]))
    return sysid.ModelSequences(NAME, spec, names, states, controls, sensors, allow_missing_sensors=True)


def evenly(recordings, substeps):
    """A residual in units of each joint's spread over all data; mujoco.sysid weighs every chunk by itself."""
    scale = np.nanstd(np.vstack([recording.q for recording in recordings]), axis=0)

    def residual(parameters, predicted, measured, model, return_all, state, sensor_weights=None):
        times, seen = measured.times[1:], measured.data[1:]
        q = state[substeps - 1::substeps, 1:1 + model.nq]
        return ((seen - q) / scale, sysid.TimeSeries(times, q, measured.signal_mapping),
                sysid.TimeSeries(times, seen, measured.signal_mapping))

    return residual


def fit(spec, start, recordings, rows, options, substeps):
    """Fitted parameters and their 95 % half widths as mujoco.sysid states them."""
    chunks = make_chunks(spec, recordings, rows, options.chunks, substeps)
    residual = sysid.build_residual_fn(
        models_sequences=[chunks], modify_residual=evenly(recordings, substeps) if options.even else None)
    fitted, result = sysid.optimize(start, residual, optimizer="mujoco", max_iters=options.max_iters)
    residuals, _, _ = residual(fitted.as_vector(), fitted)
    _, half_widths = sysid.calculate_intervals(residuals, result.jac)
    return fitted, half_widths, len(chunks.control)


def with_friction_of_mujoco(spec, start, recordings, rows, substeps):
    """The recordings as an arm would move that is of the family fitted, and its parameters: every second
    chunk from the smoothed state, the others missing."""
    truth = start.copy()
    for name, parameter in truth.items():
        parameter.value = parameter.value * (1.5 if name.startswith(("frictionloss", "damping")) else 1)
    model = sysid.apply_param_modifiers(truth, spec.copy())
    rng = np.random.default_rng(1)
    made = []
    for recording in recordings:
        q = np.full_like(recording.q, np.nan)
        for k in range(0, len(q) - rows - 1, 2 * rows):
            chunk = slice(k, k + rows + 1)
            q[chunk], _, _ = roll_out(
                model, recording.q_smooth[k], recording.v_smooth[k], recording.tau[chunk], substeps)
        made.append(dataclasses.replace(recording, q=q + 1e-5 * rng.normal(size=q.shape)))
    return made, truth


def roll_out(model, q0, v0, tau, substeps):
    """q, v (rows, n) [rad, rad/s] under the held torque tau, and the friction torque there [N m]."""
    data = mujoco.MjData(model)
    state = sysid.create_initial_state(model, q0, v0)
    control = np.repeat(tau[:-1], substeps, axis=0)
    states, _ = mujoco.rollout.rollout(model, data, state, control)
    states = np.vstack([state, states[0][substeps - 1::substeps]])
    q, v = states[:, 1:1 + model.nq], states[:, 1 + model.nq:1 + model.nq + model.nv]
    tau_f = np.empty_like(v)
    for k in range(len(q)):
        data.qpos[:], data.qvel[:], data.ctrl[:] = q[k], v[k], tau[k]
        mujoco.mj_forward(model, data)
        tau_f[k] = -data.qfrc_passive - data.qfrc_constraint
    return q, v, tau_f


def write_rollouts(run, model, substeps):
    """RUN/external/NAME/*.h5, one per line of starts.csv. Returns seconds."""
    begin = time.monotonic()
    folder = run / "external" / NAME
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.h5"):
        old.unlink()
    with open(run / "starts.csv") as file:
        for start in csv.DictReader(file):
            recording = read_recording(run / "data" / (start["trajectory"] + ".h5"))
            rows = slice(int(start["begin"]), int(start["begin"]) + int(start["rows"]))
            q0, v0 = (np.array([float(x) for key, x in start.items() if key[0] == signal]) for signal in "qv")
            q, v, tau_f = roll_out(model, q0, v0, recording.tau[rows], substeps)
            with h5py.File(folder / (start["rollout"] + ".h5"), "w") as out:
                out.attrs["format"] = "fricid.rollout/1"
                out["t"], out["q"], out["v"], out["tau_f"] = recording.t[rows], q, v, tau_f
    return time.monotonic() - begin


def predict(options, model):
    """OUT/RECORDING.csv: t, torque and the friction in it along the measured motion [N m]; frictionloss is the
    torque against the motion that it bounds."""
    dry = model.dof_frictionloss.copy()
    model.dof_frictionloss[:] = 0
    data = mujoco.MjData(model)
    options.predict.mkdir(parents=True, exist_ok=True)
    for path in sorted((options.run / "predictions").glob("simple_s1_*.h5")):
        with h5py.File(path) as file:
            t, q, v = file["t"][:], file["q"][:], file["v"][:]
        a = np.gradient(v, t, axis=0)
        tau_f = np.empty_like(v)
        tau = np.empty_like(v)
        for k in range(len(t)):
            data.qpos[:], data.qvel[:], data.qacc[:] = q[k], v[k], a[k]
            mujoco.mj_inverse(model, data)
            tau_f[k] = dry * np.sign(v[k]) - data.qfrc_passive
            tau[k] = data.qfrc_inverse + dry * np.sign(v[k])
        header = ",".join(["t", *(f"{kind}{j + 1}" for kind in ("tau_predicted", "tau_f") for j in range(model.nv))])
        np.savetxt(options.predict / f"{path.stem.removeprefix('simple_s1_')}.csv", np.hstack([t[:, None], tau, tau_f]),
                   delimiter=",", header=header, comments="", fmt="%.9g")


def print_parameters(truth, fitted, half_widths):
    """Every parameter with its 95 % interval; coverage of those that `truth` has."""
    covered = infinite = of = 0
    print(f"{'parameter':<24}{'fitted':>10}{'+-':>10}{'truth':>10}{'off by':>10}")
    for (name, parameter), half in zip(fitted.items(), half_widths):
        value = parameter.value[0]
        line = f"{name:<24}{value:>10.4g}{half:>10.2g}"
        if name in truth:
            true = truth[name].value[0]
            of += 1
            infinite += np.isinf(half)
            covered += np.isfinite(half) and abs(value - true) <= half
            line += f"{true:>10.4g}{abs(value - true) / half:>10.1f} half widths, x {value / true:.4g}"
        print(line)
    print(f"95 % intervals: {covered} of {of} cover the truth, {infinite} are infinite")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("run", type=pathlib.Path, help="run folder")
    parser.add_argument("--chunks", type=int, default=90, help="pieces of the training data, 90")
    parser.add_argument("--chunk-s", type=float, default=0.5, help="length of each [s], 0.5")
    parser.add_argument("--fit-step-s", type=float, default=0.002, help="time step of the fit [s], 0.002")
    parser.add_argument("--even", action="store_true", help="weigh a joint alike in all chunks")
    parser.add_argument("--max-iters", type=int, default=200, help="of the optimiser, 200")
    parser.add_argument("--mjcf", type=pathlib.Path, help="robot to start from, that of the scene")
    parser.add_argument("--predict", metavar="OUT", type=pathlib.Path,
                        help="write the torque along the motion of RUN/predictions too")
    parser.add_argument("--check", action="store_true", help="only: can it find friction of MuJoCo's own?")
    options = parser.parse_args()
    logging.set_verbosity(logging.ERROR)  # one warning per chunk that the model has no sensors

    scene = tomllib.loads((options.run / "scene.toml").read_text())
    if scene["robot"].get("payload_kg", 0) > 0:
        raise SystemExit(f"{options.run}: the scene has a payload, which this script does not put on")
    recordings = [smoothed(read_recording(path), scene["identify"]["cutoff_hz"])
                  for path in sorted((options.run / "data").glob("train_*.h5"))]
    joints, period = recordings[0].joints, recordings[0].period
    rows, substeps = round(options.chunk_s / period), max(1, round(period / options.fit_step_s))
    mjcf = options.mjcf or ROOT / scene["robot"]["mjcf"]

    begin = time.monotonic()
    spec = make_spec(mjcf, joints, period / substeps)
    start = make_parameters(spec, recordings)
    truth = sysid.ParameterDict({name: parameter for name, parameter in start.copy().items()
                                 if name.startswith(("armature", "mass"))})
    if options.check:
        recordings, truth = with_friction_of_mujoco(spec, start, recordings, rows, substeps)
    fitted, half_widths, chunks = fit(spec, start, recordings, rows, options, substeps)
    seconds = time.monotonic() - begin
    print(f"mujoco {mujoco.__version__}: {fitted.size} parameters from {chunks} chunks of "
          f"{options.chunk_s} s in {seconds:.0f} s")
    print_parameters(truth, fitted, half_widths)
    if options.check:
        return

    step_s = scene["plant"]["step_s"]
    model = sysid.apply_param_modifiers(fitted, make_spec(mjcf, joints, step_s))
    print(f"rollouts in {write_rollouts(options.run, model, round(period / step_s)):.0f} s")
    (options.run / "external" / NAME / "model.json").write_text(json.dumps(
        {"format": "fricid.external/1", "label": "mujoco.sysid", "parameters": int(fitted.size),
         "fit_seconds": round(seconds, 1)}, indent=1) + "\n")
    if options.predict:
        predict(options, model)


if __name__ == "__main__":
    main()
