#!/usr/bin/env python3
"""Tests web_gateway with real capture servers and scripted pages:
tests/web_gateway/gateway.py [--bin FOLDER] [CASE ...]"""
import json
import os
import pathlib
import stat
import struct
import subprocess
import sys
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "attack"))
import programs  # noqa: E402
import replay  # noqa: E402
import wire  # noqa: E402
from page import BINARY, TEXT, Page, Refused, WebSocket, get  # noqa: E402


def serve_pages(room, *ports, more=()):
    """Starts a gateway for capture servers on these ports. Returns the program and its port."""
    connect = [word for port in ports for word in ("--connect", f"127.0.0.1:{port}")]
    gateway = room.start([room.bin / "web_gateway", *connect, "--listen", "127.0.0.1:0", *more])
    found = gateway.says(r"to browsers on https?://127\.0\.0\.1:(\d+)")
    if not found:
        raise RuntimeError("web_gateway does not start:\n" + gateway.said())
    return gateway, int(found.group(1))


def with_token(room):
    """Makes a token file. Returns the token and the options that use it."""
    path = room.folder / "room.token"
    subprocess.run([room.bin / "web_gateway", "--make-token", path], check=True, timeout=10)
    return path.read_text().strip(), ["--token", path]


def refusal(port, token):
    """The reason for which a page with this token is refused."""
    socket = WebSocket(port)
    socket.join(token)
    opcode, payload = socket.receive()
    socket.close()
    message = json.loads(payload) if opcode == TEXT else {}
    return message.get("reason"), message.get("text", "")


def frames_arrive_unchanged(room, checks):
    """every byte of a server's frames reaches the page, with the camera's index before it"""
    real, port = room.serve()
    _, bodies = wire.frames_of(port, 60)
    real.end()

    joined = threading.Event()

    def behave(connection):
        wire.shake_hands(connection, wire.welcome(camera="left", codec="adaptive"))
        joined.wait(20)
        for body in bodies:
            time.sleep(0.02)
            connection.sendall(wire.message(wire.FRAME, body))
            while wire.read_message(connection)[0] != wire.FRAME_ACK:
                pass
        connection.sendall(wire.camera_status("unplugged"))
        wire.hear_out(connection)

    with wire.Server() as silent, wire.Server(behave) as server:
        _, gateway = serve_pages(room, silent.port, server.port)
        with Page(gateway, keep=True) as page:
            page.wait_for(lambda: page.states(1)[-1:] == ["connected"])
            joined.set()
            page.wait_for(lambda: page.messages and page.messages[-1][5] == wire.CAMERA_STATUS, 20)
            received = [message for message in page.messages if message[0] == 1]
    expected = [bytes([1]) + wire.message(wire.FRAME, body) for body in bodies]
    frames = [message for message in received if message[5] == wire.FRAME]
    checks.expect(frames == expected, f"{len(frames)} of {len(expected)} frames, all bytes equal")
    checks.expect(received[0][5] == wire.WELCOME, "the welcome comes first")
    welcome = wire.welcome(camera="left", codec="adaptive", clock_id=0, server_ns=0)
    checks.expect(received[0][25:] == welcome[24:], "the welcome has the server's description")
    checks.expect(received[-1] == bytes([1]) + wire.camera_status("unplugged"), "the status comes last")


def joining_pages_see_a_picture_at_once(room, checks):
    """a page that joins gets a keyframe and all frames after it, also long after the last keyframe"""
    (_, first), (_, second) = room.serve(), room.serve()
    _, gateway = serve_pages(room, first, second)
    with Page(gateway) as page:
        checks.expect(page.wait_for_frames(60, 30), "two cameras arrive")
        checks.expect(page.texts[0]["type"] == "room" and len(page.texts[0]["cameras"]) == 2, "the room comes first")
        for wait in (0.3, 8):
            time.sleep(wait)
            with Page(gateway) as late:
                checks.expect(late.wait_for(lambda: {a.camera for a in late.arrivals} == {0, 1}, 10), "both cameras")
                took = max(min(a.at for a in late.arrivals if a.camera == camera) for camera in (0, 1)) - late.joined_at
                checks.expect(took < 1.2, f"first pictures {1000 * took:.0f} ms after joining")
                late.wait_for_frames(120, 20)
                for camera in (0, 1):
                    arrivals = [a for a in late.arrivals if a.camera == camera]
                    checks.expect(arrivals[0].keyframe, "the first is a keyframe")
                    checks.expect(all(a.sequence < b.sequence for a, b in zip(arrivals, arrivals[1:])), "in order")


