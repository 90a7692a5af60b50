#!/usr/bin/env python3
"""Runs packaging/nginx/copresence.conf before two gateways of one room: tests/web_gateway/nginx.py [--bin FOLDER]

Exits with 77 where nginx or openssl is missing."""
import os
import re
import shutil
import socket
import subprocess
import sys
import time

from gateway import serve_pages, with_token
from page import Page, Refused, WebSocket, get
import programs

SETTINGS = programs.ROOT / "packaging/nginx/copresence.conf"
WHOLE = """daemon off;
pid {folder}/nginx.pid;
error_log {folder}/error.log;
events {{}}
http {{
    access_log off;
    client_body_temp_path {folder}/body;
    proxy_temp_path {folder}/proxy;
    fastcgi_temp_path {folder}/fastcgi;
    uwsgi_temp_path {folder}/uwsgi;
    scgi_temp_path {folder}/scgi;
    include {folder}/copresence.conf;
}}
"""


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return listener.getsockname()[1]


def start_nginx(room, gateways):
    """Starts nginx with the packaged settings, changed to these ports and a certificate of this test."""
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes",
                    "-days", "2", "-subj", "/CN=localhost", "-keyout", room.folder / "privkey.pem",
                    "-out", room.folder / "fullchain.pem"], check=True, capture_output=True, timeout=30)
    port, text = free_port(), SETTINGS.read_text()
    for number, gateway in zip(("8080", "8081"), gateways):
        text = text.replace(f"server 127.0.0.1:{number};", f"server 127.0.0.1:{gateway};")
    text = text.replace("listen 443 ", f"listen 127.0.0.1:{port} ").replace("    listen [::]:443 ssl http2;\n", "")
    text = re.sub(r"/etc/letsencrypt/live/ROOM.EXAMPLE", str(room.folder), text).replace("ROOM.EXAMPLE", "localhost")
    (room.folder / "copresence.conf").write_text(text)
    (room.folder / "nginx.conf").write_text(WHOLE.format(folder=room.folder))
    nginx = room.start(["nginx", "-e", room.folder / "error.log", "-p", room.folder, "-c", room.folder / "nginx.conf"])
    return nginx, port


def two_gateways_behind_nginx(room, checks):
    """viewers reach the room by HTTPS through nginx, spread over two gateways, and stay with one when the other ends"""
    _, server = room.serve()
    token, options = with_token(room)
    first, second = serve_pages(room, server, more=options), serve_pages(room, server, more=options)
    _, port = start_nginx(room, (first[1], second[1]))
    host = f"localhost:{port}"
    limit = time.monotonic() + 10
    status, headers = 0, {}
    while status != 200 and time.monotonic() < limit:
        try:
            status, headers, _ = get(port, tls=True, host=host)
        except OSError:  # nginx has not started yet
            time.sleep(0.1)
    checks.expect(status == 200 and "content-security-policy" in headers, "the page comes through nginx")
    pages = [Page(port, token, tls=True, host=host) for _ in range(4)]
    try:
        checks.expect(all(page.wait_for_frames(60, 20) for page in pages), "four viewers see the room")
        for program, _ in (first, second):
            checks.expect("viewer 127.0.0.1" in program.said(), "each gateway has a viewer")
        try:
            WebSocket(port, tls=True, host=host, origin="https://attacker.example").close()
            checks.expect(False, "another site's script opens the room")
        except Refused as refused:
            checks.expect(refused.args == (403,), "another site's script gets 403")
        first[0].end()
        ended = [page for page in pages if page.wait_for(lambda page=page: page.ended, 2)]
        checks.expect(len(ended) == 2, f"{len(ended)} of 4 viewers lost their gateway")
        with Page(port, token, tls=True, host=host) as again:
            checks.expect(again.wait_for_frames(10, 20), "they see the room again through the other one")
    finally:
        for page in pages:
            page.end()


if __name__ == "__main__":
    if not shutil.which("nginx", path=os.environ["PATH"] + ":/usr/sbin") or not shutil.which("openssl"):
        sys.exit(77)
    os.environ["PATH"] += ":/usr/sbin"
    programs.run([two_gateways_behind_nginx], __doc__)
