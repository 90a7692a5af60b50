#!/usr/bin/env python3
"""Runs the commands of the documentation's pages and compares their output with the pages. Each page gets a
folder of its own: a copy of the project with this build as build/release. Its commands run in order in one
shell. They have a network namespace of their own if the system allows it; otherwise the ports that pages
name must be free.

  tests/docs/commands.py                        all pages, without the fences marked soak
  tests/docs/commands.py docs/guide/keys.md     one page
  tests/docs/commands.py --soak                 all fences
  tests/docs/commands.py --marks                run nothing; check notes, program names and flags

tests/docs/page.py describes the notes that pages give to this test. The test differs from a reader in two
ways:

- capture_server runs in the background until the page ends or another server takes its address;
- render_client gets --frames 5 and --headless unless the page gives them.

Exit code 0 means that every command ended as its page says."""
import argparse
import ctypes
import fcntl
import os
import pathlib
import re
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import time

import page as pages
from terminal import CommandFault, Terminal

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
LIMIT_S, SOAK_LIMIT_S = 600, 3600
NOT_COPIED = shutil.ignore_patterns("build", ".git", "__pycache__", "shared")


def enter_own_network():
    """Enters a network namespace with only a loopback interface. Returns False if the system does not allow it."""
    new_user, new_net = 0x10000000, 0x40000000
    uid, gid = os.getuid(), os.getgid()
    libc = ctypes.CDLL(None, use_errno=True)
    if uid == 0:
        if libc.unshare(new_net):
            return False
    else:
        if libc.unshare(new_user | new_net):
            return False
        pathlib.Path("/proc/self/setgroups").write_text("deny")
        pathlib.Path("/proc/self/uid_map").write_text(f"{uid} {uid} 1")
        pathlib.Path("/proc/self/gid_map").write_text(f"{gid} {gid} 1")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        siocgifflags, siocsifflags, up = 0x8913, 0x8914, 0x1
        request = bytearray(struct.pack("16sh14x", b"lo", 0))
        fcntl.ioctl(any_socket, siocgifflags, request)
        flags = struct.unpack_from("16xh", request)[0]
        fcntl.ioctl(any_socket, siocsifflags, struct.pack("16sh14x", b"lo", flags | up))
    return True


def program_of(command):
    """The program's name, without its folder and without variables before it."""
    words = [word for word in command.split() if not re.match(r"\w+=", word)]
    return words[0].rsplit("/", 1)[-1] if words else ""


def is_server(command):
    return (program_of(command) in ("capture_server", "web_gateway") and
            not re.search(r"--(list|help|version|make-key|make-token)\b", command))


def command_for_test(command):
    if program_of(command) == "render_client" and not re.search(r"--(help|version)\b", command):
        command = re.sub(r"\s#.*$", "", command)
        command += "" if "--frames" in command else " --frames 5"
        command += "" if "--headless" in command else " --headless"
    return command


def shows(output, shown):
    """Returns the first line of a console fence that a command did not print, or None. Numbers may differ."""
    said = output.splitlines()
    at = 0
    for line in [line for line in shown if line.strip()]:
        pattern = re.sub(r"\d+(\\\.\d+)?", r"\\d+(\\.\\d+)?", re.escape(" ".join(line.split())))
        while at < len(said) and not re.fullmatch(pattern, " ".join(said[at].split())):
            at += 1
        if at == len(said):
            return line
    return None


class PageRun:
    def __init__(self, page, folder, build, soak):
        self.page, self.soak = page, soak
        self.home, self.logs, self.kinects = folder / "copresence", folder / "logs", folder / "kinects"
        self.logs.mkdir()
        self.kinects.mkdir()
        shutil.copytree(ROOT, self.home, ignore=NOT_COPIED, symlinks=True)
        (self.home / "build").mkdir()
        (self.home / "build/release").symlink_to(build)
        environment = {**os.environ, "LD_LIBRARY_PATH": str(build / "tests/fake_freenect"),
                       "COPRESENCE_FAKE_KINECTS": str(self.kinects), "LC_ALL": "C.UTF-8"}
        environment.pop("DISPLAY", None)
        environment.pop("WAYLAND_DISPLAY", None)
        self.terminal = Terminal(self.home, self.logs, environment)

    def run(self):
        """Returns a list of faults, one text for each."""
        faults = []
        try:
            for fence in pages.read(self.page):
                if fence.skip or (fence.soak and not self.soak):
                    continue
                fault = self.run_fence(fence)
                if fault:
                    faults.append(f"{self.page.relative_to(ROOT)}:{fence.line}: {fault}")
                    break  # later fences may need this one
            if not faults:
                self.terminal.stop_all()
        except CommandFault as fault:
            faults.append(f"{self.page.relative_to(ROOT)}: {fault}")
        finally:
            self.terminal.close()
        return faults

    def run_fence(self, fence):
        limit_s = SOAK_LIMIT_S if fence.soak else LIMIT_S
        for serial in fence.kinects:
            (self.kinects / serial).touch()
        for command in fence.setup:
            fault, _ = self.run_command(command, 0, limit_s)
            if fault:
                return f"setup: {fault}"
        if fence.fresh:
            self.terminal.stop_all()
        said = ""
        for command in fence.commands:
            fault, output = self.run_command(command, fence.exit_code, limit_s)
            if fault:
                return fault
            said += output
        missing = None if fence.output_varies else shows(said, fence.output)
        return f"the page shows \"{missing}\", but the commands printed:\n{said[-2000:]}" if missing else None

    def run_command(self, command, exit_code, limit_s):
        """Returns the fault or None, and the output."""
        began = time.monotonic()
        try:
            if is_server(command) and exit_code == 0:
                fault = self.terminal.serve(re.sub(r"\s*&\s*$", "", re.sub(r"\s#.*$", "", command)), 60)
                return (f"{command}: {fault}" if fault else None), ""
            code, output = self.terminal.run(command_for_test(command), limit_s)
        except CommandFault as fault:
            return f"{command}: {fault}", ""
        print(f"  {time.monotonic() - began:6.1f} s  {command[:100]}", flush=True)
        if code != exit_code:
            return f"{command}: exit code {code} instead of {exit_code}: {output[-1500:]}", output
        return None, output


