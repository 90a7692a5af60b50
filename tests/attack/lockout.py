#!/usr/bin/env python3
"""Tests attackers that try to take all slots of a server. They have the same address as the honest viewer:
tests/attack/lockout.py [--bin FOLDER] [CASE ...]"""
import re
import threading
import time

import programs
import proxy
import wire

# A newcomer waits for a keyframe, of which there is at most one a second. 1.3 to 2.2 s were
# measured with 23 busy processes on 2 cores.
ENTRY_S = 8.0


class Attackers:
    """Opens connections with `open_one` and calls `work` on each of them, until the end of the block."""

    def __init__(self, port, count, open_one, pause=0.25, work=None, renew_after=None):
        self.port, self.count, self.open_one, self.pause, self.work = port, count, open_one, pause, work
        self.renew_after, self.connections, self.opened = renew_after, [], 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def _run(self):
        began = time.monotonic()
        while not self._stop.is_set():
            if self.renew_after and time.monotonic() - began > self.renew_after:
                began = time.monotonic()
                self._close()
            while len(self.connections) < self.count and not self._stop.is_set():
                try:
                    self.connections.append(self.open_one(self.port))
                    self.opened += 1
                except OSError:
                    break
            for connection in list(self.connections):
                try:
                    if self.work:
                        self.work(connection)
                except BlockingIOError:
                    pass
                except OSError:
                    connection.close()
                    self.connections.remove(connection)
            self._stop.wait(self.pause)

    def _close(self):
        for connection in self.connections:
            connection.close()
        self.connections.clear()

    def __enter__(self):
        self._thread.start()
        limit = time.monotonic() + 10
        while self.opened < self.count and time.monotonic() < limit:
            time.sleep(0.02)
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join(5)
        self._close()


def silent(port):
    return wire.connect(port)


def greeting(port, receive_buffer=None):
    connection = wire.connect(port, receive_buffer=receive_buffer)
    connection.sendall(wire.hello())
    connection.setblocking(False)
    return connection


def deaf(port):
    return greeting(port, receive_buffer=4096)


def read_all(connection):
    while connection.recv(1 << 16):
        pass
    raise ConnectionError


def drip(connection):
    connection.send(wire.frame_ack(1)[:1])


def ping(connection):
    connection.send(wire.ping())


def newcomer_gets_in(port, checks, what):
    begin = time.monotonic()
    with wire.Viewer(port) as viewer:
        came = viewer.wait_for_frames(3, ENTRY_S)
        checks.expect(came, f"{what}: a newcomer's third frame came after {time.monotonic() - begin:.1f} s")
        return came


def places_held_by_bytes(room, checks):
    """32 connections that send a byte now and then after their hello"""
    _, port = room.serve()
    with Attackers(port, 32, greeting, pause=1.0, work=drip):
        newcomer_gets_in(port, checks, "32 of them")


def silent_connections_renewed(room, checks):
    """64 connections that say nothing, or nothing but hello, renewed every two seconds"""
    server, port = room.serve()
    for kind, open_one in (("no hello", silent), ("only hello", greeting)):
        with Attackers(port, 64, open_one, pause=0.1, renew_after=2.0):
            for attempt in range(2):
                newcomer_gets_in(port, checks, f"{kind}, attempt {attempt + 1}")
    line = server.says(r"\d+ connections in the last 10 s ended before the first frame was acknowledged", within=20)
    checks.expect(line is not None, "the log reports the attack")
    checks.expect(server.said().count("\n") < 60, f"in {server.said().count(chr(10))} lines")


def viewers_that_never_acknowledge(room, checks):
    """31 clients that never acknowledge, then 31 that never read; an honest viewer is reset once meanwhile"""
    server, port = room.serve()
    child = programs.child_of(server.pid)
    before = programs.resident_kb(child)
    with proxy.Proxy(port) as network, wire.Viewer(network.port) as beside:
        beside.wait_for_frames(10, 20)
        with Attackers(port, 31, greeting, pause=0.05, work=read_all):
            newcomer_gets_in(port, checks, "31 read and never acknowledge")
            seen = len(beside.arrivals)
            network.reset()
            checks.expect(beside.wait_for_frames(seen + 5, ENTRY_S), "a viewer that was reset is back")
        with Attackers(port, 31, deaf, pause=0.5, work=ping):
            newcomer_gets_in(port, checks, "31 never read")
        grown = programs.resident_kb(child) - before
        checks.expect(grown < 60_000, f"the server grew by {grown / 1000:.0f} MB")
        goes_on = beside.wait_for_frames(len(beside.arrivals) + 20, ENTRY_S)
        checks.expect(goes_on, "the viewer beside them goes on")


def log_of_viewers(room, checks):
    """the log has a line for each viewer that joins or leaves"""
    server, port = room.serve()
    with wire.Viewer(port) as viewer:
        viewer.wait_for_frames(3, 20)
        came = server.says(r"viewer 127\.0\.0\.1:\d+ connected \(1 now\)", within=5)
        checks.expect(came is not None, "came")
    left = server.says(r"viewer 127\.0\.0\.1:\d+ left after \d+ s \(0 now\)", within=5)
    checks.expect(left is not None, "left")
    checks.expect(not re.search("error|warning", server.said()), "without a warning")


if __name__ == "__main__":
    programs.run([places_held_by_bytes, silent_connections_renewed, viewers_that_never_acknowledge, log_of_viewers],
                 __doc__)
