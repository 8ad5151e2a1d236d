#!/usr/bin/env python3
"""Attacks the program with hostile and careless input: files damaged by what they are, and options.

    attack.py PROGRAM FOLDER [SECONDS] [SEED] [CASE]

Every case is fixed by SEED and its number; CASE does that one alone and keeps its folder. A case
passes when the program
  - ends with 0, 1, 2 or 130 (3 only where stdout was full or closed),
  - with 2 says why in one line that names a file or an option of the command,
  - prints no control characters, nor any that do not show,
  - changes nothing outside of its output folder and runs nothing that a file said,
  - stays within MEMORY, and within SECONDS_EACH or ends soon after SIGTERM,
  - is quiet for the sanitizers, where it was built with them.
Some cases run under a poor environment (few descriptors, small files, another locale, no home) or
beside a second command in the same folder.
Ends with 1 when a case did not; its folder is kept under FOLDER/failed.
"""
import collections
import concurrent.futures
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
import manifest
import samples

MEMORY = 4 << 30  # [bytes]
LARGEST_FILE = 1 << 30  # [bytes]
SECONDS_EACH, SECONDS_TO_STOP = 20, 15
ALLOWED = (0, 1, 2, 130)
SMALL_FILES, FEW_DESCRIPTORS = 20_000, 24  # [bytes], [] of a poor environment
HIDDEN = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u200b-\u200f\u202a-\u202e\u2066-\u2069\ufeff]")
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
    ["export", "model.json", "OPTION", "-o", "out"],
    ["export", "OPTION", "c", "-o", "out"],
    ["export", "model.json", "c", "-o", "OPTION"],
    ["render", "run", "still", "-o", "OPTION"],
    ["compare", "run", "other", "-o", "OPTION"],
    ["evaluate", "run", "--data", "other/data/validation_0.h5", "--data", "OPTION"],
    ["check", "data.h5", "--robot", "OPTION"],
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
    ("log.mat", damage.mat, [["import", "log.mat", "--contract", "mat.toml", "-o", "out"]]),
    ("log.db3", damage.db3, [["import", "log.db3", "--contract", "mcap.toml", "-o", "out"]]),
    ("data.h5", damage.hdf5, [
        ["info", "data.h5"], ["info", "data.h5", "--csv"], ["check", "data.h5"],
        ["evaluate", "run", "--data", "data.h5"],
        ["import", "data.h5", "--contract", "contract.toml", "-o", "out"],
        ["estimate", "model.json", "data.h5", "-o", "out/estimate.h5"]]),
    ("model.json", damage.json_file, [
        ["info", "model.json"], ["estimate", "model.json", "data.h5", "-o", "out/estimate.h5"],
        *[["export", "model.json", format, "-o", "out"] for format in ("c", "csv", "urdf", "mjcf")]]),
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
    ("run/predictions/simple_s1_validation_0.h5", damage.hdf5, [["render", "run", "plots"]]),
    ("run/table.md", damage.text, [["evaluate", "run"]]),
    ("run/plots/error_horizon.svg", damage.xml, [["render", "run", "report"]]),
    ("run/plots/error_horizon.gp", damage.text, [["render", "run", "report"]]),
    ("logs/data/train_0.doctor.json", damage.json_file, [["identify", "logs"], ["run", "logs.toml", "-o", "logs"]]),
    ("logs/data/train_0.h5", damage.hdf5, [["identify", "logs"], ["check", "logs"]]),
    ("logs/scene.toml", damage.toml, [["evaluate", "logs"], ["identify", "logs"]]),
]
OF_RUNS = ["run", "logs"]
BESIDE = [["evaluate", "run"], ["render", "run", "plots"], ["identify", "run"], ["render", "run", "report"],
          ["simulate", "scene.toml", "-o", "out"], ["identify", "logs"], ["check", "run"]]
PRINTING = [["info", "scene.toml"], ["info", "data.h5"], ["info", "model.json"], ["--version"],
            ["info", "data.h5", "--csv"], ["template", "scene"], ["--help"], ["compare", "run"],
            ["check", "data.h5"], ["simulate", "scene.toml", "-o", "out"], ["evaluate", "run"],
            ["estimate", "model.json", "data.h5", "-o", "out/estimate.h5"]]


