"""Scenes as dicts: their text in TOML."""
import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ._errors import UserError


def to_toml(scene: Mapping[str, Any]) -> str:
    """The text of a scene; one line per key, tables within it."""
    return "".join(f"{_key(key)} = {_value(value, str(key))}\n" for key, value in scene.items())


def _key(key: object) -> str:
    if not isinstance(key, str):
        raise UserError(f"<scene>: the key {key!r} is no text; allowed: the keys of a scene file")
    return _text(key)


def _text(text: str) -> str:
    escaped = "".join(
        f"\\u{ord(c):04X}" if c in '"\\' or ord(c) < 0x20 or ord(c) == 0x7F else c for c in text
    )
    return f'"{escaped}"'


def _value(value: object, key: str) -> str:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return repr(value)  # inf and nan are TOML too
    if isinstance(value, str | os.PathLike):
        return _text(os.fspath(value))
    if isinstance(value, Mapping):
        entries = (f"{_key(k)} = {_value(v, f'{key}.{k}')}" for k, v in value.items())
        return "{" + ", ".join(entries) + "}"
    if isinstance(value, Sequence):
        return "[" + ", ".join(_value(v, f"{key}[{i}]") for i, v in enumerate(value)) + "]"
    raise UserError(
        f"<scene>: {key} is of the type {type(value).__name__}; allowed: text, number, bool, list, dict"
    )
