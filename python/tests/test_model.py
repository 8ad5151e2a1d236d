"""Model, friction on batches, open loops, the online filter, export: against the program and against themselves."""
import json
import pathlib
import threading
import warnings

import numpy as np
import pytest
from conftest import SOURCE, program, sentence_of_program

import fricid


@pytest.fixture()
def motion(model):
    rng = np.random.default_rng(5)
    shape = (37, model.friction.n)
    return rng.normal(size=shape), rng.normal(size=shape), rng.normal(scale=1e-4, size=(37, model.friction.state_size))


def test_load_and_save_keep_the_bytes(run, model, tmp_path):
    model.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == (run.folder / "models/lugre_s1.json").read_bytes()
    assert (model.name, model.label, model.seed) == ("lugre", "lugre", 1)
    assert model.joint_names[0] == "joint_a1" and len(model.joint_names) == model.friction.n == 6


def test_parameters_are_those_of_the_file(model, run):
    found = program("info", run.folder / "models/lugre_s1.json").stdout
    for p in model.friction.parameters:
        assert p["joint"] in found and p["symbol"] in found
    sigma0 = [p for p in model.friction.parameters if p["symbol"] == "sigma0"]
    assert len(sigma0) == 6 and all(p["unit"] == "N m/rad" for p in sigma0)
    assert sigma0[0]["value"] == pytest.approx(5e3, rel=0.2)  # as injected


def test_motors_of_a_robot_without_coupling_are_its_joints(model):
    np.testing.assert_array_equal(model.friction.motors_of_joints, np.eye(6))


def test_rows_of_a_batch_are_single_states(model, motion):
    q, v, z = motion
    tau = model.friction.torque(q, v, z)
    new = model.friction.step(q, v, z, 1e-3)
    assert tau.shape == q.shape and new.shape == z.shape
    for i in (0, 7, 36):
        one = model.friction.torque(q[i], v[i], z[i])
        assert one.shape == (6,)
        np.testing.assert_array_equal(one, tau[i])
        np.testing.assert_array_equal(model.friction.step(q[i], v[i], z[i], 1e-3), new[i])


def test_one_row_counts_for_all(model, motion):
    q, v, z = motion
    np.testing.assert_array_equal(model.friction.torque(q[0], v, z[0]),
                                  model.friction.torque(np.tile(q[0], (37, 1)), v, np.tile(z[0], (37, 1))))
    np.testing.assert_array_equal(
        model.friction.torque(q, v, z, load=np.zeros(6), temperature=np.full(6, 293.15)),
        model.friction.torque(q, v, z))


def test_any_layout_gives_the_same(model, motion):
    q, v, z = motion
    expected = model.friction.torque(q, v, z)
    np.testing.assert_array_equal(model.friction.torque(np.asfortranarray(q), v[:, ::-1][:, ::-1], z.tolist()), expected)
    read_only = q.copy()
    read_only.flags.writeable = False
    np.testing.assert_array_equal(model.friction.torque(read_only, v, z), expected)
    singles = model.friction.torque(q.astype(np.float32), v, z)
    np.testing.assert_array_equal(singles, model.friction.torque(q.astype(np.float32).astype(float), v, z))


def test_lugre_slides_on_its_stribeck_curve(model):
    f = model.friction
    by = {(p["joint"], p["symbol"]): p["value"] for p in f.parameters}
    v = np.full(6, 0.3)
    z = f.rest()
    for _ in range(2000):
        z = f.step(np.zeros(6), v, z, 1e-3)
    tau = f.torque(np.zeros(6), v, z)
    np.testing.assert_allclose(tau, f.steady_torque(np.zeros(6), v), rtol=1e-9)
    for j, joint in enumerate(model.joint_names):
        Fc, Fs, vs, sigma2 = (by[joint, s] for s in ("Fc", "Fs", "vs", "sigma2"))
        assert tau[j] == pytest.approx(Fc + (Fs - Fc) * np.exp(-((0.3 / vs) ** 2)) + sigma2 * 0.3, rel=1e-6)
    np.testing.assert_allclose(f.torque(np.zeros(6), -v, -z), -tau)


