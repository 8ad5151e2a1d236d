"""Models of robot joint friction: simulate, identify, evaluate, use.

    run = fricid.simulate("scenes/kr6_demo.toml", "run")
    run = fricid.evaluate(fricid.identify(run))
    model = run.models["lugre_s1"]
    tau_f = model.friction.torque(q, v, z)

Mistakes in the input are `fricid.UserError`, one line with the place and what is allowed.
"""
from . import _native

_native.load()

from ._core import Friction, Model
from ._errors import Error, Failure, UserError
from ._run import Run, draw, evaluate, identify, simulate

__all__ = [
    "Error",
    "Failure",
    "Friction",
    "Model",
    "Run",
    "UserError",
    "draw",
    "evaluate",
    "identify",
    "simulate",
]
