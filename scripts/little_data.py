#!/usr/bin/env python3
"""Open-loop error against the length of the training data, for the lvm, the best conventional law
and the known law: scripts/little_data.py [SCENE...] [--seeds 1-3] [--lengths 5,10,30,60,190] [--prior MODEL]
prints a table per scene and writes it beside the plot into run/little_data. With the model file of another arm
of the same type there is an lvm with that prior too."""
import argparse
import json
import math
import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MODELS = ["simple", "stribeck", "dahl", "lugre", "gms", "lvm", "known_law"]
CURVES = {"oracle": "oracle", "best law": "best_conventional", "known law": "known_law", "lvm": "lvm"}
PRIOR = {"lvm, prior": "lvm_prior"}
COLOURS = ["#888888", "#D55E00", "#009E73", "#0072B2", "#CC79A7"]


def overlay(scene, seconds, prior):
    """The scene with these models on the first `seconds` of its training data, without bands."""
    lines = [f"extends = {json.dumps(str(scene))}", f'name = "{scene.stem}"', "[identify]",
             f"first_s = {seconds}", "[evaluate]", "draws = 0"]
    for name in MODELS:
        lines += ["[[model]]", f'name = "{name}"']
        if name == "known_law":
            lines.append('law = "injected"')
    if prior:
        lines += ["[[model]]", 'name = "lvm_prior"', 'law = "lvm"', f"prior = {json.dumps(str(prior.resolve()))}"]
    return "\n".join(lines) + "\n"


def errors(fricid, scene, seed, seconds, out, jobs, curves, prior):
    """MSE of q [rad^2] per curve and horizon; one folder per seed keeps the data."""
    result = out / f"{scene.stem}_{seed}_{seconds:g}s{'_prior' if prior else ''}.json"
    if not result.exists():
        file = out / f"{scene.stem}_{seed}.toml"
        file.write_text(overlay(scene, seconds, prior))
        folder = out / f"{scene.stem}_{seed}"
        done = subprocess.run([fricid, "run", file, "--seed", str(seed), "-o", folder, "--jobs", str(jobs),
                               "--no-video", "--quiet"], capture_output=True, text=True)
        if done.returncode not in (0, 1):  # 1 is a verdict on the models
            raise SystemExit(done.stderr)
        result.write_bytes((folder / "evaluation.json").read_bytes())
    evaluation = json.loads(result.read_text())
    by_model = {row["name"]: row["q_mse_geometric_mean"] for row in evaluation["summary"]}
    rows = {"oracle": evaluation["oracle"], "best_conventional": evaluation["best_conventional"]}
    return evaluation["horizons_s"], {label: rows.get(key) or by_model[key]
                                      for label, key in curves.items()}


def geometric_mean(values):
    return math.exp(sum(math.log(v) for v in values) / len(values))


def plot(table, horizon_s, curves, file):
    """table: {seconds: {curve: error}}"""
    script = ["set terminal svg size 640,420 font 'sans,12' background '#ffffff'", f"set output '{file}'",
              "set logscale xy", "set format y '10^{%L}'", "set key outside right center",
              "set xlabel 'training data [s]'", f"set ylabel 'MSE of q after {horizon_s:g} s [rad²]'",
              f"set xrange [{min(table) / 1.3:g}:{max(table) * 1.3:g}]", f"set xtics ({', '.join(f'{s:g}' for s in table)})"]
    script.append("plot " + ", ".join(f"'-' with linespoints lw 2 pt 7 lc rgb '{colour}' title '{curve}'"
                                      for curve, colour in zip(curves, COLOURS)))
    for curve in curves:
        script += [f"{seconds} {of[curve]}" for seconds, of in table.items()] + ["e"]
    subprocess.run(["gnuplot"], input="\n".join(script) + "\n", text=True, check=True)


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("scenes", nargs="*", type=Path, default=[ROOT / "scenes/kr6_full.toml"])
    options.add_argument("--seeds", default="1-3")
    options.add_argument("--lengths", default="5,10,30,60,190")
    options.add_argument("--jobs", type=int, default=os.cpu_count())
    options.add_argument("-o", "--output", type=Path, default=Path("run/little_data"))
    options.add_argument("--prior", type=Path, help="RUN/models/lvm_s1.json of another arm of the same type")
    given = options.parse_args()
    if given.prior and not given.prior.is_file():
        options.error(f"--prior {given.prior} is not there")
    curves = CURVES | (PRIOR if given.prior else {})
    fricid = os.environ.get("FRICID_PROGRAM", ROOT / "build/release/cli/fricid")
    first, _, last = given.seeds.partition("-")
    seeds = range(int(first), int(last or first) + 1)
    lengths = [float(s) for s in given.lengths.split(",")]
    out = given.output.resolve()
    out.mkdir(parents=True, exist_ok=True)
    for scene in (path.resolve() for path in given.scenes):
        found = {s: [errors(fricid, scene, seed, s, out, given.jobs, curves, given.prior) for seed in seeds] for s in lengths}
        horizons = found[lengths[0]][0][0]
        quoted = [h for h, seconds in enumerate(horizons) if seconds >= 1]
        text = f"## {scene.stem}, seeds {given.seeds}\n\n| training data |"
        text += "".join(f" {curve} {horizons[h]:.3g} s |" for h in quoted for curve in curves)
        text += "\n|--:|" + "--:|" * (len(quoted) * len(curves)) + "\n"
        table = {}
        for h in quoted:
            table[h] = {s: {curve: geometric_mean([of[curve][h] for _, of in runs]) for curve in curves}
                        for s, runs in found.items()}
        for s in lengths:
            text += f"| {s:g} s |" + "".join(f" {table[h][s][curve]:.1e} |" for h in quoted
                                             for curve in curves) + "\n"
        (out / f"{scene.stem}.md").write_text(text)
        print(text)
        longest = max(h for h in quoted if horizons[h] <= 10)
        plot(table[longest], horizons[longest], curves, out / f"{scene.stem}.svg")


if __name__ == "__main__":
    main()
