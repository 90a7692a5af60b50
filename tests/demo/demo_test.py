#!/usr/bin/env python3
"""Tests the demo over loopback. If its usual ports are taken, the demo must use others. If a
server cannot start, the demo must end with that server's message.

  tests/demo/demo_test.py --bin build/release/bin"""
import argparse
import os
import pathlib
import socket
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def demo(bin_folder, *options):
    environment = {key: value for key, value in os.environ.items() if key not in ("DISPLAY", "WAYLAND_DISPLAY")}
    return subprocess.run([sys.executable, ROOT / "tools/demo.py", "--bin", bin_folder, *options], env=environment,
                          capture_output=True, text=True, timeout=150)


def listen_on_any_port():
    taken = socket.socket()
    taken.bind(("127.0.0.1", 0))
    taken.listen()
    return taken, taken.getsockname()[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")
    bin_folder = parser.parse_args().bin.resolve()
    faults = []

    taken, port = listen_on_any_port()
    with taken:
        refused = demo(bin_folder, "--port", str(port))
        last = (refused.stderr.splitlines() or [""])[-1]
        if refused.returncode != 1 or "the server of camera0 has ended" not in last or str(port) not in last:
            faults.append(f"with a taken port: exit code {refused.returncode}, {last}")

    usual = [socket.socket() for _ in (7001, 7002)]
    for port, blocker in zip((7001, 7002), usual):
        try:
            blocker.bind(("127.0.0.1", port))
            blocker.listen()
        except OSError:
            pass  # another program has it already, which is as good
    shown = demo(bin_folder)
    if shown.returncode != 0 or "views a second" not in shown.stdout or shown.stdout.count("camera") < 2:
        faults.append(f"with the usual ports taken: exit code {shown.returncode}, "
                      f"{shown.stdout[-500:]}{shown.stderr[-1500:]}")
    for blocker in usual:
        blocker.close()

    wrong = demo(bin_folder, "--port", "70000")
    if wrong.returncode != 2 or "not a port" not in wrong.stderr:
        faults.append(f"--port 70000: exit code {wrong.returncode}, {wrong.stderr}")
    print("\n".join(faults) or "the demo runs, and ends with a reason where it cannot")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
