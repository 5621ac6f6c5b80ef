"""Writes the files beside it with NumPy, SciPy and h5py, to be read by tests/samples.rs.

    python3 -m venv /tmp/venv && /tmp/venv/bin/pip install numpy scipy h5py
    /tmp/venv/bin/python make.py

The text files follow ATI's manual and application (see src/samples/ati.rs) and are written by hand below.
Every file holds the same 48 samples (text: the first 16) at 1 kHz: channel i (Fx .. Tz = 0 .. 5) is
(i + 1) cos(2 pi 25 t + i) N, thousandths of that in N m.
"""

import h5py
import numpy as np
import scipy.io

RATE = 1000.0
t = np.arange(48) / RATE
names = ["Fx", "Fy", "Fz", "Tx", "Ty", "Tz"]
channels = {n: (i + 1) * np.cos(2 * np.pi * 25 * t + i) * (1 if i < 3 else 1e-3) for i, n in enumerate(names)}
matrix = np.array([channels[n] for n in names])

# NumPy: units in the names; and a matrix of newtons and newton millimetres in single precision, compressed.
np.savez("units_in_names.npz", time_s=t, **{n + ("_N" if n[0] == "F" else "_Nm"): c for n, c in channels.items()})
scaled = matrix.T * np.where(np.arange(6) < 3, 1, 1000)
np.savez_compressed("matrix.npz", wrench=scaled.astype("f4"), note=np.array("text"), cube=np.zeros((2, 2, 2)))
np.save("matrix.npy", np.asfortranarray(matrix.T).astype(">f8"))

# MATLAB 5: columns as MATLAB keeps them, plain and compressed; counts as 32-bit integers.
scipy.io.savemat("columns.mat", {**{n: c[:, None] for n, c in channels.items()}, "t": t[:, None], "note": "text"})
counts = np.round(matrix.T * 1e6).astype("i4")
scipy.io.savemat("counts.mat", {"counts": counts, "angle": np.rad2deg(2 * np.pi * 25 * t)}, do_compression=True)

# HDF5: groups, units as attributes, chunks, compression, byte shuffling, big-endian.
with h5py.File("groups.h5", "w") as f:
    run = f.create_group("run/1")
    for n, c in channels.items():
        packed = {"chunks": (16,), "compression": "gzip", "shuffle": True} if n == "Fz" else {}
        d = run.create_dataset(n, data=c * (1 if n[0] == "F" else 1e3), **packed)
        d.attrs["units"] = "N" if n[0] == "F" else "N mm"
    clock = run.create_dataset("clock", data=(t * 1e3).astype(">f8"))
    clock.attrs["unit"] = np.bytes_("ms")

# MATLAB 7.3 is HDF5 behind 512 bytes of its own; arrays lie transposed, as MATLAB writes them.
with h5py.File("version73.mat", "w", userblock_size=512) as f:
    f.create_dataset("wrench", data=matrix).attrs["MATLAB_class"] = np.bytes_("double")
    f.create_dataset("time_s", data=t[None, :]).attrs["MATLAB_class"] = np.bytes_("double")
with open("version73.mat", "r+b") as f:
    f.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


# ATI's demo application: samples 5 and 6 missing, a warning at 9; later versions divide, the manual's do not.
KEPT = [k for k in range(16) if k not in (5, 6)]
START = ["Start Time: 11/20/26 9:31 AM", "RDT Sample Rate: 1000"]
NOTE = ['"PLEASE NOTE: The sample rate is read from the Net F/T when the program starts."']
UNITS = ["Force Units: N", "Counts per Unit Force: 1000000.0", "Torque Units: Nmm", "Counts per Unit Torque: 1000.0"]
HEADER = ["Status (hex)", "RDT Sequence", "F/T Sequence", *names, "Time"]


def cells(k, divided):
    counts = [round(channels[n][k] * 1e6) for n in names]
    values = [c / (1e6 if i < 3 else 1e3) for i, c in enumerate(counts)] if divided else counts
    return ["0x80010000" if k == 9 else "0x0", k + 1, 7 * k + 100, *values, "Nov 20, 2026 9:31:06 AM"]


def ati(file, lines, rows, newline="\n"):
    with open(file, "w", newline=newline) as f:
        f.write("\n".join(lines + rows) + "\n")


quoted = lambda divided: [",".join(f'"{c}"' for c in cells(k, divided)) for k in KEPT]
ati("ati_units.csv", START + NOTE + UNITS + [", ".join(HEADER)], quoted(True), "\r\n")
ati("ati_counts.csv", START + UNITS + [", ".join(HEADER)], quoted(False))
ati("ati_tabs.txt", START + UNITS + ["\t".join(HEADER)], ["\t".join(map(str, cells(k, True))) for k in KEPT])

# Columns with names and units; a German spreadsheet.
head = "time_s,fx_N,fy_N,fz_N,tx_Nmm,ty_Nmm,tz_Nmm,stroke_deg"
rows = [",".join([f"{t[k]:.4f}", *(f"{x:.9g}" for x in scaled[k]), f"{9 * k:.3f}"]) for k in range(16)]
ati("named.csv", [head], rows)
head = "Time [s];Fx [N];Fy [N];Fz [N];Tx [N-m];Ty [N-m];Tz [N-m]"
rows = [";".join([f"{t[k]:.4f}", *(f"{x:.9g}" for x in matrix[:, k])]).replace(".", ",") for k in range(16)]
ati("semicolons.csv", [head], rows)
