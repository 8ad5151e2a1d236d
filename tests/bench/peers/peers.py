"""Bootstrap filters of particles and cuthbert on the models of tests/bench/smc_bench.cpp.

Prints nanoseconds of CPU per particle and step, the median of seven runs after one to warm up, and log p(y)
as a check: exact (Kalman) for the linear model, agreeing between the packages for the toy.
"""
import json
import os
import statistics
import sys
import time

os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"

import cuthbert
import jax
import jax.numpy as jnp
import numpy as np
import particles
from cuthbert.smc import particle_filter
from cuthbertlib.resampling import ess_decorator, systematic
from particles import distributions as dists
from particles import state_space_models as ssm

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_platforms", "cpu")

T = 250
RUNS = 7


class Linear:
    """18 states x' = A x + w, the first 6 observed.

    With noise of 1, not 0.1: a bootstrap filter then keeps its path and log p(y) can be compared;
    the time does not depend on it.
    """

    n, ny = 18, 6

    def __init__(self):
        rng = np.random.default_rng(3)
        A = rng.normal(size=(self.n, self.n))
        self.A = 0.95 / np.abs(np.linalg.eigvals(A)).max() * A
        self.m0, self.sd0 = np.zeros(self.n), np.ones(self.n)
        self.sd = np.sqrt(np.linspace(0.05, 0.2, self.n))
        self.sd_y = np.ones(self.ny)

    def step(self, np_, t, x):
        return x @ self.A.T

    def observe(self, x):
        return x[..., :self.ny]


class Toy:
    """One joint with a Dahl bristle, x = (q, v, z), q observed: tests/smc/friction_toy.hpp."""

    n, ny = 3, 1
    dt, inertia, length, stiffness, damping = 4e-3, 0.1, 3e-3, 330.0, 0.3

    def __init__(self):
        self.m0, self.sd0 = np.zeros(3), np.array([1e-4, 1e-2, 1e-4])
        self.sd, self.sd_y = np.array([1e-6, 3e-3, 1e-6]), np.array([1e-5])

    def step(self, np_, t, x):
        q, v, z = x[..., 0], x[..., 1], x[..., 2]
        phase = 2 * np.pi * t * self.dt / 0.9
        torque = 2 * (np_.sin(phase) + 0.3 * np_.sin(2.3 * phase))
        h = -self.dt / self.length * np_.abs(v)
        phi = np_.where(h == 0, 1.0, np_.expm1(h) / np_.where(h == 0, 1.0, h))
        z_next = z + (self.dt * v + h * z) * phi
        v_next = v + self.dt / self.inertia * (torque - self.stiffness * z - self.damping * v)
        return np_.stack([q + self.dt * v_next, v_next, z_next], axis=-1)

    def observe(self, x):
        return x[..., :1]


def simulate(model):
    rng = np.random.default_rng(2)
    x = model.m0 + model.sd0 * rng.normal(size=model.n)
    y = np.empty((T, model.ny))
    for t in range(T):
        if t > 0:
            x = model.step(np, t - 1, x) + model.sd * rng.normal(size=model.n)
        y[t] = model.observe(x) + model.sd_y * rng.normal(size=model.ny)
    return y


def kalman(model, y):
    """log p(y) of the linear model."""
    C = np.eye(model.ny, model.n)
    m, P, total = model.m0, np.diag(model.sd0**2), 0.0
    for t in range(T):
        if t > 0:
            m, P = model.A @ m, model.A @ P @ model.A.T + np.diag(model.sd**2)
        S = C @ P @ C.T + np.diag(model.sd_y**2)
        e = y[t] - C @ m
        K = np.linalg.solve(S, C @ P).T
        total -= 0.5 * (e @ np.linalg.solve(S, e) + np.linalg.slogdet(2 * np.pi * S)[1])
        m, P = m + K @ e, P - K @ C @ P
    return total


