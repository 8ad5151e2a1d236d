#!/usr/bin/env python3
"""Attacks the program with hostile and careless input: files damaged by what they are, and options.

    attack.py PROGRAM FOLDER [SECONDS] [SEED] [CASE]

Every case is fixed by SEED and its number; CASE does that one alone and keeps its folder. A case
passes when the program
  - ends with 0, 1, 2 or 130 (3 only where stdout was full or closed),
  - with 2 says why in one line that names a file or an option of the command and shows no control
    characters,
  - changes nothing outside of its output folder and runs nothing that a file said,
  - stays within MEMORY, and within SECONDS_EACH or ends soon after SIGTERM,
  - is quiet for the sanitizers, where it was built with them.
Ends with 1 when a case did not; its folder is kept under FOLDER/failed.
"""
import collections
import hashlib
import json
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time

import damage
import samples

MEMORY = 4 << 30  # [bytes]
LARGEST_FILE = 1 << 30  # [bytes]
SECONDS_EACH, SECONDS_TO_STOP = 20, 15
ALLOWED = (0, 1, 2, 130)
SANITIZERS = ("AddressSanitizer", "LeakSanitizer", "runtime error:")

OPTION_VALUES = [
    "1-5", "1,", "0-2147483647", "5-1", "1,1", "loop", "loop/x", "/dev/null/x", "data.h5", "run",
    "run/plots", "scene.toml", "none", "/proc/self/mem"]
# Commands whose options are damaged: OPTION is a value of OPTION_VALUES.
OPTIONS = [
    ["simulate", "scene.toml", "-o", "out", "--seed", "OPTION"],
    ["run", "scene.toml", "-o", "OPTION"],
    ["run", "OPTION", "-o", "out"],
    ["run", "scene.toml", "-o", "out", "--no-video", "--jobs", "OPTION"],
    ["identify", "run", "--seeds", "OPTION"],
    ["identify", "run", "--model", "OPTION"],
    ["identify", "OPTION", "-o", "out"],
    ["evaluate", "run", "--data", "OPTION"],
    ["evaluate", "OPTION"],
    ["render", "run", "OPTION"],
    ["render", "OPTION", "plots"],
    ["render", "run", "still", "--at", "OPTION", "-o", "out/still.png"],
    ["compare", "run", "OPTION"],
    ["compare", "run", "-o", "OPTION"],
    ["import", "log.csv", "--contract", "OPTION", "-o", "out"],
    ["import", "log.csv", "--contract", "contract.toml", "-o", "OPTION"],
    ["import", "OPTION", "--contract", "contract.toml", "-o", "out"],
    ["import", "log.csv", "--contract", "contract.toml", "--fix", "OPTION", "-o", "out"],
    ["import", "log.csv", "--contract", "contract.toml", "--robot", "OPTION", "-o", "out"],
    ["check", "OPTION"],
    ["check", "log.csv", "--contract", "contract.toml", "--robot", "robot.urdf", "--design",
     "OPTION"],
    ["estimate", "model.json", "data.h5", "--particles", "OPTION", "-o", "out/estimate.h5"],
    ["estimate", "model.json", "data.h5", "--seed", "OPTION", "-o", "out/estimate.h5"],
    ["estimate", "model.json", "data.h5", "-o", "OPTION"],
    ["estimate", "OPTION", "data.h5", "-o", "out/estimate.h5"],
    ["info", "OPTION"],
    ["view", "OPTION", "--screenshot", "out/view.png"],
    ["template", "OPTION"],
    ["OPTION"],
]
# Files that are damaged, how, and the commands that read them.
FILES = [
    ("scene.toml", damage.toml, [["info", "scene.toml"]] * 4 + [
        ["simulate", "scene.toml", "-o", "out"], ["run", "scene.toml", "-o", "out"],
        ["identify", "scene.toml", "-o", "out"]]),
    ("robot.urdf", damage.xml, [
        ["info", "scene.toml"], ["simulate", "scene.toml", "-o", "out"],
        ["check", "log.csv", "--contract", "contract.toml", "--robot", "robot.urdf"]]),
    ("robot.xml", damage.xml, [["simulate", "mjcf.toml", "-o", "out"]]),
    ("contract.toml", damage.toml, [
        ["import", "log.csv", "--contract", "contract.toml", "-o", "out"],
        ["check", "log.csv", "--contract", "contract.toml"]]),
    ("log.csv", damage.csv, [
        ["import", "log.csv", "--contract", "contract.toml", "-o", "out"],
        ["import", "log.csv", "--contract", "contract.toml", "-o", "out", "--fix", "gap"],
        ["check", "log.csv", "--contract", "contract.toml", "--robot", "robot.urdf"]]),
    ("log.mcap", damage.mcap, [["import", "log.mcap", "--contract", "mcap.toml", "-o", "out"]]),
    ("data.h5", damage.hdf5, [
        ["info", "data.h5"], ["info", "data.h5", "--csv"], ["check", "data.h5"],
        ["evaluate", "run", "--data", "data.h5"],
        ["import", "data.h5", "--contract", "contract.toml", "-o", "out"],
        ["estimate", "model.json", "data.h5", "-o", "out/estimate.h5"]]),
    ("model.json", damage.json_file, [
        ["info", "model.json"], ["estimate", "model.json", "data.h5", "-o", "out/estimate.h5"]]),
    ("run/models/simple_s1.json", damage.json_file, [["evaluate", "run"], ["render", "run", "plots"]]),
    ("run/evaluation.json", damage.json_file, [
        ["render", "run", "report"], ["compare", "run"], ["render", "run", "plots"], ["check", "run"]]),
    ("run/manifest.json", damage.json_file, [["evaluate", "run"], ["identify", "run"]]),
    ("run/fit/simple_s1.json", damage.json_file, [["identify", "run"], ["render", "run", "report"]]),
    ("run/excitation.json", damage.json_file, [["render", "run", "report"], ["check", "run"]]),
    ("run/scene.toml", damage.toml, [["evaluate", "run"], ["render", "run", "report"]]),
    ("run/external/twin/model.json", damage.json_file, [["evaluate", "run"]]),
    ("run/external/twin/validation_0_0.h5", damage.hdf5, [["evaluate", "run"]]),
    ("run/data/validation_0.h5", damage.hdf5, [["evaluate", "run"], ["render", "run", "plots"]]),
    ("run/truth/validation_0.h5", damage.hdf5, [["evaluate", "run"], ["render", "run", "plots"]]),
    ("run/rollouts/simple_s1_validation_0.h5", damage.hdf5, [["render", "run", "plots", "report"]]),
]
PRINTING = [["info", "scene.toml"], ["info", "data.h5"], ["info", "model.json"], ["--version"],
            ["info", "data.h5", "--csv"], ["template", "scene"], ["--help"], ["compare", "run"],
            ["check", "data.h5"], ["simulate", "scene.toml", "-o", "out"], ["evaluate", "run"],
            ["estimate", "model.json", "data.h5", "-o", "out/estimate.h5"]]


