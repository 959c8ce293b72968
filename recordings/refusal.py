"""The one way this project says no."""


class Refusal(ValueError):
    """Input that cannot be used: one sentence naming the thing, its place and what was expected.

    The command line prints the sentence on standard error and exits with status 2.
    """
