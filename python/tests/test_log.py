"""Log: arrays and files of a recording."""
import numpy as np
import pytest
from conftest import SOURCE

import fricid


def test_arrays_are_seen_without_a_copy(log):
    assert log.q.shape == (len(log), log.n) and log.t.shape == (len(log),)
    assert not log.q.flags.writeable and not log.q.flags.owndata
    assert log.q.__array_interface__["data"] == log.q.__array_interface__["data"]
    assert log.v is None or log.v.shape == log.q.shape


def test_save_and_load(log, run, tmp_path):
    log.save(tmp_path / "validation_0.h5")
    assert (tmp_path / "validation_0.h5").read_bytes() == (run.folder / "data/validation_0.h5").read_bytes()


def test_a_csv_by_its_contract(log, tmp_path):
    header = ",".join(["t", *(f"q{j + 1}" for j in range(6)), *(f"tau{j + 1}" for j in range(6))])
    table = np.column_stack([log.t, log.q, log.tau])
    np.savetxt(tmp_path / "log.csv", table, delimiter=",", header=header, comments="", fmt="%.17g")
    names = ", ".join(f'"{name}"' for name in log.joint_names)
    (tmp_path / "contract.toml").write_text(f'joint_names = [{names}]\n[position]\ncolumns = ["q{{}}"]\n[torque]\ncolumns = ["tau{{}}"]\n')
    read = fricid.Log.read(tmp_path / "log.csv", tmp_path / "contract.toml")
    np.testing.assert_array_equal(read.q, log.q)
    np.testing.assert_array_equal(read.tau, log.tau)
    assert read.rate_hz == pytest.approx(log.rate_hz)


@pytest.mark.parametrize("change, sentence", [
    ({"q": np.zeros(5)}, r"q has the shape \(5\); allowed: \(T, n\)"),
    ({"tau": np.zeros((10, 3))}, r"tau has the shape \(10, 3\); allowed: \(10, 2\), as q"),
    ({"rate_hz": 0.0}, "rate_hz = 0; allowed: above 0 Hz"),
    ({"rate_hz": float("nan")}, "rate_hz = nan; allowed"),
    ({"q": np.full((10, 2), np.nan)}, "log: "),
    ({"q": np.full((10, 2), np.inf)}, "log: "),
    ({"q": np.zeros((1, 2)), "tau": np.zeros((1, 2))}, "log: "),
    ({"joint_names": ["a"]}, "joint_names: 1 names; allowed: 2"),
    ({"joint_names": ["a", "a"]}, 'joint_names has "a" twice; allowed: every joint once'),
])
def test_bad_arrays_are_refused_in_one_line(change, sentence):
    arguments = {"q": np.zeros((10, 2)), "tau": np.ones((10, 2)), "rate_hz": 100.0} | change
    with pytest.raises(fricid.UserError, match=sentence) as caught:
        fricid.Log(**arguments)
    assert "\n" not in str(caught.value)


def test_doubtful_arrays_warn():
    q = np.linspace(0, 360, 400)[:, None]
    with pytest.warns(UserWarning):
        fricid.Log(q, np.zeros_like(q), 100.0)
