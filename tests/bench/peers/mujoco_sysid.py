"""mujoco.sysid in the table of a fricid run: fits on its training data, rolls out, leaves the rollouts.

Reads scene.toml and data/train_*.h5 of the run, and of its held-out data the torque and the starts that
`fricid evaluate` wrote to starts.csv; truth/ is not opened. Fits frictionloss, damping and armature of
every joint and the mass of every link over chunks spread evenly over the training data, prints them with
the intervals that mujoco.sysid states, and writes external/mujoco_sysid.

What it is given, so that the row is about the model: the initial state of each chunk from the zero-phase
filter that fricid uses; a torque held over each sample, which mujoco.sysid would interpolate; the truth's
time step in the rollouts; and the rigid body of the MJCF, here the true one, as its start.
"""
import argparse
import csv
import json
import pathlib
import time
import tomllib

import h5py
import mujoco
import mujoco.rollout
import numpy as np
import scipy.signal
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


def read_data(path):
    """t (T) [s], q (T, n) [rad], held tau (T, n) [N m], joint names."""
    with h5py.File(path) as file:
        return file["t"][:], file["q"][:], hold(file["tau"][:]), list(file.attrs["joint_names"])


def filtered(q, rate_hz, cutoff_hz):
    """Position by a zero-phase Butterworth filter of order 4, velocity by central differences."""
    for column in q.T:
        known = np.isfinite(column)
        column[~known] = np.interp(np.flatnonzero(~known), np.flatnonzero(known), column[known])
    sections = scipy.signal.butter(4, cutoff_hz, fs=rate_hz, output="sos")
    q = scipy.signal.sosfiltfilt(sections, q, axis=0)
    return q, np.gradient(q, 1 / rate_hz, axis=0)


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


def make_parameters(spec, joints):
    """frictionloss and damping from a share of the effort, armature and mass from those of the model."""
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

    def on_body(name):
        return lambda spec, parameter: setattr(spec.body(name), "mass", float(parameter.value[0]))

    for name in joints:
        joint = spec.joint(name)
        effort = float(joint.actfrcrange[1])
        add(f"frictionloss {name}", 0.05 * effort, 0.0, 0.5 * effort, on_joint("frictionloss", name))
        add(f"damping {name}", 0.02 * effort, 0.0, 0.5 * effort, on_joint("damping", name))
        add(f"armature {name}", joint.armature, 0.1 * joint.armature, 10 * joint.armature,
            on_joint("armature", name))
    for name in joints:
        body = spec.joint(name).parent
        add(f"mass {body.name}", body.mass, 0.1 * body.mass, 10 * body.mass, on_body(body.name))
    return parameters


def make_chunks(spec, recordings, chunk_s, count, cutoff_hz, substeps):
    """`count` chunks without a missing sample, spread evenly over the recordings, each from its filtered state."""
    model = spec.compile()
    step = model.opt.timestep
    period = substeps * step
    rows = round(chunk_s / period)
    joints = recordings[0][3]
    starts = [(i, k) for i, (t, q, _, _) in enumerate(recordings)
              for k in range(0, len(t) - rows - 1, rows) if np.isfinite(q[k:k + rows + 1]).all()]
    picked = [starts[i] for i in np.linspace(0, len(starts) - 1, min(count, len(starts))).astype(int)]
    smooth = [filtered(q.copy(), 1 / period, cutoff_hz) for _, q, _, _ in recordings]
    names, states, controls, sensors = [], [], [], []
    for i, k in picked:
        t, q, tau, _ = recordings[i]
        names.append(f"train_{i} at {t[k]:.3f} s")
        states.append(sysid.create_initial_state(model, smooth[i][0][k], smooth[i][1][k]))
        held = np.repeat(tau[k:k + rows], substeps, axis=0)
        held = np.vstack([held, held[-1:]])
        controls.append(sysid.TimeSeries.from_control_names(step * np.arange(len(held)), held, model))
        sensors.append(sysid.TimeSeries.from_names(
            period * np.arange(rows + 1), q[k:k + rows + 1], model,
            [(f"{name}_qpos", sysid.SignalType.MjStateQPos) for name in joints]))
    return sysid.ModelSequences(NAME, spec, names, states, controls, sensors, allow_missing_sensors=True)


