#!/usr/bin/env python3
"""The demo: two capture servers replay data/recordings, or with --simulated are live simulated cameras at the same
places, and one client shows the room. With a display in a window, until it is closed; without one headless along a
path, into a picture. Ends with a table of what was measured."""
import argparse
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
BIN = ROOT / "build/release/bin"
RECORDINGS = ROOT / "data/recordings"
PICTURE = ROOT / "build/demo.png"
CAMERAS = ("camera0", "camera1")
VIEWS = 300


def start_servers(simulated):
    begin = time.time() + 2  # both by then, or the person would be seen at two instants
    servers = []
    for index, camera in enumerate(CAMERAS):
        source = ["--source", f"simulated:room?camera={index}"] if simulated else [
            "--source", RECORDINGS / f"{camera}.oni", "--loop", "--start-at", f"{begin:.3f}"]
        servers.append(subprocess.Popen(
            [BIN / "capture_server", *source, "--name", camera, "--scene", RECORDINGS / "scene.toml",
             "--listen", f"127.0.0.1:{7001 + index}"]))
    return servers


def stop(servers):
    for server in servers:
        server.send_signal(signal.SIGTERM)
    for server in servers:
        try:
            server.wait(3)
        except subprocess.TimeoutExpired:
            server.kill()


def client_command(stats):
    command = [BIN / "render_client", "--scene", RECORDINGS / "scene.toml", "--stats", stats, "--screenshot", PICTURE]
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        print("A window opens: drag to look around, right button to pan, wheel to come closer. Close it to end.")
        return command
    return command + ["--headless", "--frames", str(VIEWS), "--view", f"path:{RECORDINGS / 'demo.path'}"]


def table(stats):
    view = stats["view"]
    print(f"\n{view['renderer']} renderer, {view['size']}: {view['fps']:.1f} views a second, "
          f"{view['render_ms']['p50']:.1f} ms each\n")
    print(f"{'camera':<10} {'frames':>7} {'dropped':>8} {'Mbit/s':>7} {'latency p50':>12} {'p95':>6} ms")
    for camera in stats["cameras"]:
        latency = camera["latency_ms"]
        print(f"{camera['name']:<10} {camera['frames_received']:>7} {camera['frames_dropped']:>8} "
              f"{camera['mbps']:>7.2f} {latency['p50']:>12.1f} {latency['p95']:>6.1f}")


def main():
    parser = argparse.ArgumentParser(prog="./run demo", description=__doc__)
    parser.add_argument("--simulated", action="store_true", help="live simulated cameras instead of recordings")
    simulated = parser.parse_args().simulated
    PICTURE.unlink(missing_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        stats = pathlib.Path(folder) / "stats.json"
        servers = start_servers(simulated)
        try:
            client = subprocess.run(client_command(stats))
        finally:
            stop(servers)
        if client.returncode or not stats.exists():
            sys.exit("demo: the client ended without a picture; its own words stand above")
        table(json.loads(stats.read_text()))
    print(f"\nThe last view is in {PICTURE.relative_to(ROOT)}")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit(130)
