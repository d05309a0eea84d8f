"""Runs one step of vibrom: the rule's named inputs, outputs and params become the arguments of its
`run`.

The step is `vibrom.steps.<name>`, with the name in `params.step`. What it prints goes to the
terminal and to the rule's log. An error that vibrom itself raises is one line on stderr; any other
is a bug and keeps its traceback.
"""

import ctypes
import errno
import importlib.util
import os
import signal
import sys
import traceback
from pathlib import Path

SIGNAL_ON_PARENTS_END = 1  # PR_SET_PDEATHSIG
INTERRUPTED = 130  # the exit code of what Ctrl-C ended


class Foreign(RuntimeError):
    """The package of another checkout would run."""


class Tee:
    """Writes to the terminal and to the log."""

    def __init__(self, terminal, log):
        self.terminal, self.log = terminal, log

    def write(self, text):
        written = self.terminal.write(text)
        self.log.write(text)
        return written

    def flush(self):
        self.terminal.flush()
        self.log.flush()

    def isatty(self):
        # Jobs run side by side: bars that redraw themselves would write over one another, lines do
        # not.
        return False

    def __getattr__(self, name):
        return getattr(self.terminal, name)


def arguments(job):
    """Keyword arguments of the step: paths as text, lists of paths as lists."""
    paths = [*job.input.items(), *job.output.items()]
    given = {
        name: str(path) if isinstance(path, str) else [str(item) for item in path]
        for name, path in paths
    }
    return given | dict(job.params.items())


def complaint(error):
    """The one line for an error that is not a bug, or None."""
    if isinstance(error, Foreign) or type(error).__module__.split(".")[0] == "vibrom":
        return " ".join(str(error).split())
    if isinstance(error, MemoryError):
        return f"not enough memory ({error}); lower periods, steps_per_period, frequencies or cells"
    for cause in (error, error.__cause__, error.__context__):
        if isinstance(cause, OSError) and cause.errno in (errno.ENOSPC, errno.EDQUOT):
            cure = "free some or choose another results folder, then run again"
            return f"{cause.filename or 'results'}: no space left; {cure}"
    return None


def end_with_parent():
    """Ends this job with the Snakemake that started it, also where that is killed: the next run
    starts the same job, and not beside this one.
    """
    if sys.platform == "linux":
        parent = os.getppid()
        ctypes.CDLL(None).prctl(SIGNAL_ON_PARENTS_END, signal.SIGTERM)
        if os.getppid() != parent:
            sys.exit(1)


def main(job):
    end_with_parent()
    # Compiled loops use the cores that the job was given, like the BLAS libraries, whose variables
    # Snakemake sets.
    os.environ["NUMBA_NUM_THREADS"] = str(job.threads)
    try:
        with open(job.log[0], "w", buffering=1, encoding="utf-8") as log:
            for terminal in (sys.__stdout__, sys.__stderr__):
                # What an old terminal has no sign for is shown as a question mark.
                terminal.reconfigure(errors="replace")
            sys.stdout, sys.stderr = Tee(sys.__stdout__, log), Tee(sys.__stderr__, log)
            try:
                run(job)
            except KeyboardInterrupt:
                sys.exit(INTERRUPTED)  # Snakemake says what it means
            except Exception as error:
                line = complaint(error)
                if line is None:
                    traceback.print_exc()
                else:
                    sys.stderr.write(f"vibrom: {line}\n")  # at once: the log's disk may be full
                sys.exit(1)
            finally:
                sys.stdout, sys.stderr = sys.__stdout__, sys.__stderr__
    except OSError as error:
        # The log itself cannot be written.
        sys.exit(f"vibrom: {complaint(error) or error}")


def check_own(job):
    """Raise where the vibrom that runs is not the one beside this workflow."""
    source = Path(job.scriptdir).parents[1] / "src"
    if importlib.util.find_spec("vibrom") is None:
        sys.path.insert(0, str(source))  # an environment for this rule, which has its packages only
    import vibrom

    own, running = source / "vibrom", Path(vibrom.__file__).parent
    if own.is_dir() and not own.samefile(running):
        raise Foreign(
            f"{running} would run, and not this checkout's {own}; activate the environment of this "
            "checkout, or make one (see README.md)"
        )
    if not os.access(running, os.W_OK):
        # Compiled loops are kept beside the package, or where this says.
        os.environ.setdefault("NUMBA_CACHE_DIR", str(Path(".snakemake/numba").absolute()))


def told(job):
    """What an artefact says of how it was made; of other outputs, the code behind them."""
    from vibrom.artefacts import provenance

    params = dict(job.params.items())
    stored = provenance.completed(params["provenance"])
    if not any(str(path).endswith(".nc") for path in job.output):
        return stored
    from vibrom.artefacts import identity

    asked = identity.asked(params)
    return stored | {"asked": asked, "made_from": identity.made_from(dict(job.input.items()))}


def run(job):
    check_own(job)
    given = arguments(job)
    step = importlib.import_module(f"vibrom.steps.{given.pop('step')}")
    if "provenance" in given:
        given["provenance"] = told(job)
    step.run(**given)


main(snakemake)  # noqa: F821  put there by Snakemake
