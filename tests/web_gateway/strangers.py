#!/usr/bin/env python3
"""Attacks web_gateway without its token, while a viewer watches:
tests/web_gateway/strangers.py [--bin FOLDER] [CASE ...]

Each case expects that the viewer is undisturbed, that no room data leaves, and that memory does not grow."""
import socket
import sys
import threading
import time

from gateway import refusal, serve_pages, with_token
from page import TEXT, Page, Refused, WebSocket, connect, get
import programs
import replay

MOST_GROWTH_KB = 10_000
REQUESTS = 10_000


class Watched:
    """A gateway with a token, one viewer, and what both did from begin to end."""

    def __init__(self, room, checks):
        self.checks = checks
        self.camera = replay.ReplayedCamera(*replay.record(room))
        self.token, options = with_token(room)
        self.program, self.port = serve_pages(room, self.camera.port, more=options)

    def __enter__(self):
        self.page = Page(self.port, self.token)
        self.checks.expect(self.page.wait_for_frames(60, 30), "the viewer watches")
        self.memory, self.begin = programs.resident_kb(self.program.pid), time.monotonic()
        return self

    def __exit__(self, kind, *_):
        if kind is None:
            end = time.monotonic()
            frames = self.page.between(self.begin, end)
            rate = len(frames) / (end - self.begin)
            gap = max((b.at - a.at for a, b in zip(frames, frames[1:])), default=float("inf"))
            grown = programs.resident_kb(self.program.pid) - self.memory
            self.checks.expect(self.page.ended == "", "the viewer stays connected")
            self.checks.expect(rate > 10 and gap < 1,
                               f"it got {rate:.1f} frames a second, longest pause {1000 * gap:.0f} ms")
            self.checks.expect(grown < MOST_GROWTH_KB, f"memory grew by {grown} kB in {end - self.begin:.0f} s")
            open_files = programs.descriptors(self.program.pid)
            self.checks.expect(open_files < 200, f"{open_files} descriptors are open")
            self.checks.expect(self.program.said().count("\n") < 60, "the log stays short")
        self.page.end()
        self.camera.end()


def in_threads(count, work):
    """Runs work(number) for the numbers below `count` on eight threads."""
    numbers = iter(range(count))
    lock = threading.Lock()

    def run():
        while True:
            with lock:
                number = next(numbers, None)
            if number is None:
                return
            try:
                work(number)
            except (OSError, ValueError, Refused):
                pass

    threads = [threading.Thread(target=run) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def many_requests(room, checks):
    """10,000 requests and sockets: files, paths that leave the folder, other origins, no token, a wrong token"""
    paths = ["/", "/../../../etc/passwd", "/index.html", "/%2e%2e/secret", "/room", "/x" * 200]
    leaks = []

    def ask(number):
        if number % 4 == 3:
            web = WebSocket(watched.port)
            if number % 8 == 3:
                web.send(TEXT, b'{"type":"join","token":"' + b"0" * 64 + b'"}')
                opcode, payload = web.receive()
                if b'"refused"' not in payload:
                    leaks.append(payload[:80])
            web.close()
        elif number % 4 == 2:
            status, _, _ = get(watched.port, Origin="http://attacker.example")
            if status != 403:
                leaks.append(status)
        else:
            status, _, body = get(watched.port, paths[number // 4 % len(paths)])
            if b"root:" in body:
                leaks.append(body[:80])

    with Watched(room, checks) as watched:
        in_threads(REQUESTS, ask)
        checks.expect(not leaks, f"no room data and no other file: {leaks[:3]}")


def slow_and_huge_headers(room, checks):
    """headers that come byte by byte, headers without end, and requests that never end"""
    with Watched(room, checks) as watched:
        slow = []
        for number in range(100):
            connection = connect(watched.port)
            connection.sendall(b"GET / HTTP/1.1\r\nHost: x\r\n")
            slow.append(connection)
        limit = time.monotonic() + 8
        while time.monotonic() < limit:
            for connection in slow:
                try:
                    connection.sendall(b"X")
                except OSError:
                    pass
            time.sleep(0.5)
        still_open = 0
        for connection in slow:
            connection.settimeout(0.1)
            try:
                still_open += connection.recv(1) != b""
            except socket.timeout:
                still_open += 1
            except OSError:
                pass
            connection.close()
        checks.expect(still_open == 0, f"{still_open} of 100 slow requests are still open after 8 s")

        def send_much(_):
            with connect(watched.port) as connection:
                connection.sendall(b"GET / HTTP/1.1\r\n")
                for _ in range(200):
                    connection.sendall(b"X-Header: " + b"y" * 5000 + b"\r\n")

        in_threads(500, send_much)


def sockets_that_stay(room, checks):
    """2,000 WebSockets that send nothing, or pings only, or too much: the viewer and honest newcomers see the room"""
    with Watched(room, checks) as watched:
        kept = []

        def stay(number):
            web = WebSocket(watched.port)
            kept.append(web)
            if number % 3 == 1:
                web.send(9, b"ping")
            elif number % 3 == 2:
                web.send(TEXT, b"x" * 60000)

        in_threads(2000, stay)
        with Page(watched.port, watched.token) as honest:
            checks.expect(honest.wait_for_frames(10, 10), "a newcomer with the token sees the room")
        checks.expect(refusal(watched.port, "")[0] == "token", "one without it does not")
        time.sleep(6)
        checks.expect(programs.descriptors(watched.program.pid) < 40, "silent sockets are closed")
        for web in kept:
            web.close()


if __name__ == "__main__":
    programs.run([many_requests, slow_and_huge_headers, sockets_that_stay], __doc__)
