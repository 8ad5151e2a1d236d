"""simulate, identify, evaluate: the bytes of the program; scenes as dicts; progress, Ctrl-C, errors."""
import json
import logging
import pathlib
import shutil
import signal
import subprocess
import sys
import sysconfig
import threading
import time

import numpy as np
import pytest
from conftest import SOURCE, TINY, program, sentence_of_program

import fricid


def results(folder):
    """Bytes of every result; clock readings are in the manifest alone."""
    folder = pathlib.Path(folder)
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.name not in ("manifest.json", ".lock")
    }


def test_results_are_those_of_the_program(run, run_of_program):
    python, by_program = results(run), results(run_of_program)
    assert sorted(python) == sorted(by_program)
    assert "models/lugre_s1.json" in python and "evaluation.json" in python
    for name in python:
        assert python[name] == by_program[name], name


def test_the_command_of_the_wheel_goes_on_from_a_run_of_the_package(run, tmp_path):
    folder = tmp_path / "tiny"
    shutil.copytree(run, folder)
    stages = json.loads((folder / "manifest.json").read_text())["stages"]
    assert stages
    command = pathlib.Path(sysconfig.get_path("scripts")) / "fricid"
    done = subprocess.run([command, "evaluate", folder], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "lugre" in done.stdout
    assert json.loads((folder / "manifest.json").read_text())["stages"] == stages  # none was done again
    assert subprocess.run([command, "evaluate", tmp_path], capture_output=True).returncode == 2


def test_models_table_and_verdict(run):
    assert sorted(run.models) == ["lugre_s1", "simple_s1"]
    assert run.trusted and run.doubts == []
    rows = {row["name"]: row for row in run.table}
    assert rows["lugre"]["q_mse_1s"] < rows["simple"]["q_mse_1s"]
    assert rows["oracle"]["doubts"] == ""
    assert run.evaluation["format"] == "fricid.evaluation/2"


def test_results_of_former_data_are_not_handed_on(run, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(run, folder)
    fricid.identify(TINY, folder, seed=4, models=["simple"])
    former = fricid.Run(folder)
    with pytest.warns(UserWarning, match="lugre_s1.json: left out: made from another data/train_0.h5"):
        assert list(former.models) == ["simple_s1"]
    with pytest.raises(fricid.UserError, match="evaluation.json: made from another .*makes it again"):
        former.table
    assert not former.trusted
    assert any("evaluation.json: made from another" in doubt for doubt in former.doubts)


def test_a_dict_is_a_scene(run, tmp_path):
    scene = {
        "extends": str(TINY),
        "name": "tiny",
        "seed": np.int64(3),
        "model": [{"name": "simple"}],
        "evaluate": {"horizons_s": np.array([0.1, 1]), "starts": 2, "min_headroom": 2.0},
    }
    again = fricid.identify(scene, tmp_path / "run")
    assert list(again.models) == ["simple_s1"]
    name = "models/simple_s1.json"
    assert (again.folder / name).read_bytes() == (run.folder / name).read_bytes()


def test_a_dict_is_refused_with_the_place_of_the_key(tmp_path):
    folder = tmp_path / "run"
    for scene, sentence in [
        ({"extends": str(TINY), "excitation": {"harmonics": 0}}, r"<scene>: excitation.harmonics = 0;.*allowed"),
        ({"extends": str(TINY), "excitation": {"harmonic": 5}}, r"<scene>: unknown key excitation.harmonic.*harmonics"),
        ({"extends": str(TINY), "seed": object()}, r"<scene>: seed is of the type object; allowed"),
        ({"extends": "no such.toml"}, r"<scene>: extends: no such.toml is neither"),
        ({}, "<scene>: robot.urdf is missing"),
        ({1: 2}, "the key 1 is no text"),
    ]:
        with pytest.raises(fricid.UserError, match=sentence) as caught:
            fricid.simulate(scene, folder)
        assert "\n" not in str(caught.value)
        assert not folder.exists()


def test_texts_of_a_dict_cannot_become_keys(tmp_path):
    with pytest.raises(fricid.UserError, match="description"):
        fricid.simulate({"extends": str(TINY), "description": 'a"\nseed = 5 #\x7f'}, tmp_path / "run")


def test_errors_have_the_sentences_of_the_program(run, tmp_path):
    bad = tmp_path / "bad.toml"
    bad.write_text(f'extends = "{TINY}"\n[excitation]\nharmonics = 0\n')
    other = tmp_path / "other"
    other.mkdir()
    (other / "mine.txt").write_text("")
    for arguments, call in [
        (["simulate", bad, "-o", "x"], lambda: fricid.simulate(bad, "x")),
        (["simulate", tmp_path / "none.toml", "-o", "x"], lambda: fricid.simulate(tmp_path / "none.toml", "x")),
        (["simulate", TINY, "-o", other], lambda: fricid.simulate(TINY, other)),
        (["evaluate", other], lambda: fricid.evaluate(other)),
        (["identify", run.folder, "--model", "nonsense"], lambda: fricid.identify(run, models=["nonsense"])),
        (["check", tmp_path / "log.csv"], lambda: fricid.check(tmp_path / "log.csv")),
    ]:
        with pytest.raises(fricid.UserError) as caught:
            call()
        assert str(caught.value) == sentence_of_program(*arguments)
    assert issubclass(fricid.UserError, fricid.Error)


def test_seeds_and_jobs_are_checked(tmp_path):
    with pytest.raises(fricid.UserError, match="seed"):
        fricid.simulate(TINY, tmp_path / "run", seed=10**17)
    with pytest.raises(TypeError):
        fricid.simulate(TINY, tmp_path / "run", jobs="many")


def test_a_fit_that_is_not_to_be_trusted_says_so(tmp_path):
    still = {
        "extends": str(TINY),
        "excitation": {"half_range": [0.6, 0.4, 0.4, 0.6, 0.6, 1e-3]},
        "model": [{"name": "simple"}],
    }
    run = fricid.identify(still, tmp_path / "run")
    assert not run.trusted
    assert any("joint_a6" in doubt for doubt in run.doubts), run.doubts


def test_progress_is_reported_and_its_exception_ends_the_work(tmp_path):
    reports = []
    fricid.simulate(TINY, tmp_path / "run", progress=lambda *report: reports.append(report))
    stages = {report[0] for report in reports}
    assert stages and all(isinstance(stage, str) for stage in stages)
    assert any(done == total > 0 for _, done, total, _, _ in reports)

    def fail(*report):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        fricid.simulate(TINY, tmp_path / "other", progress=fail)
    assert not (tmp_path / "other").exists()  # nothing half done
    fricid.simulate(TINY, tmp_path / "other")


def test_a_run_cannot_begin_in_the_progress_of_another(tmp_path):
    with pytest.raises(fricid.UserError, match="a run cannot start in the progress callback of another"):
        fricid.simulate(TINY, tmp_path / "run",
                        progress=lambda *report: fricid.simulate(TINY, tmp_path / "inner"))


def test_lines_of_the_work_go_to_the_logger(tmp_path, caplog):
    with caplog.at_level(logging.INFO, logger="fricid"):
        fricid.simulate(TINY, tmp_path / "run")
    assert "simulate: tiny" in caplog.text


def test_other_threads_run_meanwhile(tmp_path):
    ticks = []
    stop = threading.Event()

    def tick():
        while not stop.wait(0.001):
            ticks.append(time.monotonic())

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.monotonic()
    fricid.simulate(TINY, tmp_path / "run")
    end = time.monotonic()
    stop.set()
    thread.join()
    during = [t for t in ticks if begin < t < end]
    assert len(during) > 10


def test_two_runs_at_once_wait_for_each_other(tmp_path):
    threads = [threading.Thread(target=fricid.simulate, args=(TINY, tmp_path / name)) for name in "ab"]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    name = "data/train_0.h5"
    assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


INTERRUPTED = """
import sys, fricid
try:
    fricid.identify({tiny!r}, {folder!r}, fresh=True, progress=lambda *report: print("begun", flush=True))
except KeyboardInterrupt:
    print("interrupted", flush=True)
    run = fricid.simulate({tiny!r}, {folder!r})  # the process is not stopped for good
    print("went on", len(run.logs), flush=True)
"""


def test_ctrl_c_is_a_keyboard_interrupt(tmp_path):
    code = INTERRUPTED.format(tiny=str(TINY), folder=str(tmp_path / "run"))
    child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "begun\n"
    child.send_signal(signal.SIGINT)
    output = child.stdout.read()
    assert child.wait() == 0
    assert "interrupted\nwent on 2\n" in output


def test_logs_may_be_arrays(run, tmp_path):
    """Fits to the arrays of a run, saved and read again, are those of the run."""
    sets = run.logs
    train = fricid.Log(sets["train_0"].q, sets["train_0"].tau, 250.0, joint_names=sets["train_0"].joint_names)
    held_out = fricid.Log(sets["validation_0"].q, sets["validation_0"].tau, 250.0,
                          joint_names=sets["validation_0"].joint_names)
    scene = {
        "robot": {"urdf": "models/kr6_r700/kr6_r700.urdf", "mount": "ceiling"},
        "data": fricid.save_logs(tmp_path / "logs", [train], [held_out]),
        "identify": {"cutoff_hz": 10, "min_speed_rad_s": 0.2},
        "model": [{"name": "simple"}],
        "evaluate": {"horizons_s": [0.1, 1]},
    }
    mine = fricid.evaluate(fricid.identify(scene, tmp_path / "run"))
    of_run, of_arrays = run.models["simple_s1"], mine.models["simple_s1"]
    for a, b in zip(of_run.friction.parameters, of_arrays.friction.parameters):
        assert a["symbol"] == b["symbol"]
        assert a["value"] == pytest.approx(b["value"], rel=1e-9)
    assert [row["name"] for row in mine.table] == ["simple"]


def test_logs_may_have_their_joints_in_any_order(run, tmp_path):
    logs = run.logs
    train, held_out = logs["train_0"], logs["validation_0"]
    turned = held_out.of_joints(held_out.joint_names[::-1])
    assert (turned.q == held_out.q[:, ::-1]).all()
    fricid.save_logs(tmp_path, [train], [turned])
    assert (fricid.Log.load(tmp_path / "validation_0.h5").q == held_out.q).all()
    other = fricid.Log(train.q, train.tau, 250.0, joint_names=[f"j{i}" for i in range(6)])
    with pytest.raises(fricid.UserError, match="logs of different joints"):
        fricid.save_logs(tmp_path, [train], [other])


def test_check_of_runs_files_and_arrays(run, log, tmp_path):
    whole = fricid.check(run)
    assert whole.whole and whole.report["format"] == "fricid.check/2"
    assert "joint_a1" in str(whole)
    robot = SOURCE / "models/kr6_r700/kr6_r700.urdf"
    done = program("check", run.folder / "data/validation_0.h5", "--robot", robot, "--json")
    assert fricid.check(run.folder / "data/validation_0.h5", robot=robot).report == json.loads(done.stdout)

    standing, hanging = (fricid.check(log, robot=robot, mount=mount) for mount in ("floor", "ceiling"))
    assert hanging.whole  # as the tiny arm does
    assert not standing.whole and "damage: mount" in standing.text
    assert fricid.check(log, robot=robot, mount="3.1416,0,0").whole
    with pytest.raises(fricid.UserError, match="mount floating: allowed: floor, ceiling, wall, or roll"):
        fricid.check(log, robot=robot, mount="floating")

    swapped = np.array(log.q)
    swapped[:, [1, 2]] = swapped[:, [2, 1]]
    damaged = fricid.check(fricid.Log(swapped, log.tau, log.rate_hz, joint_names=log.joint_names), robot=robot)
    assert not damaged.whole
    assert "swapped: q of joint_a2 and joint_a3" in damaged.text
    with pytest.raises(fricid.UserError, match="joint .*; allowed: those that move in the robot's file"):
        fricid.check(log, robot=SOURCE / "models/test/pendulum.urdf")
