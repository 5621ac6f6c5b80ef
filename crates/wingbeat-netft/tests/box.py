"""A Net F/T box of its own: RDT over UDP and the page /netftapi2.xml, by the maker's manual (9620-05-NET FT).

usage: box.py RDT_PORT HTTP_PORT; it prints `ready` and runs until it is killed. Forces are in lbf, torques in
lbf-in; sample k of the box carries the counts wave(k).
"""

import http.server
import math
import socket
import struct
import sys
import threading
import time

RATE = 7000.0
COUNTS_PER_FORCE = 4448221.6152605
COUNTS_PER_TORQUE = 112984.8290276167
PACK = 40

PAGE = f"""<?xml version="1.0" encoding="ISO-8859-1"?>
<netft>
<runstat>0</runstat><runft>0</runft><prodname>Ethernet box \u00b1</prodname>
<cfgnam>Config #0</cfgnam><cfgfu>1</cfgfu><scfgfu>lbf</scfgfu><cfgtu>1</cfgtu><scfgtu>lbf-in</scfgtu>
<cfgcpf>{COUNTS_PER_FORCE}</cfgcpf><cfgcpt>{COUNTS_PER_TORQUE}</cfgcpt><comrdtrate>7000</comrdtrate>
</netft>
"""


class Pages(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        found = self.path == "/netftapi2.xml"
        body = PAGE.encode("latin-1") if found else b""
        self.send_response(200 if found else 404)
        self.send_header("Content-Type", "text/xml")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


def wave(k):
    """Counts of Fx Fy Fz Tx Ty Tz at sample k."""
    angle = 2.0 * math.pi * 3.5 * k / RATE
    return [round((500000 + 1000 * i) * math.sin(angle + i)) for i in range(6)]


def stream(port):
    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    link.bind(("127.0.0.1", port))
    link.settimeout(0.001)
    born = time.monotonic()
    client, pack, left, sent, first, began = None, 1, 0, 0, 0, 0.0
    offset = [0] * 6
    while True:
        try:
            request, sender = link.recvfrom(64)
            if len(request) == 8:
                header, command, count = struct.unpack("!HHI", request)
                now = int((time.monotonic() - born) * RATE)
                if header == 0x1234 and command == 0:
                    client = None
                elif header == 0x1234 and command in (2, 3):
                    client, pack, left = sender, PACK if command == 3 else 1, count
                    sent, first, began = 0, now, time.monotonic()
                elif header == 0x1234 and command == 0x42:
                    offset = wave(now)
        except (socket.timeout, ConnectionError):
            pass
        while client is not None and sent + pack <= (time.monotonic() - began) * RATE:
            records = []
            for _ in range(pack):
                sent += 1
                k = first + sent
                counts = [a - b for a, b in zip(wave(k), offset)]
                records.append(struct.pack("!IIIiiiiii", sent, k & 0xFFFFFFFF, 0, *counts))
            link.sendto(b"".join(records), client)
            if left and sent >= left:
                client = None


if __name__ == "__main__":
    rdt, pages = int(sys.argv[1]), int(sys.argv[2])
    server = http.server.ThreadingHTTPServer(("127.0.0.1", pages), Pages)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    threading.Thread(target=stream, args=(rdt,), daemon=True).start()
    print("ready", flush=True)
    threading.Event().wait()
