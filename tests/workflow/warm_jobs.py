"""Jobs of a run, in forks of one process that has imported what they import: to start Python and to
import is most of what a job of the small run takes.

    python warm_jobs.py SOCKET FILE     waits for jobs; FILE gets a line "rule memory" of each
    python -S warm_jobs.py SCRIPT       runs a script of Snakemake's there

The second stands in the place of Python's name, so that all else of a job is as it always is.
"""

import json
import os
import socket
import sys

SOCKET = "VIBROM_WARM_JOBS"  # the variable that names it
PEAKS = "peaks.txt"  # the file, in the folder of a run
# Not torch: few jobs need it, and it takes more memory than they are allowed that do not.
BOUGHT = ("snakemake.script", "matplotlib.backends.backend_agg", "netCDF4", "pandas")


def ask(script: str) -> int:
    """The exit code of a script, which gets our folder, environment and terminal."""
    with socket.socket(socket.AF_UNIX) as there:
        there.connect(os.environ[SOCKET])
        socket.send_fds(there, [b"."], [1, 2])
        there.sendall(json.dumps([script, os.getcwd(), dict(os.environ)]).encode())
        there.shutdown(socket.SHUT_WR)
        return int(there.recv(4) or b"1")  # nothing comes back from a job that was killed


def serve(path: str, peaks: str) -> None:
    """Import everything, and run jobs until killed."""
    import importlib
    import pkgutil
    import resource
    import runpy
    import socketserver
    import traceback

    from vibrom import steps

    class Job(socketserver.BaseRequestHandler):
        """In a process of its own."""

        def handle(self):
            _, streams, *_ = socket.recv_fds(self.request, 1, 2)
            sent = b"".join(iter(lambda: self.request.recv(65536), b""))
            script, folder, environment = json.loads(sent)
            for place, stream in enumerate(streams, 1):
                os.dup2(stream, place)
            os.chdir(folder)
            os.environ.clear()
            os.environ.update(environment)
            sys.argv = [script]
            try:
                seen = runpy.run_path(script, run_name="__main__")
                taken = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # KiB
                with open(peaks, "a", encoding="utf-8") as lines:
                    lines.write(f"{seen['snakemake'].rule} {1.024e-3 * taken:.1f}\n")  # MB
                code = 0
            except SystemExit as ended:
                code = ended.code if isinstance(ended.code, int) else int(ended.code is not None)
            except BaseException:
                traceback.print_exc()
                code = 1
            sys.stdout.flush()
            sys.stderr.flush()
            self.request.sendall(str(code).encode())

    class Server(socketserver.ForkingMixIn, socketserver.UnixStreamServer):
        max_children = 8

    for name in (
        *BOUGHT,
        *(f"vibrom.steps.{each.name}" for each in pkgutil.iter_modules(steps.__path__)),
    ):
        importlib.import_module(name)
    with Server(path, Job) as server:
        print("ready", flush=True)
        server.serve_forever()


if __name__ == "__main__":
    if len(sys.argv) == 2:
        sys.exit(ask(sys.argv[1]))
    serve(*sys.argv[1:])
