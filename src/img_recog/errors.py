"""The exception that every module raises for a problem that the user can fix."""


class UserError(Exception):
    """A problem that the user can fix, described in one line.

    problem: what was got and what was expected.
    advice: what to do about it; empty if the problem already says so.
    A caller that can give better advice raises a new error with the same problem.
    """

    def __init__(self, problem: str, advice: str = ''):
        super().__init__('{}; {}'.format(problem, advice) if advice else problem)
        self.problem, self.advice = problem, advice


def one_line(error: object) -> str:
    """Return the text of an error, or of anything else, as one line.

    For an OSError this is the message of the operating system, without number and path.
    """
    text = getattr(error, 'strerror', None) or str(error)
    return ' '.join(text.split()) or type(error).__name__
