"""Models of robot joint friction: simulate, identify, evaluate, use.

    run = fricid.simulate("scenes/kr6_demo.toml", "run")
    run = fricid.evaluate(fricid.identify(run))
    model = run.models["lugre_s1"]
    tau_f = model.friction.torque(q, v, z)

Mistakes in the input are `fricid.UserError`, one line with the place and what is allowed.
"""
from ._native import MUJOCO_PLUGIN, SHARE, load as _load

#: The instruction set that this process uses: x86-64-v3, x86-64-v4 or native.
INSTRUCTIONS = _load()

from ._core import Estimate, Filter, Friction, Log, Model, Motion
from ._errors import Error, Failure, UserError
from ._run import Check, Run, check, draw, evaluate, identify, save_logs, simulate

__all__ = [
    "INSTRUCTIONS",
    "MUJOCO_PLUGIN",
    "SHARE",
    "Check",
    "Error",
    "Estimate",
    "Failure",
    "Filter",
    "Friction",
    "Log",
    "Model",
    "Motion",
    "Run",
    "UserError",
    "check",
    "draw",
    "evaluate",
    "identify",
    "save_logs",
    "simulate",
]
