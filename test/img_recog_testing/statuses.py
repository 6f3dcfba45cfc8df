"""The content of a status of /diagnostics."""


def values(status):
    """Return the values of a diagnostic_msgs/DiagnosticStatus by their keys."""
    return {each.key: each.value for each in status.values}
