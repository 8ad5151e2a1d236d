"""What the tests share: the program of the same build, and one run of it and of the package on the tiny scene."""
import os
import pathlib
import subprocess

import pytest

import fricid

PROGRAM = os.environ["FRICID_PROGRAM"]
SOURCE = pathlib.Path(os.environ["FRICID_SOURCE_DIR"])
TINY = SOURCE / "tests" / "e2e" / "tiny.toml"


def program(*arguments, **options):
    return subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, **options)


def sentence_of_program(*arguments):
    """The one line that the program refuses an input with."""
    done = program(*arguments)
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1, done.stderr
    return done.stderr.removeprefix("fricid: ").rstrip("\n")


@pytest.fixture(scope="session")
def run_of_program(tmp_path_factory):
    folder = tmp_path_factory.mktemp("program") / "tiny"
    done = program("identify", TINY, "-o", folder)
    assert done.returncode == 0, done.stderr
    done = program("evaluate", folder)
    assert done.returncode == 0, done.stderr
    return fricid.Run(folder)


@pytest.fixture(scope="session")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("python") / "tiny"
    return fricid.evaluate(fricid.identify(fricid.simulate(TINY, folder)))


@pytest.fixture(scope="session")
def model(run):
    return run.models["lugre_s1"]


@pytest.fixture(scope="session")
def log(run):
    return run.logs["validation_0"]
