"""A viewer's page in Python: HTTP requests, a WebSocket client, and the protocol of docs/internals/web_protocol.md.

Uses only the standard library. Test programs import this module; it has no command line."""
import base64
import collections
import hashlib
import json
import os
import pathlib
import socket
import ssl
import struct
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "attack"))
import wire  # noqa: E402

TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10
MAGIC = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"

# delay: seconds from the end of encoding to here.
Arrival = collections.namedtuple("Arrival", "at camera sequence delay keyframe")


def connect(port, tls=False, receive_buffer=None):
    connection = wire.connect(port, timeout=10, receive_buffer=receive_buffer)
    if not tls:
        return connection
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    return context.wrap_socket(connection)


def read_head(connection):
    """Reads a response's head. Returns the status, the headers and what followed them."""
    data = b""
    while b"\r\n\r\n" not in data:
        part = connection.recv(4096)
        if not part:
            raise ConnectionError("the server hung up before its answer")
        data += part
    head, rest = data.split(b"\r\n\r\n", 1)
    lines = head.decode("latin-1").split("\r\n")
    headers = {name.lower(): value.strip() for name, value in (line.split(":", 1) for line in lines[1:])}
    return int(lines[0].split()[1]), headers, rest


def get(port, path="/", host=None, tls=False, method="GET", **headers):
    """Returns the status, the headers and the body of a request."""
    with connect(port, tls) as connection:
        lines = [f"{method} {path} HTTP/1.1", f"Host: {host or f'127.0.0.1:{port}'}", "Connection: close"]
        lines += [f"{name.replace('_', '-')}: {value}" for name, value in headers.items()]
        connection.sendall(("\r\n".join(lines) + "\r\n\r\n").encode("latin-1"))
        status, got, body = read_head(connection)
        try:
            while part := connection.recv(65536):
                body += part
        except ConnectionResetError:  # the server has not read all of the request
            pass
        return status, got, body


class Refused(Exception):
    """The server answered a WebSocket request with this HTTP status."""


class WebSocket:
    def __init__(self, port, path="/room", host=None, origin=None, tls=False, receive_buffer=None):
        self.socket = connect(port, tls, receive_buffer)
        key = base64.b64encode(os.urandom(16)).decode()
        host = host or f"127.0.0.1:{port}"
        lines = [f"GET {path} HTTP/1.1", f"Host: {host}", "Upgrade: websocket", "Connection: Upgrade",
                 f"Sec-WebSocket-Key: {key}", "Sec-WebSocket-Version: 13"]
        lines += [f"Origin: {origin}"] if origin else []
        self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        status, headers, self._data = read_head(self.socket)
        if status != 101:
            self.socket.close()
            raise Refused(status)
        expected = base64.b64encode(hashlib.sha1((key + MAGIC).encode()).digest()).decode()
        assert headers["sec-websocket-accept"] == expected

    def send(self, opcode, payload):
        # A mask of zeros is a mask, too.
        size = len(payload)
        head = bytes([0x80 | opcode])
        head += bytes([0x80 | size]) if size < 126 else b"\xfe" + struct.pack(">H", size)
        self.socket.sendall(head + bytes(4) + payload)

    def join(self, token=""):
        self.send(TEXT, json.dumps({"type": "join", "token": token}).encode())

    def _read(self, count):
        while len(self._data) < count:
            part = self.socket.recv(1 << 18)
            if not part:
                raise ConnectionError("the gateway hung up")
            self._data += part
        data, self._data = self._data[:count], self._data[count:]
        return data

    def receive(self):
        """Returns the next message: its opcode and its payload. Answers pings."""
        while True:
            first, size = self._read(2)
            if size == 126:
                size, = struct.unpack(">H", self._read(2))
            elif size == 127:
                size, = struct.unpack(">Q", self._read(8))
            payload = self._read(size)
            if first & 15 == PING:
                self.send(PONG, payload)
                continue
            assert first & 0x80, "the gateway divides no message"
            return first & 15, payload

    def close(self):
        self.socket.close()


class Page:
    """A viewer on a thread of its own. It acknowledges each frame at once."""

    def __init__(self, port, token="", keep=False, tls=False, host=None, receive_buffer=None):
        self.arrivals, self.texts, self.messages, self.ended = [], [], [], ""
        self._keep, self._stop = keep, threading.Event()
        self._may_read = threading.Event()
        self._may_read.set()
        self.socket = WebSocket(port, tls=tls, host=host, receive_buffer=receive_buffer)
        self.socket.socket.settimeout(60)  # a camera may send nothing for a while
        self.joined_at = time.monotonic()
        self.socket.join(token)
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        try:
            while not self._stop.is_set():
                self._may_read.wait()
                opcode, payload = self.socket.receive()
                if opcode == CLOSE:
                    raise ConnectionError("closed by the gateway")
                self._take(opcode, payload)
        except (OSError, AssertionError) as error:
            self.ended = f"{type(error).__name__}: {error}"

    def _take(self, opcode, payload):
        now = time.monotonic()
        if opcode == TEXT:
            self.texts.append(json.loads(payload))
            return
        camera, (size, kind) = payload[0], struct.unpack_from("<II", payload, 1)
        assert size == len(payload) - 9, "a message of the wrong size"
        if self._keep:
            self.messages.append(payload)
        if kind == wire.FRAME:
            head = wire.frame_head(payload[9:9 + wire.HEAD.size])
            self.socket.send(BINARY, bytes([camera]) + wire.frame_ack(head["sequence"]))
            self.arrivals.append(Arrival(now, camera, head["sequence"], now - head["sent_at"] * 1e-9,
                                         head["flags"] & wire.KEYFRAME))

    def stop_reading(self):
        self._may_read.clear()

    def read_on(self):
        self._may_read.set()

    def wait_for(self, condition, within=10.0):
        """Waits until `condition()` is true; returns whether it is."""
        limit = time.monotonic() + within
        while not condition() and time.monotonic() < limit:
            time.sleep(0.005)
        return bool(condition())

    def wait_for_frames(self, count, within=10.0):
        return self.wait_for(lambda: len(self.arrivals) >= count, within)

    def states(self, camera=0):
        return [text["state"] for text in self.texts if text["type"] == "state" and text["camera"] == camera]

    def between(self, begin, end):
        return [arrival for arrival in list(self.arrivals) if begin <= arrival.at < end]

    def end(self):
        self._stop.set()
        self._may_read.set()
        try:
            self.socket.socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._thread.join(5)
        self.socket.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()
