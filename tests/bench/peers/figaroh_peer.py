"""figaroh on the training data of a run: the torque that it predicts along the measured motion of held-out data.

    build/peers_figaroh/bin/python tests/bench/peers/figaroh_peer.py RUN URDF --predict OUT

figaroh's own steps, in the order of its BaseIdentification.solve with weighted least squares: regressor with viscous and static
friction, actuator inertia and offset; columns that stay near zero left out; base parameters by QR, with the relative tolerance of
1e-4 that it advises; least squares; once more with the joints weighted by their residual (Gautier 1997). It gets the filtered motion
and torque that least_squares.py has, at the same times but moving or not, and lacks torques that depend on the pose.
"""
import argparse
import pathlib
import tomllib
import types

import numpy as np
from figaroh.identification.parameter import add_standard_additional_parameters, get_standard_parameters
from figaroh.tools.qrdecomposition import QRDecomposer
from figaroh.tools.regressor import build_regressor_basic, build_regressor_reduced, get_index_eliminate
from least_squares import EVERY, build_model, signals, table, write_prediction

ZERO, APART = 1e-3, 1e-4  # defaults of solve(); advised by its warning of an ill-conditioned regressor


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=pathlib.Path)
    parser.add_argument("urdf", type=pathlib.Path)
    parser.add_argument("--program", default="build/release/cli/fricid")
    parser.add_argument("--predict", metavar="OUT", type=pathlib.Path, required=True)
    options = parser.parse_args()

    scene = tomllib.loads((options.run / "scene.toml").read_text())
    cutoff = scene["identify"]["cutoff_hz"]
    model = build_model(options.urdf, scene["robot"]["mount"])
    robot, n = types.SimpleNamespace(model=model, data=model.createData()), model.nv
    config = {"act_idxv": range(n), "has_friction": True, "has_actuator_inertia": True, "has_joint_offset": True}
    parameters = {**get_standard_parameters(model, config), **add_standard_additional_parameters(model, config)}

    rows = []
    for file in sorted((options.run / "data").glob("train_*.h5")):
        dt, *sampled = signals(options.program, file, n, cutoff)
        edge, every = round(2 / cutoff / dt), max(1, round(EVERY / cutoff / dt))
        rows.append([x[edge:len(x) - edge:every] for x in sampled])
    q, v, a, tau = (np.concatenate(x) for x in zip(*rows))
    regressor = build_regressor_basic(robot, q, v, a, config)  # the samples of joint 1, then those of joint 2 ..
    target = tau.T.ravel()
    unused, names = get_index_eliminate(regressor, parameters, tol_e=ZERO)
    decomposer = QRDecomposer(relative_tolerance=APART)
    base, _, _, x, _ = decomposer.double_decomposition(target, build_regressor_reduced(regressor, unused), names, parameters)
    residual = ((target - base @ x) ** 2).reshape(n, -1).mean(1)
    weight = np.repeat(1 / np.sqrt(residual), len(q))
    x = np.linalg.lstsq(base * weight[:, None], target * weight, rcond=None)[0]

    chosen = [names[k] for k in decomposer.get_base_indices()]
    of_friction = np.array([name.startswith(("fv_", "fs_", "off_")) for name in chosen])
    for file in sorted((options.run / "predictions").glob("simple_s1_*.h5")):
        header, values = table(options.program, file)
        pick = lambda kind: values[:, [header.index(f"{kind}{j + 1}") for j in range(n)]]
        t, q, v = values[:, header.index("t")], pick("q"), pick("v")
        held_out = build_regressor_reduced(build_regressor_basic(robot, q, v, np.gradient(v, t, axis=0), config), unused)
        held_out = held_out[:, decomposer.get_base_indices()]
        write_prediction(options.predict, file, t, (held_out @ x).reshape(n, -1).T,
                         (held_out @ (x * of_friction)).reshape(n, -1).T)


if __name__ == "__main__":
    main()
