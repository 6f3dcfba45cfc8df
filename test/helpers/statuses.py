"""The content of a status of /diagnostics."""
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper


def values(status):
    """Return the values of a diagnostic_msgs/DiagnosticStatus by their keys."""
    return {each.key: each.value for each in status.values}


def report(reporter):
    """Return the level, the message and the values of a report on what was fine before."""
    status = DiagnosticStatusWrapper()
    status.summary(DiagnosticStatus.OK, 'fine')
    reporter.report(status)
    return status.level, status.message, values(status)
