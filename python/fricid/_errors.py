"""Errors, with the messages of the program."""


class Error(Exception):
    """Base class of the errors of fricid."""

    __module__ = "fricid"


class UserError(Error):
    """A mistake in the input: where, what was found, what is allowed; one line."""

    __module__ = "fricid"


class Failure(Error):
    """A failure of the program itself; one line."""

    __module__ = "fricid"
