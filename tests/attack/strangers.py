#!/usr/bin/env python3
"""Tests room keys with the real programs, and strangers who have none. The strangers have the same address as the
honest viewer unless a test says otherwise.

  tests/attack/strangers.py [--bin FOLDER] [CASE ...]                   as the tests do
  tests/attack/strangers.py --connections 10000 --rate 200 hammering     as ./run soak does"""
import argparse
import pathlib
import random
import subprocess
import threading
import time

import encrypted
import programs
import wire

MOST_GROWTH_KB = 10_000
MOST_MORE_P99_S = 0.010
# In turns, since a machine's speed changes with time. Fewer connections take too short for a meaningful p99.
ROUNDS, FEWEST_FOR_P99 = 5, 5000


def make_key(room, name="room.key"):
    path = room.folder / name
    subprocess.run([room.bin / "capture_server", "--make-key", path], check=True)
    return path


def strangers_words(key_file):
    """What strangers say first, by kind. None of them has the key."""
    with_the_key = encrypted.client_hello(encrypted.digits_of(key_file))
    another = encrypted.client_hello(encrypted.ANOTHER_KEY)
    dice = random.Random(1)
    return {
        "nothing": b"",
        "garbage": dice.randbytes(3000),
        "garbage like TLS": b"\x16\x03\x01" + dice.randbytes(3000),
        "a plain hello": wire.hello(),
        "a ClientHello of another key": another,
        "half a ClientHello": another[:100],
        "a ClientHello that claims 16 KiB": b"\x16\x03\x01\x40\x00\x01\x00\x3f\xfc" + bytes(1000),
        "the recorded ClientHello of a viewer": with_the_key,
    }


def right_wrong_and_no_key(room, checks):
    """the right key shows the room; another key, no key, and a key for a server without one end the client with a
    sentence; no key appears in logs and process lists"""
    right, wrong = make_key(room), make_key(room, "other.key")
    server, port = room.serve("--key", right)
    plain, plain_port = room.serve()
    said = []

    def client_says(what, code, sentence, port, *more):
        client = room.view(port, more=["--frames", "10", *more])
        commands = pathlib.Path(f"/proc/{client.pid}/cmdline").read_bytes()
        ended = client.wait(60)
        checks.expect(ended == code, f"{what}: exit {ended}")
        last = client.said().splitlines()[-1] if sentence else ""
        checks.expect(sentence in last, f"{what}: {last}")
        said.append(client.said() + commands.decode(errors="replace"))

    client_says("the right key", 0, "", port, "--key", right)
    client_says("another key", 1, "the server has another room key", port, "--key", wrong)
    client_says("no key", 1, "this server needs the room's key", port)
    client_says("a key for a server without one", 1, "the server has no key", plain_port, "--key", right)
    for reason in ("had another room key", "came without the room's key"):
        checks.expect(server.says(reason, within=20) is not None, f"the server's log: {reason}")
    checks.expect(plain.says("had a room key, which this server has not", within=20) is not None,
                  "the log of the server without a key says it, too")
    said.append(server.said())
    digits = encrypted.digits_of(right)
    checks.expect(not any(digits[:8] in text or digits in text for text in said), "nobody wrote the key")


def openssl_is_a_viewer(room, checks):
    """another TLS program with the key gets frames; without encryption in between, nothing is readable"""
    key = make_key(room)
    _, port = room.serve("--key", key)
    with wire.Viewer(port, key=encrypted.digits_of(key)) as viewer:
        checks.expect(viewer.wait_for_frames(10, 20), "ten frames arrive")


class Crowd:
    """Holds `count` connections of strangers of all kinds, who also send a byte now and then. A connection that the
    server closes is opened again. Runs until the end of the block."""

    def __init__(self, port, words, count):
        self.port, self.words, self.count = port, list(words.values()), count
        self.opened = 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def _run(self):
        held = []
        while not self._stop.is_set():
            while len(held) < self.count and not self._stop.is_set():
                try:
                    connection = wire.connect(self.port)
                    connection.sendall(self.words[self.opened % len(self.words)])
                    connection.setblocking(False)
                    held.append(connection)
                    self.opened += 1
                except OSError:
                    break
            for connection in list(held):
                try:
                    connection.send(b"\x16")
                    if not connection.recv(4096):
                        raise ConnectionError
                except BlockingIOError:
                    pass
                except OSError:
                    connection.close()
                    held.remove(connection)
            self._stop.wait(0.1)
        for connection in held:
            connection.close()

    def __enter__(self):
        self._thread.start()
        limit = time.monotonic() + 20
        while self.opened < self.count and time.monotonic() < limit:
            time.sleep(0.02)
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join(10)


def admitted_within(port, digits):
    """Returns the seconds until a viewer with the key gets its welcome, and until its first frame."""
    begin = time.monotonic()
    with wire.Viewer(port, key=digits) as viewer:
        viewer.wait_for_frames(1, 10)
        welcome = next((at for at, what in viewer.events if what == "welcome"), float("inf"))
        first = viewer.arrivals[0].at if viewer.arrivals else float("inf")
    return welcome - begin, first - begin


