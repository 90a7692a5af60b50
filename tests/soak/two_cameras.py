#!/usr/bin/env python3
"""Checks that memory does not grow without end. Two capture servers loop recordings for one viewer, and a second
viewer connects and leaves every half minute. Prints the resident memory of each process, and how much of its
heap is in use and how much is free in the allocator.

  tests/soak/two_cameras.py                          fifteen minutes
  tests/soak/two_cameras.py --seconds 40             as the test does

Resident memory grows in steps while the allocator meets the largest frames so far. It must level off: from
the third quarter of the run to the last, memory in use may grow by at most 20 kB a minute and resident
memory by at most 150 (in runs below five minutes by 12 MB in all). The exit code is 0 if memory levels off."""
import argparse
import json
import os
import pathlib
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
EVERY_S, VIEWER_EVERY_S, VIEWS = 5, 30, 60
IN_USE_KB_A_MINUTE, RESIDENT_KB_A_MINUTE, SHORT_RUN_KB = 20, 150, 12_000


def children_of(pid):
    try:
        return [int(child) for child in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
    except OSError:
        return []


def resident_kb(pid):
    status = pathlib.Path(f"/proc/{pid}/status").read_text()
    return int(re.search(r"RssAnon:\s+(\d+)", status)[1])


def descriptors(pid):
    return len(list(pathlib.Path(f"/proc/{pid}/fd").iterdir()))


def heap_kb(folder, pid):
    """Returns the last reported heap in use, and heap free in the allocator."""
    try:
        last = pathlib.Path(f"{folder}/heap.{pid}").read_text().split("\n")[-2].split()
        return (int(last[1]) + int(last[3])) // 1024, int(last[2]) // 1024
    except (OSError, IndexError):
        return 0, 0


def growth_a_minute(samples, column, seconds):
    """Returns the growth in kB a minute, from the median of the run's third quarter to that of the last. Medians
    even out frames."""
    quarter = [[row[column] for row in samples if begin * seconds <= row[0] < end * seconds]
               for begin, end in ((0.5, 0.75), (0.75, 1.01))]
    if not all(quarter):
        return None
    third, last = map(statistics.median, quarter)
    return (last - third) / (seconds / 4 / 60)


def fault_of(name, samples, column, most, seconds):
    what = ("resident memory", "memory in use")[column - 1]
    growth = growth_a_minute(samples, column, seconds)
    if growth is None:
        return f"{name}: no samples"
    allowed = max(most, SHORT_RUN_KB / (seconds / 4 / 60) if seconds < 300 else 0)
    print(f"{name:<8} {what}: {growth:+.0f} kB a minute at the end, {allowed:.0f} allowed")
    return f"{name}: {what} grows by {growth:.0f} kB a minute" if growth > allowed else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="*", default=[str(ROOT / f"data/recordings/camera{i}.oni") for i in (0, 1)])
    parser.add_argument("--seconds", type=float, default=900)
    parser.add_argument("--port", type=int, default=7960)
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin")
    parser.add_argument("--probe", type=pathlib.Path, default=ROOT / "build/release/tests/libheap_probe.so")
    parser.add_argument("--json", type=pathlib.Path, help="write all samples here")
    options = parser.parse_args()
    faults, processes = [], {}
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "LD_PRELOAD": str(options.probe.resolve()),
                       "COPRESENCE_HEAP_PROBE": f"{folder}/heap"}

        def start(name, *command):
            processes[name] = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL,
                                               stderr=open(f"{folder}/{name}.log", "w"))

        connect = []
        for index, recording in enumerate(options.recordings):
            address = f"127.0.0.1:{options.port + index}"
            start(f"server{index}", options.bin / "capture_server", "--source", recording, "--loop",
                  "--listen", address)
            connect += ["--connect", address]
        viewer = [options.bin / "render_client", *connect, "--headless"]
        start("client", *viewer, "--stats", f"{folder}/stats.json")
        samples = {}
        begin = time.monotonic()
        guest, guest_at = None, VIEWER_EVERY_S
        while (now := time.monotonic() - begin) < options.seconds:
            time.sleep(EVERY_S)
            if now > guest_at and (guest is None or guest.poll() is not None):
                guest = subprocess.Popen([*viewer, "--size", "320x180", "--frames", str(VIEWS)],
                                         stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                guest_at = now + VIEWER_EVERY_S
            for name, process in processes.items():
                if process.poll() is not None:
                    faults.append(f"{name} has ended: {pathlib.Path(folder, name + '.log').read_text()[-300:]}")
                    continue
                # What works in a server is its child.
                for pid in [*children_of(process.pid), process.pid][:1]:
                    in_use, free = heap_kb(folder, pid)
                    samples.setdefault(name, []).append((now, resident_kb(pid), in_use, free, descriptors(pid)))
            if faults:
                break
        if guest and guest.poll() is None:
            guest.kill()
        for name, process in processes.items():
            process.send_signal(signal.SIGTERM)
        for name, process in processes.items():
            try:
                process.wait(30)
            except subprocess.TimeoutExpired:
                process.kill()
                faults.append(f"{name} did not stop")
        stats = pathlib.Path(folder, "stats.json")
        if stats.exists():
            shown = json.loads(stats.read_text())
            print(f"{shown['view']['fps']:.1f} views a second, unaccounted "
                  f"{[camera['drops']['unaccounted'] for camera in shown['cameras']]}")
    print("process   seconds  resident kB  in use kB  free kB  descriptors")
    for name, rows in samples.items():
        for row in rows[::max(1, len(rows) // 10)]:
            print(f"{name:<8} {row[0]:8.0f} {row[1]:12} {row[2]:10} {row[3]:8} {row[4]:12}")
    if options.json:
        options.json.write_text(json.dumps(samples))
    for name, rows in samples.items():
        faults += [fault for fault in (fault_of(name, rows, 1, RESIDENT_KB_A_MINUTE, options.seconds),
                                       fault_of(name, rows, 2, IN_USE_KB_A_MINUTE, options.seconds)) if fault]
    print("\n".join(faults) or "memory levels off")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
