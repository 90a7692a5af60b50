#!/usr/bin/env python3
"""Tests render_client against hostile servers and failing networks: tests/attack/client.py [--bin FOLDER] [CASE ...]

Each case also has an honest capture_server, and the client must keep showing its camera."""
import os
import signal
import struct
import subprocess
import threading
import time

import programs
import proxy
import wire

LINE_BUDGET = 40  # lines that a client may write about one camera in some seconds, whatever its server does


def paced(connection, bodies, seconds=60.0, change=lambda body, index: body, rate=30.0):
    """Sends frames at a camera's rate and answers pings, until `seconds` are over or the client leaves."""
    connection.settimeout(0.001)
    begin, index, unread = time.monotonic(), 0, b""
    while time.monotonic() - begin < seconds:
        if index < (time.monotonic() - begin) * rate:
            connection.settimeout(10)
            connection.sendall(wire.message(wire.FRAME, change(bodies[index % len(bodies)], index)))
            connection.settimeout(0.001)
            index += 1
        try:
            part = connection.recv(4096)
            if not part:
                return
            unread += part
        except (TimeoutError, BlockingIOError):
            pass
        while len(unread) >= 8:
            size, kind = struct.unpack_from("<II", unread)
            if len(unread) < 8 + size:
                break
            if kind == wire.PING:
                connection.sendall(wire.pong(struct.unpack_from("<Q", unread, 8)[0]))
            unread = unread[8 + size:]


def lines_about(client, port):
    return [line for line in client.said().splitlines() if f":{port}" in line]


def honest_frames_go_on(room, checks, client, what):
    """Checks that the client still runs, ends with 0 when asked, and has shown the honest camera."""
    checks.expect(client.is_running(), f"{what}: the client runs on")
    code = client.end()
    checks.expect(code == 0, f"{what}: it ends with 0 when asked, not {code}")
    cameras = room.stats()["cameras"]
    checks.expect(len(cameras) == 2 and cameras[0]["frames_shown"] > 3,
                  f"{what}: {cameras[0]['frames_shown']} frames of the honest camera shown")
    return cameras[1]


def unshowable():
    """Yields reasons why a camera cannot be shown: a name, the answer to the hello, and a word of the log's reason."""
    yield "unknown codec", wire.welcome(codec="h265"), "h265"
    yield "a codec without its parameter", wire.welcome(codec="triangle", pixel_format=3), "triangle"
    yield "a range too small for the unit", wire.welcome(near=1e-9, far=1e-8), ""
    yield "another version", wire.reject(wire.WRONG_VERSION, "install the same release"), "same release"
    yield "an empty range", wire.welcome(near=5.0, far=0.4), "range"
    yield "a full server", wire.reject(wire.FULL, "32 clients already"), "32 clients"
    yield "garbage", b"SSH-2.0-OpenSSH_9.2p1\r\n" * 100, "no capture_server"


def one_camera_that_cannot_be_shown(room, checks):
    """the other cameras go on, --frames does not wait for the one left out, and log and --stats give the reason"""
    _, honest = room.serve()
    for name, answer, word in unshowable():
        def behave(connection, answer=answer):
            wire.shake_hands(connection, answer)
            time.sleep(0.05)

        with wire.Server(behave) as evil:
            client = room.view(honest, evil.port, more=["--frames", "10"])
            code = client.wait(60)
            checks.expect(code == 0, f"{name}: ten views of the other camera are drawn ({code})")
            if code is None:
                client.end()
                continue
            lines = lines_about(client, evil.port)
            checks.expect(any("left out" in line and word in line for line in lines), f"{name}: the log says why")
            checks.expect(len(lines) <= LINE_BUDGET, f"{name}: {len(lines)} lines in the log")
            cameras = room.stats()["cameras"]
            checks.expect(len(cameras) == 2 and word in (cameras[1]["left_out"] or "") and cameras[1]["left_out"],
                          f"{name}: the statistics say why: {cameras[1]['left_out']}")
            checks.expect(cameras[0]["left_out"] is None, f"{name}: the other one is not left out")


def frames_that_never_decode(room, checks):
    """a camera with damaged frames is left out, and is shown again from the first frame that decodes"""
    _, honest = room.serve()
    first, bodies = wire.frames_of(honest, 12)
    repaired = threading.Event()

    def change(body, index):
        return body if repaired.is_set() else body[:-20] + bytes(20)

    def behave(connection):
        wire.shake_hands(connection, wire.message(wire.WELCOME, first))
        paced(connection, bodies, change=change)

    with wire.Server(behave) as evil:
        client = room.view(honest, evil.port)
        checks.expect(client.says(rf":{evil.port}: its frames cannot be decoded.*left out", 60),
                      "the camera is left out, and why")
        repaired.set()
        checks.expect(client.says(rf":{evil.port}.* is in the view again", 60), "it comes back")
        camera = honest_frames_go_on(room, checks, client, "damaged frames")
        checks.expect(camera["left_out"] is None, "it is not left out any more")
        checks.expect(camera["drops"]["decode_error"] > 0, f"{camera['drops']['decode_error']} damaged ones counted")


