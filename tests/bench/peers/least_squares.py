"""Independent least squares on the training data of a run, beside its model "simple".

Regressor and model by Pinocchio, filter by SciPy, the rest in NumPy; nothing of fricid but the data (through
`fricid info --csv`), the URDF and the fit to compare with. Per joint j, over the samples that slide,

    tau = Y(q, v, a) pi + I_m a_j + Fc_j sign(v_j) + Fv_j v_j + offset_j

in base parameters (columns by pivoted QR), weighted by one residual deviation per joint, iterated. Exit 1 when
Fc or Fv of a joint differ by more than --within and by more than two standard errors of either; 77 when Pinocchio
cannot be imported.
"""
import argparse
import csv
import io
import json
import pathlib
import subprocess
import sys
import tomllib

try:
    import numpy as np
    import pinocchio
    import scipy.linalg
    import scipy.signal
except ImportError as missing:
    print(f"SKIPPED: {missing}; tests/bench/peers/least_squares.sh makes the environment")
    sys.exit(77)

SLIDES = 0.1       # rad/s, least speed of a row
SHARE = 0.15       # of the joint's own speed (95 %), where that is less
MEMORY = 2.5       # periods of the cut-off left out around standstill and reversal
EVERY = 0.25       # periods of the cut-off between two equations
ITERATIONS = 10


def table(program, file):
    text = subprocess.run([program, "info", file, "--csv"], check=True, capture_output=True, text=True).stdout
    rows = list(csv.reader(io.StringIO(text)))
    return rows[0], np.array(rows[1:], float)


def filtered(x, cutoff, rate):
    # two passes of a low pass of order 2: order 4 in all, without phase
    sos = scipy.signal.butter(2, cutoff / (rate / 2), output="sos")
    return scipy.signal.sosfiltfilt(sos, x, axis=0)


def signals(program, file, joints, cutoff):
    names, data = table(program, file)
    column = {name: data[:, i] for i, name in enumerate(names)}
    t = column["t"]
    dt = (t[-1] - t[0]) / (len(t) - 1)
    pick = lambda kind: np.stack([column[f"{kind}{j + 1}"] for j in range(joints)], 1)
    q, tau = pick("q"), pick("tau")
    held = tau.copy()
    held[1:] = (tau[1:] + tau[:-1]) / 2
    q = filtered(q, cutoff, 1 / dt)
    v = np.gradient(q, dt, axis=0)
    a = np.zeros_like(q)
    a[1:-1] = (q[2:] - 2 * q[1:-1] + q[:-2]) / dt**2
    return dt, q, v, a, filtered(held, cutoff, 1 / dt)


def equations(model, sequences, cutoff, reach):
    """Rows, right sides and joints of the samples that slide."""
    n, p = model.nv, 10 * (model.njoints - 1)
    data = model.createData()
    rows, right, of = [], [], []
    for dt, q, v, a, tau in sequences:
        wait = int(round(MEMORY / cutoff / dt))
        edge = max(wait, int(round(2 / cutoff / dt)))
        turns = (v[1:] * v[:-1] <= 0) | (np.abs(v[1:]) < 0.1 * reach)
        for k in range(edge, len(q) - edge, max(1, int(round(EVERY / cutoff / dt)))):
            slides = (np.abs(v[k]) > reach) & ~turns[k - wait:k + wait].any(0)
            if not slides.any():
                continue
            Y = pinocchio.computeJointTorqueRegressor(model, data, q[k], v[k], a[k])
            for j in np.nonzero(slides)[0]:
                x = np.zeros(p + 4 * n)
                x[:p] = Y[j]
                x[p + j], x[p + n + j], x[p + 2 * n + j], x[p + 3 * n + j] = a[k, j], np.sign(v[k, j]), v[k, j], 1
                rows.append(x), right.append(tau[k, j]), of.append(j)
    return np.array(rows), np.array(right), np.array(of)


