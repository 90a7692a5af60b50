"""The wire format of docs/internals/wire_format.md in Python: messages, a viewer, and a server that can send invalid
data.

Uses only the standard library. Test programs import this module; it has no command line."""
import collections
import socket
import struct
import threading
import time

import encrypted

VERSION = 7
MAGIC = b"COPRESNC"

# From the client.
HELLO, KEYFRAME_REQUEST, FRAME_ACK, PING = 1, 2, 3, 4
# From the server.
REJECT, WELCOME, FRAME, END_OF_STREAM, PONG, CAMERA_STATUS = 17, 18, 19, 20, 21, 22
# Reasons of a reject.
WRONG_VERSION, FULL, KEY_NEEDED, KEY_UNEXPECTED = 1, 2, 3, 4

KEYFRAME = 1  # flag of a frame
HEAD = struct.Struct("<QQQQQIIIIIIQQIIQ")  # of a frame, 96 bytes
HEAD_FIELDS = ("sequence", "sent_at", "captured", "encoder_busy", "window_full", "us_capture", "us_fill",
               "us_depth_encode", "us_video_encode", "flags", "depth_bytes", "depth_without_color",
               "color_without_depth", "damaged", "late", "dark")


def message(kind, body=b""):
    return struct.pack("<II", len(body), kind) + body


def hello(version=VERSION):
    return message(HELLO, MAGIC + struct.pack("<I", version))


def frame_ack(sequence):
    return message(FRAME_ACK, struct.pack("<Q", sequence))


def ping(at_ns=None):
    return message(PING, struct.pack("<Q", time.monotonic_ns() if at_ns is None else at_ns))


def keyframe_request():
    return message(KEYFRAME_REQUEST)


def text(sentence):
    encoded = sentence if isinstance(sentence, bytes) else sentence.encode()
    return struct.pack("<H", len(encoded)) + encoded


def reject(reason, sentence):
    return message(REJECT, bytes([reason]) + text(sentence))


def end_of_stream(sentence):
    return message(END_OF_STREAM, text(sentence))


def camera_status(sentence):
    return message(CAMERA_STATUS, text(sentence))


def pong(client_ns, server_ns=None):
    server_ns = time.monotonic_ns() if server_ns is None else server_ns
    return message(PONG, struct.pack("<QQ", client_ns, server_ns))


def welcome(camera="camera", width=640, height=480, codec="accuracy8", pixel_format=1, parameters=(), near=0.4,
            far=5.0, fps=30.0, noise=(351.3, 0.5), unit=100, flags=1, focal=(585.0, 585.0), centre=(320.0, 240.0),
            distortion=(0.0,) * 8, rotation=(1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0), translation=(0.0, 0.0, 0.0),
            clock_id=0, server_ns=None):
    """Returns the welcome of a stream. Tests can replace each number by a wrong one."""
    body = struct.pack("<QQ", clock_id, time.monotonic_ns() if server_ns is None else server_ns)
    body += struct.pack("<29d", *focal, *centre, *distortion, *rotation, *translation, near, far, fps, *noise)
    body += struct.pack("<HHHBB", width, height, unit, flags, pixel_format)
    body += text(camera) + text(codec) + struct.pack("<H", len(parameters))
    for name, value in parameters:
        body += text(name) + struct.pack("<d", value)
    return message(WELCOME, body)


def frame_head(body):
    """Returns the head of a frame's body as a dictionary."""
    return dict(zip(HEAD_FIELDS, HEAD.unpack_from(body)))


def frame_body(body, **changes):
    """Returns the frame with some fields of its head changed."""
    fields = {**frame_head(body), **changes}
    return HEAD.pack(*(fields[name] for name in HEAD_FIELDS)) + body[HEAD.size:]


def connect(port, source=None, timeout=3.0, receive_buffer=None):
    """Connects to a port of this machine. `source` is the local address, for example 127.0.0.2."""
    connection = socket.socket()
    connection.settimeout(timeout)
    if receive_buffer:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
    if source:
        connection.bind((source, 0))
    connection.connect(("127.0.0.1", port))
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return connection