def two_hundred_at_once(room, checks):
    """while 200 strangers hold connections and renew them, honest viewers are admitted within a second"""
    key = make_key(room)
    digits, words = encrypted.digits_of(key), strangers_words(key)
    server, port = room.serve("--key", key)
    child = programs.child_of(server.pid)
    with wire.Viewer(port, key=digits) as beside:
        checks.expect(beside.wait_for_frames(10, 20), "a viewer is served")
        before = programs.resident_kb(child)
        with Crowd(port, words, 200) as crowd:
            for attempt in range(5):
                welcome, first = admitted_within(port, digits)
                checks.expect(welcome < 1, f"attempt {attempt + 1}: admitted after {welcome:.2f} s, "
                                           f"the first frame after {first:.2f} s")
        grown = programs.resident_kb(child) - before
        checks.expect(grown < MOST_GROWTH_KB, f"{crowd.opened} strangers: the server's memory grew by {grown} kB")
        lost = [what for _, what in beside.events if what != "welcome"]
        checks.expect(not lost, f"the viewer beside them was not disturbed: {lost[:3]}")
    checks.expect(programs.child_of(server.pid) == child, "the server's child is the same")
    checks.expect(server.said().count("\n") < 60, f"the log has {server.said().count(chr(10))} lines")


class Hammer:
    """Opens `rate` connections a second to a port, from 127.0.0.1 and the addresses after it, and leaves each open for
    `hold` seconds. Runs until the end of the block, or until `connections` were opened."""

    def __init__(self, port, words, rate, connections, hold=0.5):
        self.port, self.words, self.rate, self.hold = port, list(words.values()), rate, hold
        self.connections, self.opened = connections, 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def _run(self):
        held, begin = [], time.monotonic()
        while not self._stop.is_set() and self.opened < self.connections:
            now = time.monotonic()
            while held and held[0][0] < now - self.hold:
                held.pop(0)[1].close()
            if self.opened < (now - begin) * self.rate:
                try:
                    connection = wire.connect(self.port, source=f"127.0.0.{1 + self.opened % 8}", timeout=1.0)
                    connection.sendall(self.words[self.opened % len(self.words)])
                    held.append((now, connection))
                except OSError:
                    pass
                self.opened += 1
            else:
                self._stop.wait(0.002)
        for _, connection in held:
            connection.close()

    def wait(self):
        while self._thread.is_alive():
            time.sleep(0.05)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join(10)


def hammering(room, checks, connections=1000, rate=200):
    """strangers at 200 connections a second: the frames' delay is as if they hammered at another port, memory does not
    grow, and a viewer from an address that hammers is admitted within a second"""
    key = make_key(room)
    digits, words = encrypted.digits_of(key), strangers_words(key)
    server, port = room.serve("--key", key)
    child = programs.child_of(server.pid)
    with wire.Viewer(port, key=digits) as viewer, wire.Server(wire.hear_out) as elsewhere:
        checks.expect(viewer.wait_for_frames(30, 30), "a viewer is served")
        before = programs.resident_kb(child)
        delays = {"elsewhere": [], "here": []}
        for where, target in ROUNDS * [("elsewhere", elsewhere.port), ("here", port)]:
            begin = time.monotonic()
            with Hammer(target, words, rate, connections // ROUNDS) as hammer:
                hammer.wait()
            delays[where] += [arrival.delay for arrival in viewer.between(begin, time.monotonic())]
        p99 = {where: sorted(values)[len(values) * 99 // 100] for where, values in delays.items()}
        more = p99["here"] - p99["elsewhere"]
        checks.expect(more < MOST_MORE_P99_S or connections < FEWEST_FOR_P99,
                      f"{connections} strangers at {rate} a second add {1000 * more:.1f} ms to the p99 of the delay, "
                      f"{1000 * p99['elsewhere']:.1f} ms")
        with Hammer(port, words, rate, 10 * rate):
            for attempt in range(3):
                welcome, _ = admitted_within(port, digits)
                checks.expect(welcome < 1, f"attempt {attempt + 1}: admitted after {welcome:.2f} s")
        grown = programs.resident_kb(child) - before
        checks.expect(grown < MOST_GROWTH_KB, f"the server's memory grew by {grown} kB")
    checks.expect(server.end() == 0, "it ends when asked")


def main():
    cases = {case.__name__: case
             for case in (right_wrong_and_no_key, openssl_is_a_viewer, two_hundred_at_once, hammering)}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, default=programs.ROOT / "build/release/bin")
    parser.add_argument("--connections", type=int, default=1000)
    parser.add_argument("--rate", type=int, default=200, help="connections a second")
    parser.add_argument("cases", nargs="*", metavar="CASE", choices=[*cases, []], help=" or ".join(cases))
    options = parser.parse_args()
    checks = programs.Checks()
    for name in options.cases or cases:
        print(f"== {name}: {cases[name].__doc__}", flush=True)
        with programs.Room(options.bin) as room:
            more = (options.connections, options.rate) if name == "hammering" else ()
            cases[name](room, checks, *more)
    checks.exit()


if __name__ == "__main__":
    main()
