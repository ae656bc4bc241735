"""Failures, each of a kind that a program can act on; the text says what to do."""


class KosekiError(Exception):
    """An operation on a deployment failed."""


class NotRunning(KosekiError):
    """No such deployment runs: start it, or wait for it."""


class Ended(KosekiError):
    """The deployment has ended, or another run has taken its place: close, and open anew."""


class SchemaMismatch(KosekiError):
    """A publisher was built from another version of the samples than this package."""


class NoSuchTopic(KosekiError):
    """The deployment has no such topic."""


class NoPlaceLeft(KosekiError):
    """The topic has no place left for another reader or writer."""


class BorrowLimit(KosekiError):
    """Two borrowed slices are held, and that is the limit: delete an array, or copy what is needed longer."""


class AlreadyFed(KosekiError):
    """Another process publishes the source, which has one publisher: end that process, or feed another source."""
