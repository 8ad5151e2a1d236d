#!/usr/bin/env python3
"""The paper's table: scripts/paper.py RUN prints MSE and MAE of q of the seven models over the first 10 s and the
complete trajectory, one rollout each from its first sample, "-" where it fell, beside the paper's own numbers, and
names the paper's figures in RUN/plots. RUN is a run of scenes/kr6_paper3.toml, kr6_paper.toml or kr6_paper_real.toml."""
import argparse
import csv
import math
import sys
from pathlib import Path

# Vantilborgh et al. (2024), table I: MSE and MAE after 10 s, MSE and MAE of the complete trajectory
PAPER = {"simple": (1.97, 0.96, None, None), "stribeck": (0.14, 0.25, 1.15, 0.61), "lugre": (0.027, 0.12, 0.66, 0.42),
         "gms": (0.15, 0.28, 1.43, 0.84), "nn": (0.21, 0.26, 2.29, 1.07), "rnn": (0.039, 0.13, None, None),
         "lvm_paper": (0.024, 0.11, 0.11, 0.22)}
FIRST_S = 10.0
FIGURES = {"error_time": "absolute errors of the open loops", "friction_joint_a1": "friction of axis 1 over its velocity",
           "em": "expectation-maximisation by iteration"}


def rollouts(run):
    """{model: ([MSE, MAE of q], the same of the longest horizon, diverged)} of the first rollout of each model."""
    file = run / "table.csv"
    if not file.is_file():
        raise SystemExit(f"{file}: not found; allowed: a run folder that was evaluated")
    rows = list(csv.DictReader(file.open()))
    seed = {}
    for row in rows:
        seed.setdefault(row["model"], row["seed"])
    trajectory = rows[0]["trajectory"] if rows else ""
    found = {}
    for row in rows:
        if (row["trajectory"], row["seed"], float(row["start_s"])) == (trajectory, seed[row["model"]], 0):
            errors = float(row["q_mse"]), float(row["q_mae"])
            found.setdefault(row["model"], {})[float(row["horizon_s"])] = errors, row["diverged"] == "1"
    return {model: (of.get(FIRST_S, ((math.nan, math.nan), False))[0], *of[max(of)]) for model, of in found.items()}


def cell(value):
    return "-" if value is None or math.isnan(value) else f"{value:.2g}"


def table(found):
    lines = ["| model | MSE 10 s | MAE 10 s | MSE complete | MAE complete | paper: MSE 10 s | MAE 10 s | MSE complete | "
             "MAE complete |", "|---|" + "--:|" * 8]
    for model, (first, complete, fell) in found.items():
        if model not in PAPER and model not in ("oracle", "lvm_paper_start", "lvm_paper_6"):
            continue
        values = (*first, *((None, None) if fell else complete), *PAPER.get(model, (None,) * 4))
        lines.append(f"| {model} | " + " | ".join(map(cell, values)) + " |")
    return "\n".join(lines)


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("run", type=Path)
    run = options.parse_args().run
    print(table(rollouts(run)))
    for name, meaning in FIGURES.items():
        for file in sorted((run / "plots").glob(f"{name}.pdf")):
            print(f"{file}: {meaning}", file=sys.stderr)


if __name__ == "__main__":
    main()
