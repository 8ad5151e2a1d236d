"""What the columns of the Kinova Gen3's logs are: gen3_logs.py DIR, in the environment of least_squares.sh

1. Clock: travel over the integral of the logged velocity, in windows of 0.2 s; 1 where both know the same time.
2. Torque: one linear least squares for the 10 n inertial parameters of the arm, over all recordings, to a column of torque along a
   motion, as commanded or as measured, and what is left per joint. A sensor behind the gear leaves its noise; a torque that was
   computed from the commanded motion leaves nothing along that.
"""
import csv
import pathlib
import sys

import numpy as np

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "tests/bench/peers"))
from least_squares import build_model, pinocchio

# the last one's commands are not all there
LOGS = ["RecordTrajectory_quadratic", "RunTrajectory1", *(f"joint_{j}_trapez" for j in range(1, 5)), "opti_traj_testing1"]
COMMANDED = [log for log in LOGS if log.startswith(("Record", "joint"))]
EVERY = 10  # samples of 1 ms
WINDOW = 200
LEAST_RAD = 0.03  # travel of a window that counts


def read(path, n):
    with open(path) as file:
        names, *values = csv.reader(file)
    values = np.array(values, float)
    return lambda kind: values[:, [names.index(f"{kind}{j + 1}") for j in range(n)]]


folder = pathlib.Path(sys.argv[1]) / "kinova_gen3_2024"
model = build_model(folder / "kinovaGen3.urdf", "floor")
data = model.createData()
logs = {log: read(folder / f"{log}.csv", model.nv) for log in LOGS}

print("| travel / integral of velocity | least | mean | most |")
print("|---|--:|--:|--:|")
for log, pick in logs.items():
    q, v = pick("Position"), pick("Velocity")
    ratios = []
    for k in range(0, len(q) - WINDOW, WINDOW):
        travel = q[k + WINDOW] - q[k]
        integral = np.trapezoid(v[k:k + WINDOW + 1], dx=1e-3, axis=0)
        if integral @ integral > LEAST_RAD**2:
            ratios.append(travel @ integral / (integral @ integral))
    print(f"| {log} | {min(ratios):.3f} | {np.mean(ratios):.3f} | {max(ratios):.3f} |")

print()
print("| left, RMS [N m] | " + " | ".join(list(model.names)[1:]) + " |")
print("|---|" + "--:|" * model.nv)
motions = {"commanded": ("PositionCmptd", "VelocityCmptd", "AccCmptd"), "measured": ("Position", "Velocity", None)}
for column in ("Torque", "TorqueCur"):
    torque = np.concatenate([logs[log](column)[::EVERY] for log in COMMANDED])
    for name, (position, velocity, acceleration) in motions.items():
        regressors = []
        for pick in (logs[log] for log in COMMANDED):
            a = pick(acceleration) if acceleration else np.gradient(pick(velocity), 1e-3, axis=0)
            samples = zip(pick(position)[::EVERY], pick(velocity)[::EVERY], a[::EVERY])
            regressors += [pinocchio.computeJointTorqueRegressor(model, data, *sample) for sample in samples]
        Y = np.concatenate(regressors)
        left = torque - (Y @ np.linalg.lstsq(Y, torque.ravel(), rcond=1e-9)[0]).reshape(torque.shape)
        print(f"| {column}, motion as {name} | " + " | ".join(f"{rms:.1g}" for rms in np.sqrt((left**2).mean(0))) + " |")
    print(f"| {column} itself | " + " | ".join(f"{rms:.1g}" for rms in np.sqrt((torque**2).mean(0))) + " |")