def damaged_file(rng, folder):
    """Damages one file of the case; gives the command and the path."""
    path, by, commands = rng.choice(FILES)
    file = folder / path
    data = file.read_bytes()
    command = rng.choice(commands)
    run, _, name = path.partition("/")
    kind = rng.randrange(24)
    if kind == 0:
        data = None
        file.unlink()
        rng.choice([lambda: None, lambda: file.mkdir(), lambda: file.symlink_to(file.name),
                    lambda: file.symlink_to("/dev/zero"), lambda: file.symlink_to("none"),
                    lambda: os.mkfifo(file)])()
    elif kind < 4:
        data = damage.encoding(rng, data)
    elif kind == 4 and name:  # a good file of another run
        data = (folder / "other" / name).read_bytes() if (folder / "other" / name).exists() else data
    elif kind == 5 and "/" in name:  # a folder that lies elsewhere
        inside = file.parent
        inside.rename(folder / "precious")
        inside.symlink_to(folder / "precious")
    elif kind == 6 and path in command:  # good, by another name
        new = rng.choice(damage.NAMES)[:40].replace("/", "|").replace("\0", "|") + file.suffix
        file = file.rename(folder / new)
        command = [f"./{new}" if a == path else a for a in command]
        path = new
    else:
        data = by(rng, data)
    if data is not None:
        file.write_bytes(data)
    if run in OF_RUNS and name and file.is_file() and rng.randrange(2):
        try:
            manifest.vouch_for(folder / run, name)
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            pass  # the manifest is damaged
    return command, path


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


def poor_environment(rng, folder):
    """Variables, a limit and its value; for most cases none."""
    kind = rng.randrange(40)
    if kind == 0:
        return {"HOME": "/none", "XDG_CONFIG_HOME": "/none"}, None
    if kind == 1:
        return {"LC_ALL": "de_DE.UTF-8", "LANGUAGE": "de"}, None
    if kind == 2:
        return {}, (resource.RLIMIT_FSIZE, SMALL_FILES)
    if kind == 3:
        return {}, (resource.RLIMIT_NOFILE, FEW_DESCRIPTORS)
    if kind == 4:
        return {"HOME": str(folder / "scene.toml"), "TMPDIR": "/none", "TERM": "\x1b[31m"}, None
    return {}, None


def limits(sanitized, limit):
    def set_limits():
        if limit and not sanitized:
            resource.setrlimit(limit[0], (limit[1], limit[1]))
            if limit[0] == resource.RLIMIT_FSIZE:
                return
        if not sanitized:
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_FSIZE, (LARGEST_FILE, LARGEST_FILE))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    return set_limits


def run(program, command, folder, stdout, sanitized, variables, limit, errors="stderr"):
    """Runs a command to its end; gives its exit code, what it said, and whether it was stopped."""
    environment = os.environ | {
        "HOME": str(folder / "home"), "XDG_CONFIG_HOME": str(folder / "home"),
        "ASAN_OPTIONS": f"hard_rss_limit_mb={MEMORY >> 20}:detect_leaks=0",
        "UBSAN_OPTIONS": "print_stacktrace=1"} | variables
    argv = [os.fsencode(a).replace(b"\0", b"") for a in [program, *command]]
    with open(folder / errors, "wb") as stderr:
        process = subprocess.Popen(argv, cwd=folder, stdin=subprocess.DEVNULL, stdout=stdout,
                                   stderr=stderr, env=environment,
                                   preexec_fn=limits(sanitized, limit))
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
    return code, (folder / errors).read_bytes(), stopped


def as_shown(text):
    """A text as the program prints it, escapes without their backslash: "a<newline>b" -> "anb"."""
    for sign, letter in ("\n", "n"), ("\t", "t"), ("\r", "r"):
        text = text.replace(sign, letter)
    def escaped(sign):
        return f"x{ord(sign[0]):02x}" if ord(sign[0]) < 0x80 else f"u{{{ord(sign[0]):04x}}}"
    return HIDDEN.sub(escaped, text).replace("\\", "")


