"""The table of the real arms from their runs: join.py OUT SCENE...

Per arm, RMSE of the predicted motor torque over all held-out recordings per joint, and the mean squared error of q in open
loop. Behind +- half of a 90 % interval: blocks of one second are drawn again and again from each recording, the same ones for
all models, so that samples that hang together in time are drawn together. Bold: the least error, where the 90 % interval of
the ratio of every other model's error to it, over the same draws, lies above one.

Reads OUT/SCENE (run folders) and OUT/peers/SCENE/TOOL/RECORDING.csv (torques predicted by other tools).
"""
import argparse
import csv
import json
import pathlib

import h5py
import numpy as np

BLOCK_S = 1.0
DRAWS = 2000
TOOLS = {"least_squares": "least squares", "figaroh": "figaroh", "mujoco_sysid": "mujoco.sysid"}


def read_errors(run, peers, models):
    """{model: [(T, n) measured - predicted torque per recording]} [N m], samples per block, joint names"""
    errors, joints, block = {}, None, None
    for name in models:
        for path in sorted((run / "predictions").glob(f"{name}_s*_validation_*.h5")):
            with h5py.File(path) as file:
                errors.setdefault(name, []).append(file["tau"][:] - file["tau_predicted"][:])
                joints, t = list(file.attrs["joint_names"]), file["t"][:]
                block = round(BLOCK_S * (len(t) - 1) / (t[-1] - t[0]))
    for folder in (peers / tool for tool in TOOLS if (peers / tool).is_dir()):
        for path in sorted((run / "predictions").glob("simple_s1_validation_*.h5")):
            table = np.genfromtxt(folder / f"{path.stem.removeprefix('simple_s1_')}.csv", delimiter=",", names=True)
            with h5py.File(path) as file:
                predicted = np.stack([table[f"tau_predicted{j + 1}"] for j in range(len(joints))], 1)
                errors.setdefault(folder.name, []).append(file["tau"][:] - predicted)
    return errors, block, joints


def draw_rmse(errors, block):
    """{model: (rmse (n), drawn rmse (DRAWS, n))} [N m], the same blocks for every model"""
    rng = np.random.default_rng(1)
    lengths = [len(e) for e in next(iter(errors.values()))]
    starts = [rng.integers(T, size=(DRAWS, -(-T // block))) for T in lengths]
    drawn = {}
    for name, recordings in errors.items():
        squares = counts = 0
        for e, begin in zip(recordings, starts):
            known = np.isfinite(e)
            for_all = np.stack([np.where(known, e, 0) ** 2, known])
            # sums over [0, k), around the end
            sums = np.cumsum(np.concatenate([0 * for_all[:, :1], for_all, for_all[:, :block]], 1), 1)
            s, c = (sums[:, begin + block] - sums[:, begin]).sum(2)
            squares, counts = squares + s, counts + c
        e = np.concatenate(recordings)
        drawn[name] = np.sqrt(np.nanmean(e**2, 0)), np.sqrt(squares / counts)
    return drawn


def draw_rollouts(run, horizons):
    """{model: (mse (h), drawn mse (DRAWS, h))} geometric means over starts [rad^2], the same starts for every model"""
    rng = np.random.default_rng(1)
    logs = {}
    with open(run / "table.csv") as file:
        for row in csv.DictReader(file):
            key = row["trajectory"], float(row["start_s"]), row["seed"]
            logs.setdefault(row["model"], {}).setdefault(key, {})[float(row["horizon_s"])] = np.log(float(row["q_mse"]))
    tables = {name: np.array([[starts[key][h] for h in horizons] for key in sorted(starts)]) for name, starts in logs.items()}
    count = len(next(iter(tables.values())))
    chosen = rng.integers(count, size=(DRAWS, count))
    return {name: (np.exp(x.mean(0)), np.exp(x[chosen].mean(1))) for name, x in tables.items()}


def is_first(drawn, name, column):
    """@return whether every other model errs more, beyond the interval of the ratio; equal models are one"""
    _, mine = drawn[name]
    for other, (value, theirs) in drawn.items():
        same = np.allclose(theirs[:, column], mine[:, column], rtol=1e-6)
        if other != name and not same and np.quantile(theirs[:, column] / mine[:, column], 0.05) <= 1:
            return False
    return True


def ratio(drawn, ours, column):
    """Error of `ours` over that of the best other model with its 90 % interval, as text"""
    others = [name for name in drawn if name != ours]
    best = min(others, key=lambda name: drawn[name][0][column])
    draws = drawn[ours][1][:, column] / drawn[best][1][:, column]
    low, high = np.quantile(draws, [0.05, 0.95])
    return f"{drawn[ours][0][column] / drawn[best][0][column]:.2f} [{low:.2f}, {high:.2f}]"


def arm(out, scene):
    run = out / scene
    evaluation = json.loads((run / "evaluation.json").read_text())
    manifest = json.loads((run / "manifest.json").read_text())
    summary = {model["name"]: model for model in evaluation["summary"]}
    errors, block, joints = read_errors(run, out / "peers" / scene, summary)
    horizons = [h for h in evaluation["horizons_s"] if 0 < h <= 1]
    torque, rollouts = draw_rmse(errors, block), draw_rollouts(run, horizons)
    seconds = sum(len(e) for e in errors["simple"]) / block * BLOCK_S
    lines = [f"## {scene}: RMSE of the torque [N m] over {seconds:.3g} s of held-out motion; MSE(q) in open loop [rad²]", "",
             f"Commit {manifest['commit']}, {manifest['machine']['cpu']}.", "",
             "| model | " + " | ".join([*joints, *(f"{h:g} s" for h in horizons)]) + " |",
             "|---|" + "--:|" * (len(joints) + len(horizons))]
    for name in errors:
        label = TOOLS.get(name, name) + (" (not to be trusted)" if summary.get(name, {}).get("doubts") else "")
        cells = []
        for j in range(len(joints)):
            value, draws = torque[name][0][j], torque[name][1][:, j]
            half = np.subtract(*np.quantile(draws, [0.95, 0.05])) / 2
            text = f"{value:.3g}"
            lead = min(torque, key=lambda other: torque[other][0][j])
            if torque[lead][0][j] >= value * (1 - 1e-6) and is_first(torque, name, j):
                text = f"**{text}**"
            cells.append(f"{text} ± {float(f'{half:.1g}'):g}")
        for h in range(len(horizons)):
            if name not in rollouts:
                cells.append("–")
                continue
            value = rollouts[name][0][h]
            first = value <= min(other[0][h] for other in rollouts.values()) * (1 + 1e-6) and is_first(rollouts, name, h)
            text = f"{value:.1e}".replace("e-0", "e-")
            cells.append(f"**{text}**" if first else text)
        lines.append(f"| {label} | {' | '.join(cells)} |")
    if "lvm" in torque:
        cells = [ratio(torque, "lvm", j) for j in range(len(joints))] + [ratio(rollouts, "lvm", h) for h in range(len(horizons))]
        lines.append(f"| lvm / best other | {' | '.join(cells)} |")
    doubts = [f"- {name}: {doubt}" for name, model in summary.items() for doubt in model["doubts"]]
    return "\n".join([*lines, "", *(["Not to be trusted:", "", *doubts, ""] if doubts else [])])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("scenes", nargs="+")
    options = parser.parse_args()
    print("\n".join(arm(options.out, scene) for scene in options.scenes))


if __name__ == "__main__":
    main()
