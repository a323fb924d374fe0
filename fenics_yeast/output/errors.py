"""What can go wrong with an output directory or a run into it; each message is one line."""


class OutputError(Exception):
    """An output directory that cannot be written or read."""


class OutputWriteError(OutputError):
    """An output directory that cannot be written; `problem` is the message without advice."""

    def __init__(self, problem: str, advice: str) -> None:
        super().__init__(f"{problem}; {advice}")
        self.problem = problem


class DolfinxMissing(Exception):
    """dolfinx cannot be loaded, or compiles nothing; the message says what to do."""


class RunLost(Exception):
    """The output directory became unwritable during the run, as on a full disk.

    `problem` is the message without advice. If not raised `everywhere`, others wait for rank 0.
    """

    def __init__(self, problem: str, advice: str, *, everywhere: bool) -> None:
        super().__init__(f"{problem}; {advice}")
        self.problem, self.everywhere = problem, everywhere