def complaint(code, errors, stopped, command, path, folder, hostile_stdout, poor):
    """What is wrong with how a command ended; nothing when nothing is."""
    text = errors.decode("utf-8", "replace")
    for name in ("stdout", "stderr", "stderr2"):
        if (folder / name).is_file():
            with open(folder / name, "rb") as file:
                if HIDDEN.search(file.read(1 << 22).decode("utf-8", "replace")):
                    return f"characters on {name} that do not show"
    for sanitizer in SANITIZERS:
        if sanitizer in text:
            return sanitizer
    if stopped and code == 130:
        return None
    if hostile_stdout and (code == 3 and "stdout" in text or "another run is writing" in text):
        return None
    if hostile_stdout:
        return f"exit {code} with a full or closed stdout"
    if poor and code == 3 and "fricid: " in text:
        return None
    if code not in ALLOWED:
        return f"exit {code}"
    said = [line for line in text.splitlines() if line.startswith("fricid: ")]
    if code == 2:
        if len(said) != 1 or not text.endswith("\n") or text.splitlines()[-1] != said[0]:
            return "not one line that says why"
        names = {p.name for p in folder.rglob("*")} | set(command) | {"sample", str(path)}
        names |= {a.strip("-") for a in command if a.startswith("-")}
        shown = as_shown(said[0])
        if "OPTION" not in str(path) and not poor and not any(
                re.search(r"(?<!\w)" + re.escape(as_shown(n)) + r"(?!\w)", shown)
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
    stdout, hostile_stdout, path = open(folder / "stdout", "wb"), False, ""
    variables, limit = poor_environment(rng, folder)
    kind = rng.randrange(20)
    if kind == 0:
        command, path, hostile_stdout = rng.choice(PRINTING), "stdout", True
        variables, limit = {}, None
        if rng.randrange(2):
            stdout = open("/dev/full", "wb")
        else:
            read, write = os.pipe()
            os.close(read)
            stdout = os.fdopen(write, "wb")
    elif kind < 5:
        value = rng.choice(damage.NUMBERS + damage.NAMES[:30] + OPTION_VALUES).replace("\0", "")
        command, path = [value if a == "OPTION" else a for a in rng.choice(OPTIONS)], "OPTION"
    else:
        command, path = damaged_file(rng, folder)
    beside = rng.choice(BESIDE) if rng.randrange(20) == 0 and not limit else None
    written = {"out", "stdout", "stderr", "stderr2"} | ({"run", "logs"} if beside else {*command[1:2], *command[3:4]} & {"run", "logs"})
    if path == "OPTION":  # it may name the output
        written |= {"run", "other", (pathlib.PurePath(value).parts or ["."])[0] if value.strip("/") else "out"}
        written |= {"estimate.h5", "still.png", "validation_0.h5", "log.h5"}
        if "--design" in command:
            written.add(pathlib.PurePath(value).stem + ".csv")
    before, around = snapshot(folder, written), sorted(os.listdir(folder.parent))
    with concurrent.futures.ThreadPoolExecutor() as pool:
        second = beside and pool.submit(run, program, beside, folder, subprocess.DEVNULL, sanitized,
                                        variables, limit, "stderr2")
        code, errors, stopped = run(program, command, folder, stdout, sanitized, variables, limit)
    stdout.close()
    wrong = complaint(code, errors, stopped, command, path, folder, hostile_stdout, bool(limit))
    if not wrong and second and second.result()[0] not in ALLOWED:
        wrong = f"exit {second.result()[0]} of {beside} beside it"
    if not wrong and any(p.name.startswith("marker") for p in folder.rglob("*")):
        wrong = "something that a file said was run"
    after = snapshot(folder, written)
    if "." in written:  # beside the inputs: what was there stays
        after = {name: after.get(name) for name in before}
    if not wrong and after != before:
        wrong = "files outside of the output folder changed: " + ", ".join(sorted(
            name for name in {*before, *after} if before.get(name) != after.get(name)))[:200]
    named = folder.parent / "abs"  # by an option alone
    if path == "OPTION" and str(named) in command:
        if named.is_dir():
            shutil.rmtree(named)
        else:  # `compare -o` writes a file
            named.unlink(missing_ok=True)
    above = path == "OPTION" and os.path.realpath(folder / value) == str(folder.parent)  # named as the output
    beside_it = sorted(os.listdir(folder.parent))
    if not wrong and not above and beside_it != around:
        wrong = f"files beside the case's folder: {around} became {beside_it}"
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