def a_stopped_page(room, checks, seconds=20):
    """a page that reads nothing for 20 s costs less than 1 MB and disturbs nobody; then it is live within 1 s"""
    recorded = replay.record(room)
    with replay.ReplayedCamera(*recorded) as first, replay.ReplayedCamera(*recorded) as second:
        program, gateway = serve_pages(room, first.port, second.port)
        stop_a_page(program, gateway, checks, seconds)


def stop_a_page(program, gateway, checks, seconds):
    with Page(gateway) as other, Page(gateway) as page:
        checks.expect(other.wait_for_frames(200, 30) and page.wait_for_frames(200, 30), "both pages watch")
        before, begin = programs.resident_kb(program.pid), time.monotonic()
        page.stop_reading()
        time.sleep(seconds)
        grown = programs.resident_kb(program.pid) - before
        end = time.monotonic()
        frames = other.between(begin, end)
        rate = len(frames) / (end - begin) / 2
        checks.expect(grown < 1024, f"the gateway's memory grew by {grown} kB")
        checks.expect(rate > 20, f"the other page got {rate:.1f} frames a second of each camera")
        gap = max((b.at - a.at for a, b in zip(frames, frames[1:])), default=float("inf"))
        checks.expect(gap < 1, f"its longest pause was {1000 * gap:.0f} ms")
        page.read_on()
        is_live = page.wait_for(lambda: all(any(a.camera == camera and a.at > end and a.delay < 0.3
                                                for a in page.arrivals[-60:]) for camera in (0, 1)), 5)
        took = time.monotonic() - end
        checks.expect(is_live and took < 1, f"live again after {took:.2f} s")
        sequences = [a.sequence for a in page.arrivals if a.camera == 0]
        checks.expect(sequences == sorted(set(sequences)), "no frame came twice or late")


def tokens(room, checks):
    """room data needs the token; the page's files do not"""
    _, port = room.serve()
    token, options = with_token(room)
    program, gateway = serve_pages(room, port, more=options)
    checks.expect(stat.S_IMODE(os.stat(options[1]).st_mode) == 0o600, "the token file is its owner's only")
    checks.expect(len(token) == 64, "a token has 64 digits")
    again = subprocess.run([room.bin / "web_gateway", "--make-token", options[1]], capture_output=True, text=True)
    checks.expect(again.returncode == 1 and "exists already" in again.stderr, "no token file is overwritten")
    for wrong in ("", "0", token[:-1], token + "0", token.upper() + "x"):
        reason, text = refusal(gateway, wrong)
        checks.expect(reason == "token" and "link" in text, f"{wrong[:8]!r}... is refused: {text}")
    status, headers, body = get(gateway)
    checks.expect(status == 200 and b"<html" in body.lower(), "the page itself is public")
    checks.expect(token not in program.said(), "the log does not have the token")
    with Page(gateway, token) as page:
        checks.expect(page.wait_for_frames(10, 20), "with the token, frames come")
    silent = WebSocket(gateway)
    begin = time.monotonic()
    try:
        silent.socket.settimeout(12)
        silent.receive()
        checks.expect(False, "a socket that sends no token gets data")
    except (ConnectionError, OSError):
        checks.expect(time.monotonic() - begin < 10, f"a silent socket is closed: {time.monotonic() - begin:.1f} s")
    for message in (b"{}", b"[", b'{"type":"join"}', b"\0" * 500):
        socket = WebSocket(gateway)
        socket.send(BINARY if message[0] == 0 else TEXT, message)
        try:
            opcode, _ = socket.receive()
            checks.expect(opcode == 8, f"{message[:20]} is answered by closing")
        except (ConnectionError, OSError):
            pass
    os.chmod(options[1], 0o644)
    open_file = subprocess.run([room.bin / "web_gateway", "--connect", "127.0.0.1:1", *options], capture_output=True,
                               text=True, timeout=10)
    checks.expect(open_file.returncode == 1 and "chmod 600" in open_file.stderr, "a readable token file is refused")


