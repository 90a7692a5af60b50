#!/usr/bin/env python3
"""Measures what 50 viewers of two cameras cost: tests/web_gateway/load.py [--bin FOLDER] [CASE ...]"""
import json
import os
import pathlib
import subprocess
import sys
import time

from gateway import serve_pages
import programs
import replay

HERE = pathlib.Path(__file__).resolve().parent
PAGES, SECONDS = 50, 15


def cpu_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def fifty_viewers(room, checks):
    """50 viewers of two cameras: under 1 % of a core and 4 MB each"""
    recorded = replay.record(room)
    with replay.ReplayedCamera(*recorded) as first, replay.ReplayedCamera(*recorded) as second:
        measure(*serve_pages(room, first.port, second.port), checks)


def measure(program, gateway, checks):
    time.sleep(5)
    idle_begin = cpu_seconds(program.pid)
    time.sleep(5)
    idle = (cpu_seconds(program.pid) - idle_begin) / 5
    memory = programs.resident_kb(program.pid)
    pages = subprocess.Popen([sys.executable, HERE / "many_pages.py", str(gateway), str(PAGES), str(SECONDS)],
                             stdout=subprocess.PIPE, text=True)
    try:
        pages.stdout.readline()
        time.sleep(3)
        begin, used = time.monotonic(), cpu_seconds(program.pid)
        time.sleep(SECONDS - 5)
        share = (cpu_seconds(program.pid) - used) / (time.monotonic() - begin)
        grown = programs.resident_kb(program.pid) - memory
        result = json.loads(pages.communicate(timeout=60)[0])
    finally:
        pages.kill()
        pages.wait()
    rate = min(result["frames"]) / SECONDS / 2
    print(f"   without viewers {100 * idle:.1f} % of a core, {memory} kB; the slowest page got {rate:.1f} frames a "
          f"second of each camera; delay from encoding to page p50 {result['delay_ms'][0]:.1f} ms, "
          f"p99 {result['delay_ms'][1]:.1f} ms")
    checks.expect(100 * (share - idle) / PAGES < 1, f"{100 * (share - idle) / PAGES:.2f} % of a core for each viewer")
    checks.expect(grown / PAGES < 4096, f"{grown / PAGES:.0f} kB for each viewer")
    checks.expect(rate > 15, "every page gets frames at a steady rate")


if __name__ == "__main__":
    programs.run([fifty_viewers], __doc__)