def test_drive_is_steps_along_a_motion(model, log):
    f, dt = model.friction, 1 / log.rate_hz
    q = np.array(log.q[:200])
    v = np.gradient(q, dt, axis=0)
    tau, z = f.drive(q, v, dt, load=log.tau[:200])
    assert tau.shape == (200, 6) and z.shape == (200, f.state_size)
    state = f.rest()
    for k in range(199):
        np.testing.assert_array_equal(tau[k], f.torque(q[k], v[k], state, load=log.tau[k]))
        state = f.step(q[k + 1], (q[k + 1] - q[k]) / dt, state, dt, load=log.tau[k])
    np.testing.assert_array_equal(z[199], state)


@pytest.mark.parametrize("change, sentence", [
    (lambda a: a | {"q": np.zeros((3, 5))}, r"q has the shape \(3, 5\); allowed: \(6\) or \(N, 6\)"),
    (lambda a: a | {"q": np.zeros((2, 2, 6))}, r"q has the shape \(2, 2, 6\); allowed"),
    (lambda a: a | {"v": 0.5}, r"v has the shape \(\); allowed"),
    (lambda a: a | {"v": np.full((4, 6), np.nan)}, r"v\[0, 0\] = nan; allowed: finite values"),
    (lambda a: a | {"z": np.full(6, np.inf)}, r"z\[0\] = inf; allowed: finite values"),
    (lambda a: a | {"v": np.zeros((4, 6)), "z": np.zeros((3, 6))}, r"z has 3 rows; allowed: 1 or 4, as v has"),
    (lambda a: a | {"load": "heavy"}, r"load: .*; allowed: an array of numbers"),
    (lambda a: a | {"q": [[1, 2], [3]]}, r"q: .*; allowed: an array of numbers"),
])
def test_bad_arrays_are_refused_in_one_line(model, change, sentence):
    arguments = change({"q": np.zeros(6), "v": np.zeros(6), "z": np.zeros(6)})
    with pytest.raises(fricid.UserError, match=sentence) as caught:
        model.friction.torque(**arguments)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("dt", [0.0, -1e-3, float("nan")])
def test_bad_steps_of_time_are_refused(model, dt):
    with pytest.raises(fricid.UserError, match="dt = .* s; allowed: above 0"):
        model.friction.step(np.zeros(6), np.zeros(6), model.friction.rest(), dt)


def test_a_law_without_states(run):
    f = run.models["simple_s1"].friction
    assert f.state_size == 0 and f.rest(4).shape == (4, 0)
    v = np.array([[-0.5] * 6, [0.5] * 6])
    tau = f.torque(np.zeros(6), v, f.rest())
    np.testing.assert_allclose(tau, f.steady_torque(np.zeros(6), v))
    assert (tau[1] > 0).all()
    assert f.step(np.zeros(6), v, f.rest(2), 1e-3).shape == (2, 0)


def test_an_empty_batch_is_empty(model):
    tau = model.friction.torque(np.zeros((0, 6)), np.zeros((0, 6)), model.friction.rest())
    assert tau.shape == (0, 6)


