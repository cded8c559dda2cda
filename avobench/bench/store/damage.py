"""The warning of a damaged record, in a module of its own that loads nothing."""


class DamagedRecord(UserWarning):
    """A record that was left out because it is damaged; the text says which, what is wrong and what to do."""
