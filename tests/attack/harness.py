#!/usr/bin/env python3
"""Tests the proxy and the viewer that other tests of this folder use:
tests/attack/harness.py [--bin FOLDER] [CASE ...]"""
import time

import programs
import proxy
import wire


def proxy_delays_and_paces(room, checks):
    """the proxy keeps a delay of 40 ms each way and a rate of 800 kbit/s, and an interruption loses no bytes"""
    def echo(connection):
        size = int.from_bytes(wire.receive(connection, 4), "little")
        connection.sendall(bytes(size))

    def fetch(port, size):
        connection = wire.connect(port, timeout=20)
        begin = time.monotonic()
        connection.sendall(size.to_bytes(4, "little"))
        wire.receive(connection, size)
        connection.close()
        return time.monotonic() - begin

    with wire.Server(echo) as server, proxy.Proxy(server.port, delay=40) as network:
        took = fetch(network.port, 1)
        checks.expect(took >= 0.08, f"80 ms and back took {took:.3f} s")
        network.set(rate=800e3)
        took = fetch(network.port, 100_000)
        checks.expect(took >= 0.99, f"100 kB at 800 kbit/s took {took:.2f} s")
        network.set(cut=1)
        begin = time.monotonic()
        connection = wire.connect(network.port, timeout=20)
        connection.sendall((1000).to_bytes(4, "little"))
        time.sleep(0.5)
        network.set(cut=0)
        wire.receive(connection, 1000)
        checks.expect(time.monotonic() - begin >= 0.5, "a cut holds everything back and loses nothing")
        connection.close()
        connection = wire.connect(network.port)
        time.sleep(0.1)
        network.reset()
        try:
            connection.recv(1)
            was_reset = False
        except ConnectionResetError:
            was_reset = True
        checks.expect(was_reset, "a reset reaches the client")


def viewer_sees_a_server(room, checks):
    """a viewer gets frames and reconnects after a reset, and the programs end when asked"""
    server, port = room.serve()
    with proxy.Proxy(port, delay=5) as network, wire.Viewer(network.port, keep_bodies=1) as viewer:
        checks.expect(viewer.wait_for_frames(10, 20), "ten frames arrive")
        checks.expect(wire.frame_body(viewer.bodies[0]) == viewer.bodies[0], "a frame's head is read and written alike")
        before = len(viewer.arrivals)
        network.reset()
        checks.expect(viewer.wait_for_frames(before + 10, 20), "ten more after a reset")
    checks.expect(server.end() == 0, "the server ends with 0 when asked")


def client_meets_a_server_of_ours(room, checks):
    """render_client accepts the test server's welcome and frames"""
    real, port = room.serve()
    first, bodies = wire.frames_of(port, 40)
    real.end()
    acknowledged = []

    def behave(connection):
        wire.shake_hands(connection, wire.message(wire.WELCOME, first))
        for body in bodies:
            connection.sendall(wire.message(wire.FRAME, body))
            kind, answer = wire.read_message(connection)
            while kind != wire.FRAME_ACK:
                kind, answer = wire.read_message(connection)
            acknowledged.append(answer)
        connection.sendall(wire.end_of_stream("that was all"))
        wire.hear_out(connection)

    with wire.Server(behave) as server:
        client = room.view(server.port)
        client.says("that was all", within=30)
        checks.expect(client.end() == 0, "the client ends with 0")
    decoded = room.stats()["cameras"][0]
    checks.expect(len(acknowledged) >= 40, f"{len(acknowledged)} frames acknowledged")
    checks.expect(decoded["drops"]["decode_error"] == 0, "none is damaged")


if __name__ == "__main__":
    programs.run([proxy_delays_and_paces, viewer_sees_a_server, client_meets_a_server_of_ours], __doc__)
