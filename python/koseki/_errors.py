"""Failures by kind, for programs to act on; each text states the remedy."""


class KosekiError(Exception):
    """An operation on a deployment failed."""


class NotRunning(KosekiError):
    """No such deployment runs: start the deployment, or wait."""


class Ended(KosekiError):
    """The deployment has ended, or another run has replaced this run: close, and open anew."""


class SchemaMismatch(KosekiError):
    """A publisher was built from another version of the samples than this package."""


class NoSuchTopic(KosekiError):
    """The deployment has no such topic."""


class NoPlaceLeft(KosekiError):
    """The topic has no place left for another reader or writer."""


class BorrowLimit(KosekiError):
    """Two borrowed slices are held, the most allowed: delete an array, or copy the samples needed for longer."""


class AlreadyFed(KosekiError):
    """Another process publishes the source, and a source has one publisher: end that process, or feed another source."""