def solve(X, y, of, n):
    """Iterated weighted least squares in columns that the data tell apart. @return x, standard error"""
    friction = X.shape[1] - 3 * n
    scale = np.linalg.norm(X, axis=0)
    used = np.nonzero(scale > 1e-9 * scale.max())[0]
    _, R, order = scipy.linalg.qr(X[:, used[used < friction]] / scale[used[used < friction]], mode="economic",
                                  pivoting=True)
    diagonal = np.abs(np.diag(R))
    base = used[used < friction][np.sort(order[:np.sum(diagonal > 1e-7 * diagonal[0])])]
    columns = np.concatenate([base, used[used >= friction]])
    sigma = np.full(n, 1.0)
    for _ in range(ITERATIONS):
        w = 1 / sigma[of]
        Q, R = np.linalg.qr(X[:, columns] / scale[columns] * w[:, None])
        x = np.linalg.solve(R, Q.T @ (y * w))
        e = y - X[:, columns] / scale[columns] @ x
        spent = 1 - len(columns) / len(y)
        sigma = np.array([np.sqrt(np.mean(e[of == j] ** 2) / spent) if (of == j).any() else 1 for j in range(n)])
    inverse = np.linalg.inv(R)
    out, error = np.full(X.shape[1], np.nan), np.full(X.shape[1], np.nan)
    out[columns] = x / scale[columns]
    error[columns] = np.sqrt((inverse**2).sum(1)) / scale[columns]
    return out[friction:friction + 2 * n], error[friction:friction + 2 * n]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=pathlib.Path, help="run folder with a model simple, seed 1")
    parser.add_argument("urdf", type=pathlib.Path, help="its robot")
    parser.add_argument("--program", default="build/release/cli/fricid")
    parser.add_argument("--within", type=float, default=0.03, help="allowed relative difference")
    parser.add_argument("--row", metavar="NAME", help="print a row of the table of docs/benchmark.md instead")
    options = parser.parse_args()

    scene = tomllib.loads((options.run / "scene.toml").read_text())
    cutoff = scene["identify"]["cutoff_hz"]
    model = pinocchio.buildModelFromUrdf(str(options.urdf))
    model.gravity.linear = np.array([0, 0, {"floor": -9.81, "ceiling": 9.81}[scene["robot"]["mount"]]])
    fit = json.loads((options.run / "fit/simple_s1.json").read_text())
    joints = [joint["joint"] for joint in fit["joints"]]
    assert joints == list(model.names)[1:], f"joints {joints} in the fit, {list(model.names)[1:]} in the URDF"
    n = len(joints)
    sequences = [signals(options.program, file, n, cutoff) for file in sorted((options.run / "data").glob("train_*.h5"))]
    speed = np.concatenate([s[2] for s in sequences])
    reach = np.minimum(SLIDES, SHARE * np.quantile(np.abs(speed), 0.95, axis=0))
    X, y, of = equations(model, sequences, cutoff, reach)
    value, error = solve(X, y, of, n)

    good, lines, cells = True, [], []
    for j, joint in enumerate(fit["joints"]):
        found = {p["symbol"]: p for p in joint["parameters"]}
        cells.append([])
        for i, symbol in ((j, "Fc"), (n + j, "Fv")):
            theirs, se = found[symbol]["value"], found[symbol]["standard_error"]
            off = abs(theirs - value[i])
            near = off <= options.within * abs(value[i]) or off <= 2 * max(se, error[i])
            good = good and near
            percent = f"{100 * off / abs(value[i]):.2f}"
            cells[-1].append(percent if near else f"**{percent}**")
            lines.append(f"{joints[j]:<12} {symbol:<3} {theirs:>11.4f} +- {se:<6.2g} {value[i]:>11.4f} +- {error[i]:<6.2g}"
                         f" {percent:>8} %{'' if near else '  TOO FAR'}")
    if options.row:
        print(f"| {options.row} | {' | '.join(', '.join(cell) for cell in cells)} |")
    else:
        print(f"{len(y)} equations; fricid simple and this least squares, standard errors behind +-")
        print(f"{'joint':<12} {'':<3} {'fricid':>20} {'least squares':>20} {'differ by':>10}")
        print("\n".join(lines))
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
