"""Writes a long log of the KR 6 as a CSV with its contract: one period of a motion of scenes/kr6_full.toml at
1 kHz, again and again with new noise of the sensors.

    tests/bench/long_log.py SECONDS FOLDER [--program build/release/cli/fricid]
"""
import argparse
import pathlib
import subprocess
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
SCENE = f"""
extends = "{SOURCE}/scenes/kr6_full.toml"
[excitation]
harmonics = 20
base_rad_s = 0.1
train = 1
repeats = %d
validation = 0
restarts = 5
[sensors]
rate_hz = 1000
"""
CONTRACT = """joint_names = ["joint_a1", "joint_a2", "joint_a3", "joint_a4", "joint_a5", "joint_a6"]
[position]
columns = "q{}"
[torque]
columns = "tau{}"
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("seconds", type=float)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--program", default=SOURCE / "build/release/cli/fricid")
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    (options.folder / "contract.toml").write_text(CONTRACT)
    samples = round(1000 * options.seconds)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "scene.toml").write_text(SCENE % (samples // 62832 + 1))
        subprocess.run([options.program, "simulate", folder / "scene.toml", "-o", folder / "run"], check=True)
        files = sorted((folder / "run/data").glob("train_*.h5"), key=lambda file: int(file.stem.split("_")[1]))
        written = 0
        with open(options.folder / "log.csv", "w") as out:
            for file in files:
                rows = subprocess.run([options.program, "info", file, "--csv"], check=True, capture_output=True,
                                      text=True).stdout.splitlines()
                names = rows[0].split(",")
                time = names.index("t")
                wanted = [i for i, column in enumerate(names) if column[0] == "q" or column.startswith("tau")]
                if written == 0:
                    out.write("t," + ",".join(names[i] for i in wanted) + "\n")
                for row in rows[1:1 + samples - written]:
                    cells = row.split(",")
                    values = ",".join(f"{float(cells[i]):.7f}" for i in wanted)
                    out.write(f"{written / 1000:.3f},{values}\n")
                    written += 1


if __name__ == "__main__":
    main()
