#!/usr/bin/env python3
"""Shows the whole system: two capture servers replay data/recordings, and one client shows the room. With
--simulated the servers run live simulated cameras in the same poses. With a display, the client opens a window,
and closing the window ends the demo. Without a display, the client renders along a path and writes the last view to a
picture. At the end the demo prints a table of views per second, bitrate and latency. With --browser the web gateway
takes the client's place, and the demo prints the address to open until Ctrl+C ends it."""
import argparse
import collections
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
RECORDINGS = ROOT / "data/recordings"
PICTURE = ROOT / "build/demo.png"
CAMERAS = ("camera0", "camera1")
FIRST_PORT = 7001
WEB_PORT = 8080
VIEWS = 300
HEADLESS_LIMIT_S = 300  # The views take ten seconds; a longer run has hung.


def is_free(port):
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("127.0.0.1", port))
        except OSError:
            return False
    return True


def any_free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def choose_ports(first):
    """Returns one port per camera: from `first` on if given, else 7001 and 7002, or other free ports."""
    if first:
        return [first + i for i in range(len(CAMERAS))]
    return [port if is_free(port) else any_free_port() for port in range(FIRST_PORT, FIRST_PORT + len(CAMERAS))]


class Server:
    """A running capture_server. Its log goes to the terminal."""

    def __init__(self, name, command):
        self.name = name
        self.last_lines = collections.deque(maxlen=3)
        self.process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, errors="replace")
        self.reader = threading.Thread(target=self.pass_on_log, daemon=True)
        self.reader.start()

    def pass_on_log(self):
        for line in self.process.stderr:
            self.last_lines.append(line.strip())
            print(f"{self.name}: {line}", end="", file=sys.stderr)

    def has_ended(self):
        return self.process.poll() is not None

    def last_words(self):
        self.reader.join(1)
        return " ".join(self.last_lines) or f"exit code {self.process.returncode}"

    def stop(self):
        if not self.has_ended():
            self.process.send_signal(signal.SIGTERM)

    def wait(self):
        try:
            self.process.wait(3)
        except subprocess.TimeoutExpired:
            self.process.kill()


def start_servers(options, ports):
    begin = time.time() + 2  # A common start of playback; otherwise the person would appear twice.
    servers = []
    for index, (camera, port) in enumerate(zip(CAMERAS, ports)):
        source = ["--source", f"simulated:room?camera={index}"] if options.simulated else [
            "--source", RECORDINGS / f"{camera}.oni", "--loop", "--start-at", f"{begin:.3f}"]
        servers.append(Server(camera, [options.bin / "capture_server", *source, "--name", camera, "--scene",
                                       RECORDINGS / "scene.toml", "--listen", f"127.0.0.1:{port}"]))
    return servers


def client_command(options, ports, stats):
    connect = [word for port in ports for word in ("--connect", f"127.0.0.1:{port}")]
    return [options.bin / "render_client", *connect, "--scene", RECORDINGS / "scene.toml", "--stats", stats,
            "--screenshot", PICTURE]


def watch(client, servers, limit_s):
    """Waits until the client ends. Returns an error message if it has to be stopped, else None."""
    begin = time.monotonic()
    while client.poll() is None:
        gone = next((server for server in servers if server.has_ended()), None)
        if gone:
            return f"the server of {gone.name} has ended: {gone.last_words()}"
        if time.monotonic() - begin > limit_s:
            return f"no {VIEWS} views within {limit_s} s"
        time.sleep(0.1)
    return None


def end(process):
    process.send_signal(signal.SIGTERM)
    try:
        process.wait(5)
    except subprocess.TimeoutExpired:
        process.kill()


def table(stats):
    view = stats["view"]
    print(f"\n{view['renderer']} renderer, {view['size']}: {view['fps']:.1f} views a second, "
          f"{view['render_ms']['p50']:.1f} ms each\n")
    print(f"{'camera':<10} {'frames':>7} {'dropped':>8} {'Mbit/s':>7} {'latency p50':>12} {'p95':>6} ms")
    for camera in stats["cameras"]:
        latency = camera["latency_ms"]
        print(f"{camera['name']:<10} {camera['frames_received']:>7} {camera['frames_dropped']:>8} "
              f"{camera['mbps']:>7.2f} {latency['p50']:>12.1f} {latency['p95']:>6.1f}")


def show_room(options, folder):
    """Runs servers and client. Returns an error message if a program failed, else None."""
    ports = choose_ports(options.port)
    stats = folder / "stats.json"
    command, limit_s = client_command(options, ports, stats), float("inf")
    if os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        print("A window opens: drag to look around, right button to pan, wheel to come closer. Close it to end.")
    else:
        command += ["--headless", "--frames", str(VIEWS), "--view", f"path:{RECORDINGS / 'demo.path'}"]
        limit_s = HEADLESS_LIMIT_S
    servers = start_servers(options, ports)
    try:
        client = subprocess.Popen(command)
        try:
            failed = watch(client, servers, limit_s)
        finally:
            if client.poll() is None:
                end(client)
    finally:
        for server in servers:
            server.stop()
        for server in servers:
            server.wait()
    if failed:
        return failed
    if client.returncode or not stats.exists():
        return "the client ended without a picture; its message is above"
    table(json.loads(stats.read_text()))
    return None


def show_in_browser(options):
    """Runs servers and gateway until Ctrl+C. Returns an error message if a program has ended, else None."""
    ports = choose_ports(options.port)
    web_port = WEB_PORT if is_free(WEB_PORT) else any_free_port()
    connect = [word for port in ports for word in ("--connect", f"127.0.0.1:{port}")]
    programs = start_servers(options, ports)
    programs.append(Server("gateway", [options.bin / "web_gateway", *connect, "--listen", f"127.0.0.1:{web_port}"]))
    print(f"\nOpen http://127.0.0.1:{web_port}/ in a browser on this machine. Ctrl+C ends the demo.\n", flush=True)
    try:
        while True:
            gone = next((program for program in programs if program.has_ended()), None)
            if gone:
                return f"{gone.name} has ended: {gone.last_words()}"
            time.sleep(0.1)
    finally:
        for program in programs:
            program.stop()
        for program in programs:
            program.wait()


def main():
    parser = argparse.ArgumentParser(prog="./run demo", description=__doc__)
    parser.add_argument("--simulated", action="store_true", help="live simulated cameras instead of recordings")
    parser.add_argument("--browser", action="store_true", help="show the room in a browser instead of the client")
    parser.add_argument("--port", type=int, metavar="N",
                        help=f"the servers listen on ports N and N+1 [{FIRST_PORT} and {FIRST_PORT + 1}, or others "
                             "where these are taken]")
    parser.add_argument("--bin", type=pathlib.Path, default=ROOT / "build/release/bin", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.port is not None and not 1 <= options.port <= 65535 - len(CAMERAS) + 1:
        parser.error(f"--port: {options.port} is not a port from 1 to {65535 - len(CAMERAS) + 1}")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    if options.browser:
        sys.exit(f"demo: {show_in_browser(options)}")
    PICTURE.parent.mkdir(exist_ok=True)
    PICTURE.unlink(missing_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        failed = show_room(options, pathlib.Path(folder))
    if failed:
        sys.exit(f"demo: {failed}")
    print(f"\nThe last view is in {PICTURE.relative_to(ROOT)}")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        sys.exit(130)
