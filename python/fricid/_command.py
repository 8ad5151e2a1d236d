"""The command `fricid`."""
import sys

from fricid import _core


def main() -> int:
    return _core.command_line(["fricid", *sys.argv[1:]])
