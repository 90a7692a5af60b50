"""Many pages in one process, for measurements: tests/web_gateway/many_pages.py PORT PAGES SECONDS [TOKEN]

Prints one JSON object: the frames that each page got, and the delays from the end of encoding to here in ms."""
import json
import selectors
import struct
import sys
import time

from page import BINARY, WebSocket
import wire

FRAME_HEAD = 9 + wire.HEAD.size


class Viewer:
    """One page that parses its WebSocket without waiting."""

    def __init__(self, port, token):
        self.web = WebSocket(port)
        self.web.join(token)
        self.web.socket.setblocking(False)
        self.data, self.frames = bytearray(self.web._data), 0

    def read(self, delays):
        while True:
            try:
                part = self.web.socket.recv(1 << 18)
            except BlockingIOError:
                break
            if not part:
                raise ConnectionError("the gateway hung up")
            self.data += part
            if len(part) < 1 << 17:
                break
        now, at, data = time.monotonic(), 0, self.data
        while len(data) - at >= 10:
            size, head = data[at + 1], 2
            if size == 126:
                size, head = struct.unpack_from(">H", data, at + 2)[0], 4
            elif size == 127:
                size, head = struct.unpack_from(">Q", data, at + 2)[0], 10
            if len(data) - at < head + size:
                break
            if data[at] & 15 == 9:
                self.web.send(10, bytes(data[at + head:at + head + size]))
            elif data[at] & 15 == BINARY and data[at + head + 5] == wire.FRAME:
                sequence, sent_at = struct.unpack_from("<QQ", data, at + head + 9)
                self.web.send(BINARY, bytes([data[at + head]]) + wire.frame_ack(sequence))
                delays.append(1e3 * (now - sent_at * 1e-9))
                self.frames += 1
            at += head + size
        del data[:at]


def main():
    port, pages, seconds = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
    token = sys.argv[4] if len(sys.argv) > 4 else ""
    viewers = [Viewer(port, token) for _ in range(pages)]
    selector, delays = selectors.DefaultSelector(), []
    for viewer in viewers:
        selector.register(viewer.web.socket, selectors.EVENT_READ, viewer)
    print("joined", flush=True)
    begin = time.monotonic()
    settled = False
    while time.monotonic() - begin < seconds:
        if not settled and time.monotonic() - begin > 2:  # joining pages get older frames first
            settled = True
            delays.clear()
        for key, _ in selector.select(0.2):
            key.data.read(delays)
    delays.sort()
    share = [delays[min(int(len(delays) * part), len(delays) - 1)] if delays else None for part in (0.5, 0.99)]
    print(json.dumps({"frames": [viewer.frames for viewer in viewers], "delay_ms": share}), flush=True)


if __name__ == "__main__":
    main()