def origins_and_hosts(room, checks):
    """scripts of other sites get 403, and so does every name but this machine's if there is no token"""
    _, port = room.serve()
    _, plain = serve_pages(room, port)
    token, options = with_token(room)
    _, guarded = serve_pages(room, port, more=options)
    for gateway in (plain, guarded):
        for origin in ("http://attacker.example", "null", f"http://127.0.0.1:{gateway + 1}"):
            checks.expect(get(gateway, Origin=origin)[0] == 403, f"a file for {origin}")
            try:
                WebSocket(gateway, origin=origin).close()
                checks.expect(False, f"a WebSocket for {origin} opens")
            except Refused as refused:
                checks.expect(refused.args == (403,), f"a WebSocket for {origin}")
        WebSocket(gateway, origin=f"http://127.0.0.1:{gateway}").close()
    checks.expect(get(plain, host="attacker.example")[0] == 403, "without a token, another host's name is refused")
    checks.expect(get(plain, host="localhost")[0] == 200, "localhost is this machine")
    checks.expect(get(guarded, host="room.example")[0] == 200, "with a token, every host's name is served")
    with Page(guarded, token, host="room.example") as page:
        checks.expect(page.wait_for_frames(5, 20), "and the room, too")


def files(room, checks):
    """files have security headers, and no path leaves the page's folder"""
    _, gateway = serve_pages(room, 1)
    status, headers, body = get(gateway)
    for name in ("content-security-policy", "cross-origin-opener-policy", "cross-origin-embedder-policy",
                 "x-content-type-options", "referrer-policy", "cache-control", "etag"):
        checks.expect(name in headers, f"{name}: {headers.get(name, '')[:60]}")
    checks.expect(get(gateway, If_None_Match=headers["etag"])[0] == 304, "an unchanged file is not sent again")
    packed = get(gateway, Accept_Encoding="gzip")
    checks.expect(packed[1].get("content-encoding") == "gzip" and len(packed[2]) < len(body), "files are compressed")
    head = get(gateway, method="HEAD")
    checks.expect(head[0] == 200 and head[2] == b"" and int(head[1]["content-length"]) == len(body), "HEAD")
    for path in ("/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/..%5c..", "/index.html/..",
                 "/nothing", "/index.html%00.js", "http://127.0.0.1/index.html"):
        checks.expect(get(gateway, path)[0] in (400, 404), f"{path} does not exist")
    checks.expect(get(gateway, method="POST")[0] == 405, "POST")
    checks.expect(get(gateway, "/room")[0] == 426, "the room without a WebSocket")
    checks.expect(get(gateway, "/index.html?x=1")[2] == body, "a query changes nothing")
    status, _, _ = get(gateway, X_Long="y" * 20000)
    checks.expect(status == 431, "headers of 20 kB are refused")


def servers_come_back(room, checks):
    """a page learns that a server is gone, and sees its frames when it is back"""
    server, port = room.serve()
    _, gateway = serve_pages(room, port)
    with Page(gateway, keep=True) as page:
        checks.expect(page.wait_for_frames(10, 20), "frames come")
        server.end()
        checks.expect(page.wait_for(lambda: page.states()[-1] == "waiting", 5), "the page is told to wait")
        checks.expect(page.texts[-1]["text"] != "", f"and why: {page.texts[-1]['text']}")
        before = len(page.arrivals)
        room.start([room.bin / "capture_server", "--source", programs.RECORDING, "--loop", "--listen",
                    f"127.0.0.1:{port}"])
        checks.expect(page.wait_for_frames(before + 10, 40), "frames come again")
        checks.expect(page.states()[-1] == "connected", "the page is told so")
        kinds = [message[5] for message in page.messages]
        checks.expect(kinds.count(wire.WELCOME) == 2, "with a welcome")
        checks.expect(page.ended == "", "on the same WebSocket")


SCENE = """key = "room.key"
[[camera]]
name = "{name}"
address = "127.0.0.1:{port}"
width = 640
height = 480
fx = 590.0
fy = 591.0
cx = 320.0
cy = 240.0
world_from_camera = [[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, -2], [0, 0, 0, 1]]
"""