def damaged_file(rng, folder):
    """Damages one file of the case; gives the command and the path."""
    path, by, commands = rng.choice(FILES)
    file = folder / path
    data = file.read_bytes()
    kind = rng.randrange(20)
    if kind == 0:
        data = None
        file.unlink()
        rng.choice([lambda: None, lambda: file.mkdir(), lambda: file.symlink_to(file.name),
                    lambda: file.symlink_to("/dev/zero"), lambda: file.symlink_to("none")])()
    elif kind < 4:
        data = damage.encoding(rng, data)
    else:
        data = by(rng, data)
    if data is not None:
        file.write_bytes(data)
    if path.startswith("run/") and file.exists() and rng.randrange(2):
        vouch_for(folder / "run", path[4:])
    return rng.choice(commands), path


def vouch_for(run, name):
    """Writes the hash of a changed file into the manifest, as its author could."""
    try:
        text = (run / "manifest.json").read_text()
        for stage in json.loads(text)["stages"]:
            for output in stage["outputs"]:
                if output["name"] == name:
                    new = hashlib.sha256((run / name).read_bytes()).hexdigest()
                    text = text.replace(output["sha256"], new)
        (run / "manifest.json").write_text(text)
    except (OSError, ValueError, KeyError, TypeError):
        return


def snapshot(folder, skip):
    """What lies in a folder but for some of its children: kind, size and content of everything."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder)
        if name.parts[0] in skip:
            continue
        found[str(name)] = (os.readlink(path) if path.is_symlink() else
                            path.read_bytes() if path.is_file() else "folder")
    return found


def limits(sanitized):
    def set_limits():
        if not sanitized:
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST_FILE, LARGEST_FILE))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    return set_limits


def run(program, command, folder, stdout, sanitized):
    """Runs a command to its end; gives its exit code, what it said, and whether it was stopped."""
    environment = os.environ | {
        "HOME": str(folder / "home"), "XDG_CONFIG_HOME": str(folder / "home"),
        "ASAN_OPTIONS": f"hard_rss_limit_mb={MEMORY >> 20}:detect_leaks=0",
        "UBSAN_OPTIONS": "print_stacktrace=1"}
    argv = [os.fsencode(a).replace(b"\0", b"") for a in [program, *command]]
    with open(folder / "stderr", "wb") as errors:
        process = subprocess.Popen(argv, cwd=folder, stdin=subprocess.DEVNULL, stdout=stdout,
                                   stderr=errors, env=environment, preexec_fn=limits(sanitized))
        stopped = False
        try:
            code = process.wait(SECONDS_EACH)
        except subprocess.TimeoutExpired:
            stopped = True
            process.send_signal(signal.SIGTERM)
            try:
                code = process.wait(SECONDS_TO_STOP)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
                code = "did not stop"
    return code, (folder / "stderr").read_bytes(), stopped


def complaint(code, errors, stopped, command, path, folder, hostile_stdout):
    """What is wrong with how a command ended; nothing when nothing is."""
    text = errors.decode("utf-8", "replace")
    for sanitizer in SANITIZERS:
        if sanitizer in text:
            return sanitizer
    if stopped and code == 130:
        return None
    if hostile_stdout and code == 3 and "stdout" in text:
        return None
    if hostile_stdout:
        return f"exit {code} with a full or closed stdout"
    if code not in ALLOWED:
        return f"exit {code}"
    if any(ord(c) < 32 and c != "\n" for c in text):
        return "control characters on stderr"
    said = [line for line in text.splitlines() if line.startswith("fricid: ")]
    if code == 2:
        if len(said) != 1 or not text.endswith("\n") or text.splitlines()[-1] != said[0]:
            return "not one line that says why"
        names = {p.name for p in folder.rglob("*")} | set(command) | {"sample", str(path)}
        names |= {a.strip("-") for a in command if a.startswith("-")}
        shown = said[0].replace("\\", "")
        if "OPTION" not in str(path) and not any(
                re.search(r"(?<!\w)" + re.escape(n.replace("\\", "")) + r"(?!\w)", shown)
                for n in names if n and n not in ("home", "out", command[0])):
            return "the line names no file and no option"
    return None


def one_case(program, base, folder, seed, number, sanitized):
    """Does a case; gives the command, what was damaged and what is wrong."""
    rng = random.Random(f"{seed}:{number}")
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    shutil.copytree(base, folder, symlinks=True)
    (folder / "home").mkdir()
    stdout, hostile_stdout, path = subprocess.DEVNULL, False, ""
    kind = rng.randrange(20)
    if kind == 0:
        command, path, hostile_stdout = rng.choice(PRINTING), "stdout", True
        if rng.randrange(2):
            stdout = open("/dev/full", "wb")
        else:
            read, write = os.pipe()
            os.close(read)
            stdout = os.fdopen(write, "wb")
    elif kind < 5:
        value = rng.choice(damage.NUMBERS + damage.NAMES[:30] + OPTION_VALUES)
        command, path = [value if a == "OPTION" else a for a in rng.choice(OPTIONS)], "OPTION"
    else:
        command, path = damaged_file(rng, folder)
    written = {"out", "stderr"} | ({"run"} if "run" in command[1:2] else set())
    if path == "OPTION":  # it may name the output
        written |= {"run", pathlib.PurePath(value).parts[0] if value.strip("/") else "out"}
        written |= {"estimate.h5", "still.png"} | {f"validation_0.h5", "log.h5"}
    before, around = snapshot(folder, written), sorted(os.listdir(folder.parent))
    code, errors, stopped = run(program, command, folder, stdout, sanitized)
    if stdout is not subprocess.DEVNULL:
        stdout.close()
    wrong = complaint(code, errors, stopped, command, path, folder, hostile_stdout)
    if not wrong and any(p.name.startswith("marker") for p in folder.rglob("*")):
        wrong = "something that a file said was run"
    if not wrong and snapshot(folder, written) != before:
        wrong = "files outside of the output folder changed"
    if not wrong and sorted(os.listdir(folder.parent)) != around:
        wrong = "files beside the case's folder"
    return command, path, code, stopped, wrong


def main():
    program, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    seconds = float(sys.argv[3]) if len(sys.argv) > 3 else 60
    seed = sys.argv[4] if len(sys.argv) > 4 else "1"
    numbers = [int(sys.argv[5])] if len(sys.argv) > 5 else range(10**9)
    with open(program, "rb") as file:
        sanitized = b"__asan_init" in file.read()
    # whatever is written, it is written below our folder
    damage.NAMES[damage.NAMES.index("/abs")] = str(folder / "case" / "abs")
    base = folder / f"good_{program.stat().st_mtime_ns}"
    samples.make(program, base)

    begin, codes, failed = time.monotonic(), collections.Counter(), 0
    for number in numbers:
        if time.monotonic() - begin > seconds:
            break
        case = folder / "case" / "here"
        command, path, code, stopped, wrong = one_case(program, base, case, seed, number, sanitized)
        codes["stopped" if stopped else code] += 1
        if wrong or len(sys.argv) > 5:
            shown = " ".join(a if len(a) < 60 else a[:60] + "..." for a in map(repr, command))
            print(f"case {seed} {number}: {wrong or 'passed'}: {path}: {shown}\n"
                  + (case / "stderr").read_text("utf-8", "replace")[-600:], flush=True)
        if wrong:
            failed += 1
            kept = folder / "failed" / f"{seed}_{number}"
            shutil.rmtree(kept, ignore_errors=True)
            kept.parent.mkdir(exist_ok=True)
            shutil.copytree(case, kept, symlinks=True, ignore_dangling_symlinks=True)
    ended = ", ".join(f"{count} x {code}" for code, count in sorted(codes.items(), key=str))
    print(f"attack: {sum(codes.values())} cases of seed {seed} in "
          f"{time.monotonic() - begin:.0f} s, {failed} failed; ended with {ended}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