# ---- code in sentences

PROGRAMS = ("capture_server", "render_client", "web_gateway", "calibrate", "record", "depth_bench",
            "simulate_kinect")
VERBS = {"calibrate": ("intrinsics", "markers", "refine", "check"), "record": ("info", "repair", "cut", "from-images")}


def help_of(build, program, verb, known={}):
    if (program, verb) not in known:
        known[program, verb] = subprocess.run([build / "bin" / program, *([verb] if verb else []), "--help"],
                                              capture_output=True, text=True).stdout
    return known[program, verb]


def code_faults(page, build, tests):
    """Checks code spans that name a program of this project: its flags and its tests must exist."""
    for line, code in pages.inline_code(page):
        where = f"{page.relative_to(ROOT)}:{line}: `{code}`"
        words = code.split()
        program = words[0].rsplit("/", 1)[-1] if words else ""
        if program == "ctest":
            named = re.search(r"-R '?([^' ]+)'?", code)
            if named and not re.search(r"--preset", code):
                yield f"{where}: finds no test without --preset"
            if named and not any(re.search(named[1], test) for test in tests):
                yield f"{where}: no test has this name"
        elif program in PROGRAMS and len(words) > 1:
            verbs = VERBS.get(program)
            verb = words[1] if verbs and words[1] in verbs else None
            flags = re.findall(r"(?<![\w-])--[a-z][a-z-]+", code)
            if verbs and not verb and flags and not set(flags) <= {"--help", "--version"}:
                continue  # it is about all verbs
            for flag in flags:
                if not re.search(rf"{flag}\b(?!-)", help_of(build, program, verb)):
                    yield f"{where}: {program} has no {flag}"


def list_tests(build):
    listed = subprocess.run(["ctest", "--test-dir", build, "-N"], capture_output=True, text=True).stdout
    return re.findall(r"Test +#\d+: (\S+)", listed)


def check_marks(page_files, build):
    faults, tests = [], list_tests(build)
    for page in page_files:
        try:
            pages.read(page)
        except pages.PageFault as fault:
            faults.append(str(fault))
        faults += code_faults(page, build, tests)
    print("\n".join(faults) or f"{len(page_files)} pages: every fence has a language and known notes")
    return faults


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", nargs="*", type=pathlib.Path)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build/release")
    parser.add_argument("--soak", action="store_true", help="run long fences, too")
    parser.add_argument("--marks", action="store_true", help="run nothing; check notes, program names and flags")
    parser.add_argument("--keep", action="store_true", help="keep the pages' folders and print their paths")
    options = parser.parse_args()
    page_files = [page.resolve() for page in options.pages] or pages.all_pages(ROOT)
    if options.marks:
        return 1 if check_marks(page_files, options.build.resolve()) else 0
    if not enter_own_network():
        print("cannot create a network namespace: the ports that the pages name must be free")
    faults = []
    for page in page_files:
        print(page.relative_to(ROOT), flush=True)
        folder = pathlib.Path(tempfile.mkdtemp(prefix="copresence_docs_"))
        try:
            faults += PageRun(page, folder, options.build.resolve(), options.soak).run()
        except pages.PageFault as fault:
            faults.append(str(fault))
        finally:
            if options.keep:
                print(f"  {folder}")
            else:
                shutil.rmtree(folder, ignore_errors=True)
    print("\n".join(faults) or f"{len(page_files)} pages: every command ended as its page says")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
