"""What a failed test does not show: the lines of this package between the test and the reason."""
import operator

from img_recog.errors import UserError

# for __tracebackhide__ of a module, which pytest calls with what was raised
of_reasons = operator.methodcaller('errisinstance', (AssertionError, UserError))