def test_bad_model_files_are_refused_as_by_the_program(run, tmp_path):
    text = (run.folder / "models/lugre_s1.json").read_text()
    content = json.loads(text)
    bad = tmp_path / "model.json"
    for broken in [
        text.replace("fricid.model/1", "fricid.model/2"),
        text[: len(text) // 2],
        json.dumps(content | {"robot": {}}),
        "[]",
    ]:
        bad.write_text(broken)
        with pytest.raises(fricid.UserError) as caught:
            fricid.Model.load(bad)
        assert str(caught.value) == sentence_of_program("export", bad, "c", "-o", tmp_path / "out")
    with pytest.raises(fricid.UserError, match="none.json"):
        fricid.Model.load(tmp_path / "none.json")


def test_export_is_that_of_the_program(run, model, tmp_path):
    for format in ("c", "csv", "urdf", "mjcf"):
        files, losses = model.export(format, tmp_path / "python" / format)
        done = program("export", run.folder / "models/lugre_s1.json", format, "-o", tmp_path / "program" / format)
        assert done.returncode == 0
        assert [f"note: {loss}" for loss in losses] == [x for x in done.stdout.splitlines() if x.startswith("note: ")]
        for file in files:
            assert file.read_bytes() == (tmp_path / "program" / format / file.name).read_bytes()
    with pytest.raises(fricid.UserError, match="unknown format 'word'; allowed: c, csv"):
        model.export("word", tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(fricid.UserError, match="file"):
        model.export("c", tmp_path / "file")


def test_rollout_follows_the_log(model, log):
    motion = model.rollout(log, start_s=1.0, seconds=1.0)
    assert motion.q.shape == (251, 6) and motion.t[0] == 1.0 and motion.t[-1] == pytest.approx(2.0)
    assert np.abs(motion.q - log.q[250:501]).max() < 0.05
    assert not motion.diverged
    assert np.abs(motion.tau_f).max() > 1
    assert len(model.rollout(log).q) == len(log)
    for bad in ({"start_s": -1.0}, {"start_s": 100.0}, {"seconds": 100.0}, {"start_s": 6.0, "seconds": 5.0}):
        with pytest.raises(fricid.UserError, match="allowed"):
            model.rollout(log, **bad)


def test_rollout_says_what_it_fills(model, log):
    tau = log.tau.copy()
    tau[300:310, 2] = np.nan
    holed = fricid.Log(log.q, tau, log.rate_hz, joint_names=log.joint_names, name="holed")
    with pytest.warns(UserWarning, match="holed: 10 of 250 torques missing"):
        model.rollout(holed, start_s=1.0, seconds=1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model.rollout(holed, start_s=2.0, seconds=1.0)


def test_rollout_takes_joints_by_name(model, log):
    turned = fricid.Log(log.q[:, ::-1], log.tau[:, ::-1], log.rate_hz, joint_names=log.joint_names[::-1])
    unnamed = fricid.Log(log.q, log.tau, log.rate_hz)
    expected = model.rollout(fricid.Log(log.q, log.tau, log.rate_hz, joint_names=log.joint_names), seconds=1.0)
    for other in (turned, unnamed):
        np.testing.assert_array_equal(model.rollout(other, seconds=1.0).q, expected.q)
    others = fricid.Log(log.q, log.tau, log.rate_hz, joint_names=[f"a{i}" for i in range(6)])
    with pytest.raises(fricid.UserError, match="found a0 a1 a2 a3 a4 a5; allowed: those of model lugre, joint_a1 .*, in any order"):
        model.rollout(others)


def test_simulate_is_the_same_open_loop(model, log):
    """From the state of a rollout, under the same torque, the same motion."""
    whole = model.rollout(log, seconds=2.0)
    # the friction state is not in the motion: begin at rest in both
    one = model.simulate(log.tau[:100], log.rate_hz, whole.q[0], whole.v[0])
    two = model.simulate(log.tau[:50], log.rate_hz, whole.q[0], whole.v[0])
    assert one.q.shape == (101, 6)
    np.testing.assert_array_equal(one.q[:51], two.q)
    np.testing.assert_array_equal(one.q[0], whole.q[0])
    warm = model.simulate(log.tau[:50], log.rate_hz, whole.q[0], whole.v[0], temperature=np.full(6, 293.15))
    np.testing.assert_array_equal(warm.q, two.q)
    with pytest.raises(fricid.UserError, match="tau"):
        model.simulate(np.full((5, 6), np.nan), 250.0, np.zeros(6))


@pytest.fixture()
def without_noise(run, tmp_path):
    content = json.loads((run.folder / "models/lugre_s1.json").read_text())
    del content["noise"]
    path = tmp_path / "without_noise.json"
    path.write_text(json.dumps(content))
    return fricid.Model.load(path)


def test_filter_is_that_of_the_program(model, log, run, tmp_path):
    out = tmp_path / "estimate.h5"
    short = tmp_path / "short.h5"
    part = fricid.Log(log.q[:300], log.tau[:300], log.rate_hz, joint_names=log.joint_names)
    part.save(short)
    done = program("estimate", run.folder / "models/lugre_s1.json", short, "-o", out, "--particles", "50")
    assert done.returncode in (0, 1), done.stderr
    table = np.genfromtxt(program("info", out, "--csv").stdout.splitlines(), delimiter=",", names=True)

    filter = model.filter(part.q, part.rate_hz, particles=50, tau=part.tau)
    for k in range(1, len(part)):
        now = filter.update(part.q[k], part.tau[k - 1])
        assert now.tau_f[0] == table["tau_f1"][k]
        assert now.q_sd[5] == table["q_sd6"][k]
        assert now.log_likelihood == table["log_likelihood"][k]
    assert now.tau_f.shape == (6,) and now.z.shape == (6,) and now.ess > 1
    kept = now.q.copy()
    filter.reset()
    filter.update(part.q[1], part.tau[0])
    np.testing.assert_array_equal(now.q, kept)  # an estimate stays as it was


def test_filter_refuses_what_it_cannot_use(model, without_noise, log):
    with pytest.raises(fricid.UserError, match="noise is missing"):
        without_noise.filter(log.q[0], 250.0)
    with pytest.raises(fricid.UserError, match="rate 100 Hz; allowed"):
        model.filter(log.q[0], 100.0)
    with pytest.raises(fricid.UserError, match="particles = 0; allowed"):
        model.filter(log.q[0], 250.0, particles=0)
    with pytest.raises(fricid.UserError, match="q has 2 rows; allowed: one position, or more with tau"):
        model.filter(log.q[:2], 250.0)
    with pytest.raises(fricid.UserError, match="tau has 1 rows; allowed: 2"):
        model.filter(log.q[:2], 250.0, tau=log.tau[:1])
    filter = model.filter(log.q[0], 250.0, particles=20)
    with pytest.raises(fricid.UserError, match=r"q has the shape \(5\); allowed: \(6\)"):
        filter.update(np.zeros(5), np.zeros(6))
    with pytest.raises(fricid.UserError, match=r"tau\[0\] = nan"):
        filter.update(log.q[1], np.full(6, np.nan))
    missing = np.array(log.q[1])
    missing[3] = np.nan
    assert np.isfinite(filter.update(missing, log.tau[0]).q).all()


def test_friction_runs_beside_other_threads(model):
    """Batches on threads give what they give alone."""
    rng = np.random.default_rng(1)
    q, v = rng.normal(size=(2, 5000, 6))
    z = np.zeros((5000, 6))
    alone = model.friction.step(q, v, z, 1e-3)
    found = [None] * 4

    def work(i):
        found[i] = model.friction.step(q, v, z, 1e-3)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for result in found:
        np.testing.assert_array_equal(result, alone)


def test_parts_outlive_the_model(run):
    friction = fricid.Model.load(run.folder / "models/lugre_s1.json").friction
    assert friction.torque(np.zeros(6), np.zeros(6), friction.rest()).shape == (6,)
    q = fricid.Log.load(run.folder / "data/train_0.h5").q
    assert np.isfinite(np.array(q)).all()


def test_everything_says_what_it_is():
    """Public names have a docstring beyond their signature."""
    for thing in (getattr(fricid, name) for name in fricid.__all__):
        if not callable(thing):
            continue
        assert thing.__doc__
        for name, member in vars(thing).items() if isinstance(thing, type) else ():
            if not name.startswith("_") and not isinstance(member, str):
                said = (member.__doc__ or "").splitlines()
                assert [line for line in said if line and not line.startswith((name + "(", "(self)"))], (thing, name)
    for format in ("c", "mjcf_friction", "plugin", "fmu", "onnx"):
        assert f" {format}" in fricid.Model.export.__doc__