def scene_files(room, checks):
    """the scene file has the servers' key and addresses, intrinsics, and poses that servers do not know"""
    key, scene = room.folder / "room.key", room.folder / "room.toml"
    subprocess.run([room.bin / "capture_server", "--make-key", key], check=True, timeout=10)
    _, port = room.serve("--name", "left", "--key", key)
    scene.write_text(SCENE.format(name="left", port=port))
    _, gateway = serve_pages(room, more=["--scene", scene])
    with Page(gateway) as page:
        checks.expect(page.wait_for_frames(5, 40), "frames come with the key")
        checks.expect(page.texts[0]["cameras"][0]["name"] == "left", "the room names the camera")
    without = room.start([room.bin / "web_gateway", "--connect", f"127.0.0.1:{port}", "--listen", "127.0.0.1:0"])
    checks.expect(without.wait(20) == 1 and "key" in without.said().splitlines()[-1], "without the key it ends")

    has_no_pose = wire.welcome(camera="right", flags=1)

    def behave(connection):
        wire.shake_hands(connection, has_no_pose)
        wire.hear_out(connection)

    with wire.Server(behave) as server:
        scene.write_text(SCENE.format(name="right", port=server.port).split("\n", 1)[1])
        _, gateway = serve_pages(room, more=["--scene", scene])
        with Page(gateway, keep=True) as page:
            checks.expect(page.wait_for(lambda: page.messages), "a server without a pose")
            welcome = page.messages[0][9:]
            checks.expect(struct.unpack_from("<2d", welcome, 16) == (590, 591), "the scene file's focal lengths")
            checks.expect(struct.unpack_from("<3d", welcome, 184) == (0.5, 0, -2), "the scene file's pose")
            checks.expect(welcome[254] & 2, "which is known")


def too_many_viewers(room, checks):
    """--max-viewers limits the viewers, and a place is free when one leaves"""
    _, port = room.serve()
    _, gateway = serve_pages(room, port, more=["--max-viewers", "2"])
    with Page(gateway) as page:
        with Page(gateway) as other:
            checks.expect(page.wait_for_frames(5, 20) and other.wait_for_frames(5, 20), "two watch")
            reason, text = refusal(gateway, "")
            checks.expect(reason == "full" and "later" in text, f"the third is refused: {text}")
        checks.expect(page.wait_for(lambda: refusal(gateway, "")[0] is None, 5), "one leaves: there is a place")


def https(room, checks):
    """the page and the room work over HTTPS, and a wrong key file is refused"""
    for name in ("one", "two"):
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
                        "-nodes", "-days", "2", "-subj", "/CN=localhost", "-keyout", room.folder / f"{name}.key",
                        "-out", room.folder / f"{name}.pem"], check=True, capture_output=True, timeout=30)
    _, port = room.serve()
    options = ["--certificate", room.folder / "one.pem", "--private-key", room.folder / "one.key"]
    _, gateway = serve_pages(room, port, more=options)
    checks.expect(get(gateway, tls=True)[0] == 200, "the page over HTTPS")
    with Page(gateway, tls=True) as page:
        checks.expect(page.wait_for_frames(20, 40), "the room over HTTPS")
    options[3] = room.folder / "two.key"
    wrong = subprocess.run([room.bin / "web_gateway", "--connect", "127.0.0.1:1", "--listen", "127.0.0.1:0", *options],
                           capture_output=True, text=True, timeout=10)
    checks.expect(wrong.returncode == 1 and "two.key" in wrong.stderr, wrong.stderr.strip())


def addresses(room, checks):
    """without a token only this machine is served, and a stop ends the gateway within a second"""
    for listen in ("0.0.0.0:0", "[::]:0"):
        reached = subprocess.run([room.bin / "web_gateway", "--connect", "127.0.0.1:1", "--listen", listen],
                                 capture_output=True, text=True, timeout=10)
        checks.expect(reached.returncode == 1 and "--token" in reached.stderr and "--open" in reached.stderr,
                      reached.stderr.strip())
    _, port = room.serve()
    program, gateway = serve_pages(room, port, more=["--open"])
    with Page(gateway) as page:
        page.wait_for_frames(5, 20)
        begin = time.monotonic()
        checks.expect(program.end() == 0, "a stop is no failure")
        checks.expect(time.monotonic() - begin < 1, f"it ended after {time.monotonic() - begin:.2f} s")
        checks.expect(page.wait_for(lambda: page.ended, 2), "the page notices")


if __name__ == "__main__":
    programs.run([frames_arrive_unchanged, joining_pages_see_a_picture_at_once, a_stopped_page, tokens,
                  origins_and_hosts, files, servers_come_back, scene_files, too_many_viewers, https, addresses],
                 __doc__)