def reset(connection):
    """Closes the connection with a reset instead of an orderly end."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    connection.close()


def receive(connection, count):
    data = bytearray()
    while len(data) < count:
        part = connection.recv(count - len(data))
        if not part:
            raise ConnectionError("the other end hung up")
        data += part
    return bytes(data)


def read_message(connection):
    size, kind = struct.unpack("<II", receive(connection, 8))
    return kind, receive(connection, size)


# delay: seconds from the end of encoding to here.
Arrival = collections.namedtuple("Arrival", "at sequence delay bytes keyframe window_full encoder_busy")


class Viewer:
    """A well-behaved viewer on a thread of its own: it acknowledges each frame at once, pings once a second and
    connects anew when it lost its connection. It notes every frame as an Arrival. `key` has the hexadecimal digits of
    the room's key."""

    def __init__(self, port, source=None, keep_bodies=0, patience=10.0, key=None):
        self.port, self.source, self.keep_bodies, self.patience, self.key = port, source, keep_bodies, patience, key
        self.arrivals, self.bodies, self.events = [], [], []  # events: (when, what)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        pause = 0.05
        while not self._stop.is_set():
            connection = None
            try:
                connection = encrypted.Connection(self.port, self.key, self.source) if self.key else \
                    connect(self.port, self.source)
                connection.sendall(hello())
                kind, body = read_message(connection)
                if kind != WELCOME:
                    raise ConnectionError("refused: " + body[3:].decode(errors="replace"))
                self._note("welcome")
                pause = 0.05
                self._watch(connection)
            except (OSError, struct.error) as error:
                self._note(f"{type(error).__name__}: {error}")
                self._stop.wait(pause)
                pause = min(2 * pause, 0.5)
            finally:
                if connection:
                    connection.close()

    def _watch(self, connection):
        connection.settimeout(self.patience)
        pinged = 0.0
        while not self._stop.is_set():
            kind, body = read_message(connection)
            now = time.monotonic()
            if kind == FRAME:
                head = frame_head(body)
                connection.sendall(frame_ack(head["sequence"]))
                self.arrivals.append(Arrival(now, head["sequence"], now - head["sent_at"] * 1e-9, len(body),
                                             head["flags"] & KEYFRAME, head["window_full"], head["encoder_busy"]))
                if len(self.bodies) < self.keep_bodies:
                    self.bodies.append(body)
            elif kind in (END_OF_STREAM, CAMERA_STATUS):
                self._note("says: " + body[2:].decode(errors="replace"))
            if now - pinged > 1:
                pinged = now
                connection.sendall(ping())

    def _note(self, what):
        self.events.append((time.monotonic(), what))

    def between(self, begin, end):
        """Returns the arrivals in a span of monotonic time."""
        return [arrival for arrival in list(self.arrivals) if begin <= arrival.at < end]

    def rate(self, begin, end):
        """Returns the frame rate in frames per second."""
        return len(self.between(begin, end)) / (end - begin)

    def delay(self, begin, end, share=0.5):
        """Returns the median delay in seconds, or another quantile; infinite without frames."""
        delays = sorted(arrival.delay for arrival in self.between(begin, end))
        return delays[min(int(len(delays) * share), len(delays) - 1)] if delays else float("inf")

    def wait_for_frames(self, count, within):
        """Returns true if `count` frames in total have arrived within `within` seconds."""
        limit = time.monotonic() + within
        while len(self.arrivals) < count and time.monotonic() < limit:
            time.sleep(0.01)
        return len(self.arrivals) >= count

    def end(self):
        self._stop.set()
        self._thread.join(self.patience + 5)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()


class Server:
    """A server on a free port that does with every connection what a test wants: `behave(connection)` is called on
    a thread of its own; the connection is closed when it returns or fails. Without `behave` it answers the hello
    and stays silent."""

    def __init__(self, behave=None):
        self.behave = behave or self.stay_silent
        self.connections = 0
        self._listener = socket.create_server(("127.0.0.1", 0), backlog=64)
        self.port = self._listener.getsockname()[1]
        self._stop = threading.Event()
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        while not self._stop.is_set():
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            self.connections += 1
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection):
        try:
            connection.settimeout(10)
            self.behave(connection)
        except (OSError, struct.error):
            pass
        finally:
            connection.close()

    @property
    def ended(self):
        return self._stop.is_set()

    def stay_silent(self, connection):
        shake_hands(connection)
        hear_out(connection)

    def end(self):
        self._stop.set()
        try:
            self._listener.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._listener.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()


def shake_hands(connection, answer=None):
    """Reads the hello and answers with a welcome, or with `answer`."""
    read_message(connection)
    connection.sendall(welcome() if answer is None else answer)


def hear_out(connection):
    """Reads until the other end closes the connection."""
    while connection.recv(1 << 16):
        pass


def frames_of(port, count, within=30.0):
    """Returns the body of a real server's welcome and the bodies of its first frames, beginning with a keyframe."""
    connection = connect(port, timeout=within)
    try:
        connection.sendall(hello())
        kind, first = read_message(connection)
        if kind != WELCOME:
            raise ConnectionError("no welcome")
        bodies = []
        while len(bodies) < count:
            kind, body = read_message(connection)
            if kind == FRAME:
                connection.sendall(frame_ack(frame_head(body)["sequence"]))
                bodies.append(body)
        return first, bodies
    finally:
        connection.close()
