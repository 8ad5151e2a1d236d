"""Independent least squares on the training data of a run, beside its model "simple".

Regressor and model by Pinocchio, filter by SciPy, the rest in NumPy; nothing of fricid but the data (through
`fricid info --csv`), the URDF and the fit to compare with. Per joint j, over the samples that slide,

    tau = Y(q, v, a) pi + I_m a_j + Fc_j sign(v_j) + Fv_j v_j + offset_j

in base parameters (columns by pivoted QR), weighted by one residual deviation per joint, iterated. Exit 1 when
Fc or Fv of a joint differ by more than --within and by more than two standard errors of either; 77 when Pinocchio
cannot be imported. With --predict nothing is compared: the torque that it predicts along the measured motion of
held-out data goes into files. Terms that are linear in their coefficients ([[robot.torque]]) are fitted too.
"""
import argparse
import csv
import io
import json
import pathlib
import re
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
EXACT = 1e-7       # columns that differ by less are one
PREDICTS = 1e-3    # or, for predictions, that noise would tell apart


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


TERMS = {"q": lambda q: q, "sin(q)": np.sin, "cos(q)": np.cos}  # of [[robot.torque]]; 1 is the offset


def build_model(urdf, mount):
    """Joints that turn without end have one coordinate here, as in the logs."""
    text = re.sub('type="continuous"', 'type="revolute"', urdf.read_text())
    text = re.sub("<limit (?![^>]*lower)", '<limit lower="-100" upper="100" ', text)
    model = pinocchio.buildModelFromXML(text)
    model.gravity.linear = np.array([0, 0, {"floor": -9.81, "ceiling": 9.81}[mount]])
    return model


def columns_of(model, data, terms, q, v, a):
    """(n, p + 4 n + terms): tau = X x at one sample; sign(0) = 0"""
    n = model.nv
    torques = np.zeros((n, len(terms)))
    for i, (j, term) in enumerate(terms):
        torques[j, i] = TERMS[term](q[j])
    return np.hstack([pinocchio.computeJointTorqueRegressor(model, data, q, v, a), torques, np.diag(a),
                      np.diag(np.sign(v)), np.diag(v), np.eye(n)])


def equations(model, terms, sequences, cutoff, reach):
    """Rows, right sides and joints of the samples that slide."""
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
            X = columns_of(model, data, terms, q[k], v[k], a[k])
            for j in np.nonzero(slides)[0]:
                rows.append(X[j]), right.append(tau[k, j]), of.append(j)
    return np.array(rows), np.array(right), np.array(of)


def solve(X, y, of, n, apart):
    """Iterated weighted least squares in columns whose part that no other column explains is above `apart`.
    @return x, standard error"""
    scale = np.linalg.norm(X, axis=0)
    used = np.nonzero(scale > 1e-9 * scale.max())[0]
    # offsets last: of a joint that only ever turned one way Fc stands for both
    weight = np.where(used < X.shape[1] - n, 1, 0.5) / scale[used]
    _, R, order = scipy.linalg.qr(X[:, used] * weight, mode="economic", pivoting=True)
    diagonal = np.abs(np.diag(R))
    columns = used[np.sort(order[:np.sum(diagonal > apart * diagonal[0])])]
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
    return out, error


def write_prediction(folder, file, t, tau, tau_f):
    """FOLDER/RECORDING.csv: t, predicted torque and the friction in it [N m]; `file` of RUN/predictions names the recording"""
    folder.mkdir(parents=True, exist_ok=True)
    header = ",".join(["t", *(f"{kind}{j + 1}" for kind in ("tau_predicted", "tau_f") for j in range(tau.shape[1]))])
    np.savetxt(folder / f"{file.stem.removeprefix('simple_s1_')}.csv", np.hstack([t[:, None], tau, tau_f]), delimiter=",",
               header=header, comments="", fmt="%.9g")


def predict(options, model, terms, x):
    """The torque along the motion of RUN/predictions."""
    n, data, x = model.nv, model.createData(), np.nan_to_num(x)
    for file in sorted((options.run / "predictions").glob("simple_s1_*.h5")):
        names, values = table(options.program, file)
        pick = lambda kind: values[:, [names.index(f"{kind}{j + 1}") for j in range(n)]]
        t, q, v = values[:, names.index("t")], pick("q"), pick("v")
        a = np.gradient(v, t, axis=0)
        tau = np.array([columns_of(model, data, terms, *sample) @ x for sample in zip(q, v, a)])
        tau_f = x[-3 * n:-2 * n] * np.sign(v) + x[-2 * n:-n] * v + x[-n:]
        write_prediction(options.predict, file, t, tau, tau_f)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=pathlib.Path, help="run folder with a model simple, seed 1")
    parser.add_argument("urdf", type=pathlib.Path, help="its robot")
    parser.add_argument("--program", default="build/release/cli/fricid")
    parser.add_argument("--within", type=float, default=0.03, help="allowed relative difference")
    parser.add_argument("--predict", metavar="OUT", type=pathlib.Path, help="write predicted torques instead")
    parser.add_argument("--row", metavar="NAME", help="print a row of the table of docs/benchmark.md instead")
    options = parser.parse_args()

    scene = tomllib.loads((options.run / "scene.toml").read_text())
    cutoff = scene["identify"]["cutoff_hz"]
    model = build_model(options.urdf, scene["robot"]["mount"])
    fit = json.loads((options.run / "fit/simple_s1.json").read_text())
    joints = [joint["joint"] for joint in fit["joints"]]
    assert joints == list(model.names)[1:], f"joints {joints} in the fit, {list(model.names)[1:]} in the URDF"
    n = len(joints)
    sequences = [signals(options.program, file, n, cutoff) for file in sorted((options.run / "data").glob("train_*.h5"))]
    speed = np.concatenate([s[2] for s in sequences])
    reach = np.minimum(SLIDES, SHARE * np.quantile(np.abs(speed), 0.95, axis=0))
    terms = [(joints.index(torque["joint"]), term) for torque in scene["robot"].get("torque", [])
             for term in torque["terms"] if term != "1"]
    X, y, of = equations(model, terms, sequences, cutoff, reach)
    x, error = solve(X, y, of, n, PREDICTS if options.predict else EXACT)
    if options.predict:
        predict(options, model, terms, x)
        return 0
    value, error = x[-3 * n:-n], error[-3 * n:-n]

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
