#!/usr/bin/env python3
"""Simulates a bad network: a TCP proxy in front of a port, with rate, delay, jitter, interruptions and resets.

  tests/attack/proxy.py TARGET [LISTEN]    prints its port, then reads commands from standard input:

  rate BITS      bits a second towards the client, of all connections together; 0: no limit
  up BITS        the same towards the server
  delay MS       delay in each direction
  jitter MS      additional random delay of each piece, up to this; pieces stay in order
  cut 0|1        1 stops all bytes without losing them; 0 lets them pass again
  reset          resets every connection at both ends
  refuse 0|1     new connections are closed at once
The proxy ends at the end of its input. `Proxy` starts a proxy for a test."""
import collections
import os
import pathlib
import random
import select
import socket
import struct
import subprocess
import sys
import time

PIECE = 1500             # bytes that share one delay: about a packet
QUEUE = 256 * 1024       # bytes that one way of a connection holds before it stops reading, as a router's queue does
LONGEST_SLEEP = 0.05


class Network:
    """State that all connections share."""

    def __init__(self):
        self.delay = self.jitter = 0.0
        self.cut = self.refuse = False
        self.rate = {"down": 0.0, "up": 0.0}   # bytes a second
        self.free_at = {"down": 0.0, "up": 0.0}  # when the link has carried what it was given
        self.random = random.Random(1)

    def due(self, way, now, count):
        """Returns the time when `count` bytes that enter the link now leave it."""
        begin = max(now, self.free_at[way])
        self.free_at[way] = begin + (count / self.rate[way] if self.rate[way] else 0.0)
        return self.free_at[way] + self.delay + self.random.uniform(0, self.jitter)


class Way:
    """One direction of one connection."""

    def __init__(self, network, name, source, sink):
        self.network, self.name, self.source, self.sink = network, name, source, sink
        self.pieces = collections.deque()  # (due, bytes)
        self.held, self.latest, self.ended = 0, 0.0, False

    def wants_more(self):
        return not self.ended and self.held < QUEUE

    def read(self, now):
        data = self.source.recv(16384)
        if not data:
            self.ended = True
        for begin in range(0, len(data), PIECE):
            piece = data[begin:begin + PIECE]
            self.latest = max(self.latest, self.network.due(self.name, now, len(piece)))
            self.pieces.append((self.latest, piece))
            self.held += len(piece)

    def write(self, now):
        """Sends the bytes that are due. Returns the time when more are due, or None."""
        while self.pieces and self.pieces[0][0] <= now:
            due, piece = self.pieces[0]
            try:
                sent = self.sink.send(piece)
            except BlockingIOError:
                return now + 0.002
            self.held -= sent
            if sent < len(piece):
                self.pieces[0] = (due, piece[sent:])
            else:
                self.pieces.popleft()
        if self.ended and not self.pieces:
            raise ConnectionError
        return self.pieces[0][0] if self.pieces else None


class Pair:
    def __init__(self, network, client, target):
        self.client, self.server = client, socket.create_connection(("127.0.0.1", target), 2)
        for end in (self.client, self.server):
            end.setblocking(False)
            end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 65536)
            end.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 65536)
        self.ways = [Way(network, "down", self.server, self.client),
                     Way(network, "up", self.client, self.server)]

    def close(self, with_reset=False):
        for end in (self.client, self.server):
            if with_reset:
                end.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            end.close()


def obey(network, pairs, line):
    words = line.split()
    if not words:
        return
    value = float(words[1]) if len(words) > 1 else 0.0
    if words[0] in ("rate", "up"):
        way = "down" if words[0] == "rate" else "up"
        network.rate[way], network.free_at[way] = value / 8, 0.0
    elif words[0] == "delay":
        network.delay = value / 1000
    elif words[0] == "jitter":
        network.jitter = value / 1000
    elif words[0] == "cut":
        network.cut = bool(value)
    elif words[0] == "refuse":
        network.refuse = bool(value)
    elif words[0] == "reset":
        for pair in pairs:
            pair.close(with_reset=True)
        pairs.clear()


def serve(target, listen):
    listener = socket.create_server(("127.0.0.1", listen), backlog=64)
    listener.setblocking(False)
    print(listener.getsockname()[1], flush=True)
    network, pairs, commands = Network(), [], b""
    while True:
        now, wake = time.monotonic(), LONGEST_SLEEP
        if not network.cut:
            for pair in list(pairs):
                try:
                    for way in pair.ways:
                        due = way.write(now)
                        if due is not None:
                            wake = min(wake, max(0.0, due - now))
                except OSError:
                    pair.close()
                    pairs.remove(pair)
        readers = {}
        if not network.cut:
            readers = {way.source: (pair, way) for pair in pairs for way in pair.ways if way.wants_more()}
        ready, _, _ = select.select([listener, 0, *readers], [], [], wake)
        now = time.monotonic()
        for source in ready:
            if source is listener:
                client, _ = listener.accept()
                try:
                    if network.refuse:
                        raise ConnectionError
                    pairs.append(Pair(network, client, target))
                except OSError:
                    client.close()
            elif source == 0:
                part = os.read(0, 4096)
                if not part:
                    return
                *lines, commands = (commands + part).split(b"\n")
                for line in lines:
                    obey(network, pairs, line.decode())
            else:
                pair, way = readers[source]
                if pair not in pairs:
                    continue
                try:
                    way.read(now)
                except BlockingIOError:
                    pass
                except OSError:
                    pair.close()
                    pairs.remove(pair)


class Proxy:
    """A proxy in front of `target`, in its own process. Clients connect to `port`."""

    def __init__(self, target, **network):
        command = [sys.executable, str(pathlib.Path(__file__).resolve()), str(target)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.port = int(self._process.stdout.readline())
        self.set(**network)

    def set(self, **network):
        """Sends commands, for example Proxy.set(rate=4e6, delay=90)."""
        for name, value in network.items():
            self._process.stdin.write(f"{name} {float(value)}\n")
        self._process.stdin.flush()

    def reset(self):
        self._process.stdin.write("reset\n")
        self._process.stdin.flush()

    def end(self):
        self._process.stdin.close()
        try:
            self._process.wait(3)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()


if __name__ == "__main__":
    if not 2 <= len(sys.argv) <= 3:
        sys.exit(__doc__)
    serve(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) == 3 else 0)
