"""The exception that every module raises for what a user can mend."""


class UserError(Exception):
    """A failure whose text is one line: what was got, what was wanted, what to do."""
