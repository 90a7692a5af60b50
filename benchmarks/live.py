#!/usr/bin/env python3
"""Live benchmark: capture servers replay recordings at normal speed, and one headless client on the same machine
renders them. Prints the figures of docs/internals/latency.md.

  benchmarks/live.py                   two cameras at 1280x720, then four at 640x360, 20 s each
  benchmarks/live.py --seconds 600     to find latency or memory that grows with time
  benchmarks/live.py --apart 16.7      cameras out of sync by half a frame period, the most possible
  benchmarks/live.py --encryption 5    two cameras with and without a room key, in five pairs of runs: medians of the
                                       processor time and of the latency
"""
import argparse
import json
import os
import pathlib
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
BIN = ROOT / "build/release/bin"
REAL = pathlib.Path(os.environ.get("COPRESENCE_RECORDINGS", ROOT / "../shared/recordings"))
OWN = ROOT / "data/recordings"


def recordings(count):
    if (REAL / "office.oni").exists():
        return [REAL / f"{name}.oni" for name in ("office", "desk", "office", "person")][:count]
    print("the real recordings are not here: the simulated ones are used", file=sys.stderr)
    return [OWN / f"camera{index % 2}.oni" for index in range(count)]


class Memory(threading.Thread):
    """Samples the resident memory of processes and their children, MB."""

    def __init__(self, pids):
        super().__init__(daemon=True)
        self.pids, self.seen = pids, {pid: [] for pid in pids}

    def run(self):
        while True:
            for pid in self.pids:
                total = sum(self.resident(each) for each in [pid] + self.children(pid))
                if total:
                    self.seen[pid].append(total)
            time.sleep(1)

    @staticmethod
    def children(pid):
        try:
            return [int(word) for word in pathlib.Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
        except OSError:
            return []

    @staticmethod
    def resident(pid):
        try:
            for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
                if line.startswith("VmRSS:"):
                    return int(line.split()[1]) / 1024
        except OSError:
            pass
        return 0


def run(count, size, seconds, port, extra, apart_ms, key=None):
    """Prints the figures of one run. Returns the processor time in cores and the p95 of the latency in ms, of the
    camera where it is larger."""
    files = recordings(count)
    with_key = ["--key", key] if key else []
    first_begins = time.time() + 3

    def beginning(index):
        return [] if apart_ms is None else ["--start-at", f"{first_begins + index * apart_ms / 1000:.4f}"]

    servers = [subprocess.Popen([BIN / "capture_server", "--source", file, "--name", f"{file.stem}-{index}", "--loop",
                                 "--listen", f"127.0.0.1:{port + index}", *beginning(index), *with_key],
                                stderr=subprocess.DEVNULL)
               for index, file in enumerate(files)]
    if apart_ms is not None:
        time.sleep(3)
    connect = [word for index in range(count) for word in ("--connect", f"127.0.0.1:{port + index}")]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.time()
    with tempfile.TemporaryDirectory() as folder:
        stats = pathlib.Path(folder) / "stats.json"
        client = subprocess.Popen([BIN / "render_client", *connect, "--headless", "--size", size, "--stats", stats,
                                   "--frames", str(int(seconds * 30)), *with_key, *extra], stderr=subprocess.DEVNULL)
        memory = Memory([client.pid] + [server.pid for server in servers])
        memory.start()
        client.wait()
        wall = time.time() - begin
        for server in servers:
            server.send_signal(signal.SIGTERM)
        for server in servers:
            server.wait()
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        figures = json.loads(stats.read_text())
        report(figures, count)
    cores = (used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime) / wall
    print(f"  all processes together: {cores:.2f} cores")
    for name, pid in [("client", client.pid)] + [(f"server {i}", s.pid) for i, s in enumerate(servers)]:
        seen = memory.seen[pid]
        if len(seen) > 2:
            print(f"  memory of {name}: {seen[min(10, len(seen) // 2)]:.0f} MB early, {seen[-1]:.0f} MB at the end, "
                  f"{max(seen):.0f} MB at most")
    return cores, max(camera["latency_ms"]["p95"] for camera in figures["cameras"])


def compare_encryption(pairs, seconds, extra):
    """Runs with and without a key in turns, since a machine's speed changes with time."""
    with tempfile.TemporaryDirectory() as folder:
        key = pathlib.Path(folder) / "room.key"
        subprocess.run([BIN / "capture_server", "--make-key", key], check=True)
        plain, encrypted = [], []
        for pair in range(pairs):
            turns = [(None, plain), (key, encrypted)]
            for with_key, results in reversed(turns) if pair % 2 else turns:
                results.append(run(2, "1280x720", seconds, 7501, extra, None, with_key))
    cores = statistics.median(a[0] / b[0] for a, b in zip(encrypted, plain))
    p95 = statistics.median(a[1] - b[1] for a, b in zip(encrypted, plain))
    print(f"\nencryption: {cores:.3f} times the processor time, {p95:+.1f} ms in the p95 of the latency "
          f"(medians of {pairs} pairs)")


def report(stats, count):
    view = stats["view"]
    print(f"\n{count} cameras, {view['size']}, {view['renderer']} renderer: {view['fps']:.2f} views a second, render "
          f"p50 {view['render_ms']['p50']:.1f} ms, p95 {view['render_ms']['p95']:.1f} ms")
    for camera in stats["cameras"]:
        latency = camera["latency_ms"]
        print(f"  {camera['name']:<10} {camera['mbps']:5.2f} Mbit/s, dropped {camera['frames_dropped']} of "
              f"{camera['frames_captured']} {camera['drops']}, unshown {camera['frames_unshown']}, latency p50 "
              f"{latency['p50']:.1f}, p95 {latency['p95']:.1f}, p99 {latency['p99']:.1f} ms")
        print("             stages p50/p95 ms: " + ", ".join(
            f"{stage} {value['p50']:.2f}/{value['p95']:.2f}" for stage, value in camera["stages_ms"].items()))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--only", choices=["two", "four"])
    parser.add_argument("--apart", type=float, metavar="MS",
                        help="each recording begins so long after the one before it, instead of in step")
    parser.add_argument("--encryption", type=int, metavar="PAIRS", help="compare with and without a room key")
    parser.add_argument("client", nargs="*", help="further arguments for render_client, after --")
    options = parser.parse_args()
    if options.encryption:
        return compare_encryption(options.encryption, options.seconds, options.client)
    if options.only != "four":
        run(2, "1280x720", options.seconds, 7501, options.client, options.apart)
    if options.only != "two":
        run(4, "640x360", options.seconds, 7511, options.client, options.apart)


if __name__ == "__main__":
    main()
