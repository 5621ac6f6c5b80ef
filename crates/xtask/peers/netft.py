"""pynetft and our recorder on the same emulated box: usage netft.py NETFT_WORKER."""

import json
import subprocess
import sys

from pynetft import Client, Config

# Samples that pynetft reads: two seconds.
COUNT = 14000
# The flapping signal repeats after so many samples.
PERIOD = 2000
FORCE = {"N": 1.0}
TORQUE = {"N-m": 1.0, "N-mm": 1e-3}

worker = subprocess.Popen([sys.argv[1]], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
ours = {}
for line in worker.stdout:
    words = line.split()
    if words[0] == "ready":
        break
    ours[int(words[0]) % PERIOD] = [float(word) for word in words[1:]]

force_difference = torque_difference = 0.0
config = Config(sensor_host="127.0.0.1", rdt_port=int(words[1]), http_port=int(words[2]))
read = 0
with Client(config, queue_size=COUNT) as client:
    for sample in client.samples(timeout=5.0):
        here = ours[sample.ft_sequence % PERIOD]
        force = [x * FORCE[sample.force_unit.value] for x in sample.force]
        torque = [x * TORQUE[sample.torque_unit.value] for x in sample.torque]
        force_difference = max(force_difference, *(abs(a - b) for a, b in zip(force, here[:3])))
        torque_difference = max(torque_difference, *(abs(a - b) for a, b in zip(torque, here[3:])))
        read += 1
        if read == COUNT:
            break
    health = client.health()
worker.stdin.close()
worker.wait()
print(
    json.dumps(
        {
            "samples": read,
            "phases": len(ours),
            "lost": health.lost_count,
            "duplicate": health.duplicate_count,
            "malformed": health.malformed_count,
            "reconnects": health.reconnect_count,
            "force_n": force_difference,
            "torque_n_m": torque_difference,
        }
    )
)
