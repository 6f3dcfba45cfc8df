"""The exception that every module raises for what a user can fix."""


class UserError(Exception):
    """A failure that a user can fix, in one line.

    problem: what was got and what was wanted; advice: what to do, empty where the problem says it.
    A caller that knows better what to do raises the problem again with its own advice.
    """

    def __init__(self, problem: str, advice: str = ''):
        super().__init__('{}; {}'.format(problem, advice) if advice else problem)
        self.problem, self.advice = problem, advice


def one_line(error: object) -> str:
    """Return the text of an error, or of anything else, as one line.

    Of an OSError it is the system's own message, without number and path.
    """
    text = getattr(error, 'strerror', None) or str(error)
    return ' '.join(text.split()) or type(error).__name__