def refused_in_mid_session(room, checks):
    """a server that restarts with an unknown codec is left out, and is shown again after a restart with a known one"""
    _, honest = room.serve()
    first, bodies = wire.frames_of(honest, 12)
    is_mad = threading.Event()

    def behave(connection):
        if is_mad.is_set():
            wire.shake_hands(connection, wire.welcome(codec="h265"))
            return wire.hear_out(connection)
        wire.shake_hands(connection, wire.message(wire.WELCOME, first))
        paced(connection, bodies, seconds=3.0)
        is_mad.set()
        return wire.reset(connection)

    with wire.Server(behave) as evil:
        client = room.view(honest, evil.port)
        checks.expect(client.says(rf":{evil.port}: connected to camera", 30), "it is shown at first")
        checks.expect(client.says(rf":{evil.port}.*h265.*left out", 30), "then left out")
        is_mad.clear()
        checks.expect(client.says(rf":{evil.port}.* is in the view again", 30), "then shown again")
        honest_frames_go_on(room, checks, client, "an unknown codec in mid-session")


def all_cameras_refused(room, checks):
    """the program ends with 1 and one sentence when no camera can be shown"""
    def refuse(connection):
        wire.shake_hands(connection, wire.reject(wire.WRONG_VERSION, "install the same release"))

    def unknown(connection):
        wire.shake_hands(connection, wire.welcome(codec="h265"))

    with wire.Server(refuse) as one, wire.Server(unknown) as two:
        alone = room.view(one.port)
        checks.expect(alone.wait(30) == 1, "one camera of another version: exit 1")
        checks.expect(alone.said().count("same release") == 1, "said once")
        both = room.view(one.port, two.port)
        checks.expect(both.wait(30) == 1, "two cameras that are refused: exit 1")
        last = both.said().strip().splitlines()[-1]
        checks.expect("same release" in last and "h265" in last, "the last line names both: " + last)
        checks.expect([c["left_out"] is not None for c in room.stats()["cameras"]] == [True, True],
                      "the statistics are written and say so")


def floods(room, checks):
    """a server causes few log lines whatever it sends, and the client connects at most twice a second"""
    _, honest = room.serve()
    first, bodies = wire.frames_of(honest, 4)
    welcome = wire.message(wire.WELCOME, first)

    def statuses(connection):
        wire.shake_hands(connection, welcome)
        flood = b"".join(wire.camera_status(f"status {i}") for i in range(2000))
        while True:
            connection.sendall(flood)

    def long_statuses(connection):
        wire.shake_hands(connection, welcome)
        flood = wire.camera_status("x" * 512) * 50
        for body in bodies:
            connection.sendall(flood + wire.message(wire.FRAME, body))
        wire.hear_out(connection)

    def hang_up(connection):
        wire.shake_hands(connection, welcome)

    def one_frame_and_hang_up(connection):
        wire.shake_hands(connection, welcome)
        connection.sendall(wire.message(wire.FRAME, bodies[0]))
        wire.read_message(connection)

    def garbage(connection):
        wire.shake_hands(connection, welcome)
        connection.sendall(os.urandom(100000))
        wire.hear_out(connection)

    def end_of_stream(connection):
        wire.shake_hands(connection, welcome)
        connection.sendall(wire.end_of_stream("that is all"))

    for attack in (statuses, long_statuses, hang_up, one_frame_and_hang_up, garbage, end_of_stream):
        with wire.Server(attack) as evil:
            client = room.view(honest, evil.port)
            checks.expect(client.says(rf":{evil.port}", 30), f"{attack.__name__}: it begins")
            before, begin = evil.connections, time.monotonic()
            time.sleep(5)
            rate = (evil.connections - before) / (time.monotonic() - begin)
            honest_frames_go_on(room, checks, client, attack.__name__)
            lines, size = lines_about(client, evil.port), len(client.said())
            # The first tries follow each other faster, before the pause has grown.
            checks.expect(rate <= 3.5, f"{attack.__name__}: {rate:.1f} connections a second")
            checks.expect(len(lines) <= LINE_BUDGET, f"{attack.__name__}: {len(lines)} lines, {size} bytes of log")
            checks.expect(size < 40_000 and max(map(len, lines)) < 600, f"{attack.__name__}: the lines are short")