def fit(spec, recordings, options, cutoff_hz, substeps):
    """Fitted parameters and their 95 % half widths as mujoco.sysid states them."""
    parameters = make_parameters(spec, recordings[0][3])
    chunks = make_chunks(spec, recordings, options.chunk_s, options.chunks, cutoff_hz, substeps)
    residual = sysid.build_residual_fn(models_sequences=[chunks])
    fitted, result = sysid.optimize(parameters, residual, optimizer="mujoco", max_iters=options.max_iters)
    residuals, _, _ = residual(fitted.as_vector(), fitted)
    _, half_widths = sysid.calculate_intervals(residuals, result.jac)
    return parameters, fitted, half_widths, len(chunks.control)


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
            t, _, tau, _ = read_data(run / "data" / (start["trajectory"] + ".h5"))
            first, rows = int(start["begin"]), int(start["rows"])
            q0, v0 = (np.array([float(x) for key, x in start.items() if key[0] == signal]) for signal in "qv")
            q, v, tau_f = roll_out(model, q0, v0, tau[first:first + rows], substeps)
            with h5py.File(folder / (start["rollout"] + ".h5"), "w") as out:
                out.attrs["format"] = "fricid.rollout/1"
                out["t"], out["q"], out["v"], out["tau_f"] = t[first:first + rows], q, v, tau_f
    return time.monotonic() - begin


def print_parameters(start, fitted, half_widths):
    """Every parameter with its 95 % interval; armature and mass start at the truth."""
    covered = infinite = of = 0
    print(f"{'parameter':<24}{'fitted':>10}{'+-':>10}{'truth':>10}{'off by':>10}")
    for (name, parameter), half, true in zip(fitted.items(), half_widths, start.as_vector()):
        value = parameter.value[0]
        line = f"{name:<24}{value:>10.4g}{half:>10.2g}"
        if name.startswith(("armature", "mass")):
            of += 1
            infinite += np.isinf(half)
            covered += np.isfinite(half) and abs(value - true) <= half
            line += f"{true:>10.4g}{abs(value - true) / half:>10.1f} half widths, x {value / true:.2f}"
        print(line)
    print(f"95 % intervals of armature and mass: {covered} of {of} cover the truth, {infinite} are infinite")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("run", type=pathlib.Path, help="run folder")
    parser.add_argument("--chunks", type=int, default=90, help="pieces of the training data, 90")
    parser.add_argument("--chunk-s", type=float, default=0.5, help="length of each [s], 0.5")
    parser.add_argument("--fit-step-s", type=float, default=0.002, help="time step of the fit [s], 0.002")
    parser.add_argument("--max-iters", type=int, default=200, help="of the optimiser, 200")
    options = parser.parse_args()

    scene = tomllib.loads((options.run / "scene.toml").read_text())
    if scene["robot"].get("payload_kg", 0) > 0:
        raise SystemExit(f"{options.run}: the scene has a payload, which this script does not put on")
    recordings = [read_data(p) for p in sorted((options.run / "data").glob("train_*.h5"))]
    t, _, _, joints = recordings[0]
    period = t[1] - t[0]
    mjcf = ROOT / scene["robot"]["mjcf"]

    begin = time.monotonic()
    spec = make_spec(mjcf, joints, options.fit_step_s)
    start, fitted, half_widths, chunks = fit(
        spec, recordings, options, scene["identify"]["cutoff_hz"], round(period / options.fit_step_s))
    seconds = time.monotonic() - begin
    print(f"mujoco {mujoco.__version__}: {fitted.size} parameters from {chunks} chunks of "
          f"{options.chunk_s} s in {seconds:.0f} s")
    print_parameters(start, fitted, half_widths)

    step_s = scene["plant"]["step_s"]
    model = sysid.apply_param_modifiers(fitted, make_spec(mjcf, joints, step_s))
    print(f"rollouts in {write_rollouts(options.run, model, round(period / step_s)):.0f} s")
    (options.run / "external" / NAME / "model.json").write_text(json.dumps(
        {"format": "fricid.external/1", "label": "mujoco.sysid", "parameters": int(fitted.size),
         "fit_seconds": round(seconds, 1)}, indent=1) + "\n")


if __name__ == "__main__":
    main()
