"""What the columns Torque of the Kinova Gen3's logs are: gen3_torque.py DIR, in the environment of least_squares.sh

Fits the 10 n inertial parameters of the arm, by one linear least squares over all recordings, to a column of torque along a
motion (position, velocity and acceleration as commanded, or as measured) and prints what is left per joint. A sensor behind
the gear leaves its noise; a torque that was computed from the commanded motion leaves nothing along that.
"""
import csv
import pathlib
import sys

import numpy as np

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "tests/bench/peers"))
from least_squares import build_model, pinocchio

LOGS = ["RecordTrajectory_quadratic", "joint_1_trapez", "joint_2_trapez", "joint_3_trapez", "joint_4_trapez"]  # commands all there
EVERY = 10  # samples of 1 ms

folder = pathlib.Path(sys.argv[1]) / "kinova_gen3_2024"
model = build_model(folder / "kinovaGen3.urdf", "floor")
data = model.createData()
rows = {"commanded": [], "measured": []}
right = {"Torque": [], "TorqueCur": []}
for log in LOGS:
    with open(folder / f"{log}.csv") as file:
        names, *values = csv.reader(file)
    values = np.array(values, float)
    pick = lambda kind: values[:, [names.index(f"{kind}{j + 1}") for j in range(model.nv)]]
    measured = [pick("Position"), pick("Velocity"), np.gradient(pick("Velocity"), 1e-3, axis=0)]
    commanded = [pick("PositionCmptd"), pick("VelocityCmptd"), pick("AccCmptd")]
    for name, motion in (("measured", measured), ("commanded", commanded)):
        rows[name] += [pinocchio.computeJointTorqueRegressor(model, data, *sample)
                       for sample in zip(*(signal[::EVERY] for signal in motion))]
    for name in right:
        right[name] += list(pick(name)[::EVERY])

print("| left, RMS [N m] | " + " | ".join(list(model.names)[1:]) + " |")
print("|---|" + "--:|" * model.nv)
for column, torque in right.items():
    torque = np.array(torque)
    for name, regressors in rows.items():
        Y = np.concatenate(regressors)
        x = np.linalg.lstsq(Y, torque.ravel(), rcond=1e-9)[0]
        left = (torque.ravel() - Y @ x).reshape(torque.shape)
        print(f"| {column}, motion as {name} | " + " | ".join(f"{rms:.1g}" for rms in np.sqrt((left**2).mean(0))) + " |")
    print(f"| {column} itself | " + " | ".join(f"{rms:.1g}" for rms in np.sqrt((torque**2).mean(0))) + " |")
