#!/usr/bin/env python3
"""What the online filter says along the first held-out recording of runs, against the truth: scripts/online.py
RUN[,RUN...] MODEL... prints, per model, the share of samples whose friction and speed lie within their 90 % bands (mean,
and of the least joint) and the error of the friction torque, means over the runs. The estimates stay in RUN/estimates,
which `fricid render RUN plots` draws."""
import argparse
import csv
import math
import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BAND = 1.645      # half a 90 % band in standard deviations
WASH_OUT_S = 2.0  # in which the filter finds the state of friction


def signals(fricid, file):
    """Columns of a file by name."""
    done = subprocess.run([fricid, "info", file, "--csv"], capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(done.stderr)
    rows = csv.reader(done.stdout.splitlines())
    names = next(rows)
    return dict(zip(names, zip(*[[float(value) for value in row] for row in rows])))


def judged(estimate, truth, joint):
    """Of a joint: share of friction, then of speed, within the bands; error and size of the friction torque."""
    at = {round(t, 6): k for k, t in enumerate(truth["t"])}
    rows = [(k, at[round(t, 6)]) for k, t in enumerate(estimate["t"])
            if t - estimate["t"][0] >= WASH_OUT_S and round(t, 6) in at]
    within = {}
    for name in ("tau_f", "v"):
        mean, sd, true = estimate[f"{name}{joint}"], estimate[f"{name}_sd{joint}"], truth[f"{name}{joint}"]
        within[name] = sum(abs(mean[k] - true[i]) < BAND * sd[k] for k, i in rows) / len(rows)
    tau, true = estimate[f"tau_f{joint}"], truth[f"tau_f{joint}"]
    error = sum((tau[k] - true[i]) ** 2 for k, i in rows)
    return within["tau_f"], within["v"], math.sqrt(error / sum(true[i] ** 2 for _, i in rows))


def estimated(fricid, run, model, recording):
    """Rows of `judged`, one per joint."""
    truth = signals(fricid, run / "truth" / f"{recording}.h5")
    file = run / "estimates" / f"{model}_s1_{recording}.h5"
    file.parent.mkdir(exist_ok=True)
    done = subprocess.run([fricid, "estimate", run / "models" / f"{model}_s1.json", run / "data" / f"{recording}.h5",
                           "-o", file, "--quiet"], capture_output=True, text=True)
    if done.returncode == 2:
        raise SystemExit(done.stderr)
    estimate = signals(fricid, file)
    return [judged(estimate, truth, j + 1) for j in range(sum(name.startswith("tau_f") for name in truth))]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", type=lambda text: [Path(run) for run in text.split(",")], metavar="RUN[,RUN...]")
    parser.add_argument("models", nargs="+", metavar="MODEL")
    options = parser.parse_args()
    fricid = os.environ.get("FRICID", ROOT / "build/release/cli/fricid")
    print("| model | friction within its band % | least joint | speed within its band % | friction error % |")
    print("|---|--:|--:|--:|--:|")
    for model in options.models:
        rows = [row for run in options.runs for row in estimated(fricid, run, model, "validation_0")]
        friction, speed, error = (sum(values) / len(rows) for values in zip(*rows))
        print(f"| {model} | {100 * friction:.0f} | {100 * min(row[0] for row in rows):.0f} "
              f"| {100 * speed:.0f} | {100 * error:.2g} |", flush=True)


if __name__ == "__main__":
    main()
