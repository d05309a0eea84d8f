# What a run says: one line a job when it ends, with how far the run is and how long it still takes.
#
#    12 of 560   2 %  folding: split seed_0: fit  (2.6 s; about 9 min left)
#
# `--quiet host` tells everything, in Snakemake's own words; so do its log file and a dry run.
import logging
import signal
import threading
import time


class Line(logging.Formatter):
    """In place of the lines that a job starts, that it ended, and how far the run is."""

    def __init__(self, own):
        self.own, self.began = own, time.monotonic()
        self.jobs, self.ended, self.stopping = {}, "", False

    def format(self, record):
        event = getattr(getattr(record, "event", None), "name", "")
        if event == "JOB_FINISHED":
            words, started = self.jobs.get(record.job_id, (record.getMessage(), time.monotonic()))
            self.ended = f"{words}  ({spent(time.monotonic() - started)}"
            return ""
        if event == "PROGRESS" and self.ended:
            return self.progress(record.done, record.total)
        if record.msg == "Terminating processes on user request, this might take some time.":
            self.stopping = True
            return (
                "Stopping. The same command goes on from here: what is finished stays, and a "
                "training continues from its last checkpoint."
            )
        # That the jobs it stopped did not finish is no news then.
        told = self.stopping and record.levelno >= logging.ERROR
        return "" if told else self.own.format(record)

    def progress(self, done, total):
        """The line of the job that ended last."""
        left = (time.monotonic() - self.began) / done * (total - done)
        about = f"; about {spent(left)} left" if done < total else ""
        line = f"{done:>4} of {total}  {done / total:4.0%}  {self.ended}{about})"
        self.ended = ""
        return line

    def shown(self, record):
        """As a filter: a start is kept in mind, and said when the job ends."""
        event = getattr(getattr(record, "event", None), "name", "")
        if event == "JOB_INFO":
            words = record.rule_msg or record.rule_name
            self.jobs[record.jobid] = words, time.monotonic()
        return (
            event not in ("JOB_INFO", "JOB_STARTED") and record.msg != "Select jobs to execute..."
        )


def spent(seconds):
    """`2.6 s`, `42 s` or `9 min`."""
    if seconds < 10:
        return f"{seconds:.1f} s"
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"


def say_lines():
    """On the terminal, where the profile's quietness is in force."""
    quiet = {word.name for word in workflow.output_settings.quiet or ()}
    if quiet != {"HOST", "REASON"} or workflow.output_settings.dryrun:
        return
    for handler in logging.getLogger(logger.name).handlers:
        if handler.name == "DefaultStreamHandler":
            line = Line(handler.formatter)
            handler.setFormatter(line)
            handler.addFilter(line.shown)
            expect_stop(line)


def expect_stop(line):
    """A job that Ctrl-C stopped may be noticed before Snakemake says that it stops."""
    known = signal.getsignal(signal.SIGINT)

    def stop(number, frame):
        line.stopping = True
        return known(number, frame)

    if threading.current_thread() is threading.main_thread() and callable(known):
        signal.signal(signal.SIGINT, stop)


if workflow.is_main_process:
    say_lines()