def lies_about_times(room, checks):
    """impossible times are not counted, so the statistics stay plausible, also with --sync"""
    _, honest = room.serve()
    first, bodies = wire.frames_of(honest, 12)

    def change(body, index):
        hour = 3600 * 10**9
        sent = time.monotonic_ns() + (0, hour, -hour, 2**60, -2**62)[index % 5]
        return wire.frame_body(body, sent_at=max(0, min(sent, 2**61)), captured=index + 1, encoder_busy=0,
                               window_full=0, us_capture=2**32 - 1)

    def behave(connection):
        wire.shake_hands(connection, wire.message(wire.WELCOME, first))
        paced(connection, bodies, change=change)

    with wire.Server(behave) as evil:
        client = room.view(honest, evil.port, more=["--sync", "--frames", "20"])
        checks.expect(client.wait(90) == 0, "twenty views are drawn")
    stats = room.stats()
    liar = stats["cameras"][1]
    checks.expect(liar["frames_shown"] > 3 and liar["times_not_believed"] > 3,
                  f"{liar['times_not_believed']} of {liar['frames_decoded']} frames' times are not believed")
    for name, numbers in [("latency", liar["latency_ms"]), ("skew", stats["view"]["skew_ms"]),
                          *liar["stages_ms"].items()]:
        checks.expect(all(0 <= value < 11_000 for value in numbers.values()), f"{name} of the liar: {numbers}")


def nothing_is_unaccounted_for(room, checks):
    """the frame counts add up after a reset, a refusal and silent interruptions of 8 and 30 s"""
    _, port = room.serve()
    with proxy.Proxy(port) as network:
        client = room.view(network.port)
        checks.expect(client.says("connected to camera", 30), "connected")

        def fault(begin, seconds, end):
            time.sleep(2)
            begin()
            time.sleep(seconds)
            end()

        def reset_and_refuse():
            network.set(refuse=1)
            network.reset()

        fault(network.reset, 0, lambda: None)
        fault(reset_and_refuse, 3, lambda: network.set(refuse=0))
        fault(lambda: network.set(cut=1), 8, lambda: network.set(cut=0))
        fault(lambda: network.set(cut=1), 30, lambda: network.set(cut=0))
        time.sleep(4)
        checks.expect(client.end() == 0, "the client ends with 0")
    camera = room.stats()["cameras"][0]
    drops = camera["drops"]
    checks.expect(camera["connections"] >= 4, f"{camera['connections']} connections")
    checks.expect(drops["unaccounted"] == 0, f"{drops['unaccounted']} frames unaccounted for")
    checks.expect(camera["frames_captured"] == camera["frames_received"] + drops["encoder_busy"] + drops["window_full"],
                  f"{camera['frames_captured']} captured = {camera['frames_received']} received + {drops}")


def a_name_that_is_no_text(room, checks):
    """an address of arbitrary bytes is refused with a clear message"""
    arguments = [os.fsencode(room.bin / "render_client"), b"--headless", b"--connect", b"\xff:7001", b"--stats",
                 os.fsencode(room.folder / "stats.json")]
    ended = subprocess.run(arguments, stderr=subprocess.PIPE, check=False, timeout=60)
    checks.expect(ended.returncode == 1, f"exit {ended.returncode}")
    checks.expect(b"is not an address" in ended.stderr, "it says so")


def a_stop_during_a_name_lookup(room, checks):
    """Ctrl-C ends the client while a name server does not answer"""
    program = room.bin / "render_client"
    if any(runtime in program.read_bytes() for runtime in (b"libasan.so", b"libtsan.so")):
        return print("skip  a sanitizer's runtime wants to be the first library", flush=True)
    library = room.bin.parent / "tests/slow_resolver/libslow_resolver.so"
    for number in (signal.SIGINT, signal.SIGTERM):
        ready = room.folder / "asked"
        ready.unlink(missing_ok=True)
        process = subprocess.Popen([program, "--headless", "--connect", "camera-pc.example:7001"],
                                   stderr=subprocess.DEVNULL,
                                   env={**os.environ, "LD_PRELOAD": str(library), "SLOW_RESOLVER_ASKED": str(ready)})
        limit = time.monotonic() + 30
        while not ready.exists() and time.monotonic() < limit:
            time.sleep(0.01)
        checks.expect(ready.exists(), "the name is being looked up")
        begin = time.monotonic()
        process.send_signal(number)
        try:
            code = process.wait(30)
        except subprocess.TimeoutExpired:
            process.kill()
            code = process.wait()
        checks.expect(code == 0, f"ends with {code}, {time.monotonic() - begin:.2f} s after {number.name}")


if __name__ == "__main__":
    programs.run([one_camera_that_cannot_be_shown, frames_that_never_decode, refused_in_mid_session,
                  all_cameras_refused, floods, lies_about_times, nothing_is_unaccounted_for, a_name_that_is_no_text,
                  a_stop_during_a_name_lookup], __doc__)