def with_particles(model, y, N):
    class Model(ssm.StateSpaceModel):
        def PX0(self):
            return dists.IndepProd(*[dists.Normal(m, s) for m, s in zip(model.m0, model.sd0)])

        def PX(self, t, xp):
            f = model.step(np, t - 1, xp)
            return dists.IndepProd(*[dists.Normal(f[:, i], s) for i, s in enumerate(model.sd)])

        def PY(self, t, xp, x):
            seen = model.observe(x)
            return dists.IndepProd(*[dists.Normal(seen[:, i], s) for i, s in enumerate(model.sd_y)])

    def run():
        filter_ = particles.SMC(fk=ssm.Bootstrap(ssm=Model(), data=y), N=N, resampling="systematic",
                                ESSrmin=0.5)
        filter_.run()
        return filter_.logLt

    return run


def with_cuthbert(model, y, N):
    sd, sd0, sd_y, m0 = (jnp.asarray(a) for a in (model.sd, model.sd0, model.sd_y, model.m0))

    def potential(x, seen):
        e = (seen - model.observe(x)) / sd_y
        return -0.5 * jnp.sum(e * e) - jnp.sum(jnp.log(sd_y)) - model.ny * 0.5 * jnp.log(2 * jnp.pi)

    # its x_0 is not observed: a step before the first observation keeps x_0 as it is
    def move(key, x, inputs):
        t, _ = inputs
        moved = model.step(jnp, t - 1, x) + sd * jax.random.normal(key, (model.n,))
        return jnp.where(t == 0, x, moved)

    filter_ = particle_filter.build_filter(
        init_sample=lambda key: m0 + sd0 * jax.random.normal(key, (model.n,)),
        propagate_sample=move,
        log_potential=lambda before, x, inputs: potential(x, inputs[1]),
        n_filter_particles=N,
        resampling_fn=ess_decorator(systematic.resampling, 0.5))
    inputs = (jnp.arange(T, dtype=jnp.float64), jnp.asarray(y))

    @jax.jit
    def whole(key):
        states = cuthbert.filter(filter_, inputs, filter_.init_prepare(key=key), key=key)
        return states.log_normalizing_constant[-1]

    keys = iter(range(1 << 30))
    return lambda: float(whole(jax.random.key(next(keys))))


def ours(path):
    """ns per particle and step of fricid_bench by (model, N)."""
    found = {}
    for b in json.load(open(path))["benchmarks"]:
        for name, key in (("BM_BootstrapLinear<PackD>", "linear, 18 states"),
                          ("BM_BootstrapToy<PackD>", "one joint")):
            if b["name"].startswith(name + "/N:"):
                N = int(b["name"].split("N:")[1].split("/")[0])
                found[key, N] = 1e9 / b["items_per_second"]
    return found


def main():
    beside = ours(sys.argv[1]) if len(sys.argv) > 1 else {}
    print("| model | N | fricid [ns] | particles [ns] | cuthbert [ns] | log p(y): exact | particles "
          "| cuthbert |")
    print("|---|--:|--:|--:|--:|--:|--:|--:|")
    for name, model in (("linear, 18 states", Linear()), ("one joint", Toy())):
        y = simulate(model)
        exact = f"{kalman(model, y):.1f}" if isinstance(model, Linear) else ""
        for N in (200, 3200):
            cells, values = [], []
            for make in (with_particles, with_cuthbert):
                np.random.seed(1)
                run = make(model, y, N)
                run()
                seconds, logs = [], []
                for _ in range(RUNS):
                    begin = time.process_time()
                    logs.append(run())
                    seconds.append(time.process_time() - begin)
                cells.append(f"{1e9 * statistics.median(seconds) / (N * T):.0f}")
                values.append(f"{statistics.median(logs):.1f}")
            mine = f"{beside[name, N]:.0f}" if (name, N) in beside else ""
            print(f"| {name} | {N} | {mine} | {' | '.join(cells)} | {exact} | {' | '.join(values)} |",
                  flush=True)


if __name__ == "__main__":
    main()
