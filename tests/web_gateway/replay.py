"""Cameras that cost no processor: capture servers in Python that repeat recorded frames at 30 frames a second.

A server repeats the frames of a real one under new numbers and times. It begins again at the keyframe when a client
asks for one, at most once a second. Test programs import this module; it has no command line."""
import select
import struct
import time

import wire

PERIOD = 1 / 30
FRAMES = 120


def record(room):
    """The welcome and the first frames of a real server."""
    real, port = room.serve()
    welcome, bodies = wire.frames_of(port, FRAMES, within=120)
    real.end()
    # Frames after a second keyframe belong to another group.
    later = [number for number, body in enumerate(bodies) if number and wire.frame_head(body)["flags"] & wire.KEYFRAME]
    return welcome, bodies[:later[0]] if later else bodies


class ReplayedCamera(wire.Server):
    def __init__(self, welcome, bodies):
        self.welcome, self.bodies = welcome, bodies
        super().__init__(self.stream)

    def stream(self, connection):
        wire.shake_hands(connection, wire.message(wire.WELCOME, self.welcome))
        sequence, place, keyframe_at, asked = 0, 0, 0.0, False
        due = time.monotonic()
        while not self.ended:
            due += PERIOD
            while (left := due - time.monotonic()) > 0:
                if select.select([connection], [], [], left)[0]:
                    kind, body = wire.read_message(connection)
                    asked |= kind == wire.KEYFRAME_REQUEST
                    if kind == wire.PING:
                        connection.sendall(wire.pong(*struct.unpack("<Q", body)))
            due = max(due, time.monotonic() - 0.2)  # a machine that was busy catches up no further
            if asked and time.monotonic() - keyframe_at > 1:
                asked, place = False, 0
            if place == len(self.bodies):
                place = 0
            if place == 0:
                keyframe_at = time.monotonic()
            sequence += 1
            body = wire.frame_body(self.bodies[place], sequence=sequence, sent_at=time.monotonic_ns(),
                                   captured=sequence, encoder_busy=0, window_full=0)
            connection.sendall(wire.message(wire.FRAME, body))
            place += 1
