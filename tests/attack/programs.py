"""Starts capture_server and render_client for a test and ends them by their own process numbers."""
import argparse
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
RECORDING = ROOT / "data/recordings/camera0.oni"


class Program:
    """A running program whose standard error goes to a file."""

    def __init__(self, arguments, log):
        self.log = pathlib.Path(log)
        with self.log.open("wb") as file:
            self.process = subprocess.Popen([str(a) for a in arguments], stdin=subprocess.DEVNULL,
                                            stdout=subprocess.DEVNULL, stderr=file)

    @property
    def pid(self):
        return self.process.pid

    def said(self):
        return self.log.read_text(errors="replace")

    def says(self, pattern, within=30.0):
        """Waits for a line; returns the match, or None."""
        limit = time.monotonic() + within
        while True:
            found = re.search(pattern, self.said())
            if found or time.monotonic() > limit or self.process.poll() is not None:
                return found or re.search(pattern, self.said())
            time.sleep(0.02)

    def is_running(self):
        return self.process.poll() is None

    def wait(self, within):
        """Returns the exit code, or None if the program still runs."""
        try:
            return self.process.wait(within)
        except subprocess.TimeoutExpired:
            return None

    def end(self, within=10.0):
        """Asks the program to stop; kills it if it does not. Returns its exit code, negative for a signal."""
        if self.is_running():
            self.process.send_signal(signal.SIGTERM)
            if self.wait(within) is None:
                self.process.kill()
                self.process.wait()
        return self.process.returncode


class Room:
    """The programs of one test in a temporary folder. All of them end when the room is closed."""

    def __init__(self, bin_folder):
        self.bin, self._programs = pathlib.Path(bin_folder), []
        self._folder = tempfile.TemporaryDirectory(prefix="copresence-attack-")
        self.folder = pathlib.Path(self._folder.name)

    def start(self, arguments):
        program = Program(arguments, self.folder / f"{len(self._programs)}.log")
        self._programs.append(program)
        return program

    def serve(self, *more, source=RECORDING):
        """Starts a capture_server on a free port. Returns the program and its port."""
        loop = ["--loop"] if str(source).endswith(".oni") else []
        server = self.start([self.bin / "capture_server", "--source", source, *loop, "--listen", "127.0.0.1:0",
                             *more])
        listening = server.says(r", on 127\.0\.0\.1:(\d+)", within=60)
        if not listening:
            raise RuntimeError("capture_server does not start:\n" + server.said())
        return server, int(listening.group(1))

    def view(self, *ports, more=()):
        """Starts a headless render_client for these ports. It writes its statistics to stats.json in the folder."""
        connect = [word for port in ports for word in ("--connect", f"127.0.0.1:{port}")]
        return self.start([self.bin / "render_client", *connect, "--headless", "--size", "320x240",
                           "--stats", self.folder / "stats.json", *more])

    def stats(self):
        return json.loads((self.folder / "stats.json").read_text())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for program in reversed(self._programs):
            program.end()
        self._folder.cleanup()


def child_of(pid):
    """The first child of a process, or None."""
    try:
        children = pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:
        return None
    return int(children[0]) if children else None


def resident_kb(pid):
    """The resident memory of a process in KiB."""
    for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1])
    return 0


def descriptors(pid):
    return len(os.listdir(f"/proc/{pid}/fd"))


class Checks:
    """Collects the results of a test and prints each measurement as passed or failed."""

    def __init__(self):
        self.failed = 0

    def expect(self, holds, what):
        print(("ok    " if holds else "FAIL  ") + what, flush=True)
        self.failed += not holds

    def exit(self):
        sys.exit(1 if self.failed else 0)


def run(cases, description):
    """Runs a test program's command line: --bin FOLDER and the names of the cases to run, by default all. Each case is
    a function that takes a Room and Checks, and has the function's name."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")
    names = [case.__name__ for case in cases]
    parser.add_argument("cases", nargs="*", metavar="CASE", help="one of: " + ", ".join(names))
    options = parser.parse_args()
    if unknown := set(options.cases) - set(names):
        parser.error(f"no case is called {unknown.pop()}: choose from {', '.join(names)}")
    checks = Checks()
    for case in cases:
        if options.cases and case.__name__ not in options.cases:
            continue
        print(f"== {case.__name__}: {case.__doc__}", flush=True)
        begin = time.monotonic()
        with Room(options.bin) as room:
            case(room, checks)
        print(f"   {time.monotonic() - begin:.1f} s", flush=True)
    checks.exit()
