"""Arguments of an unlucky or hostile user."""

import copy
import random
import sys
from pathlib import Path



class Raises:
    """Raises whatever is asked of it."""

    def _raise(self, *_):
        raise ValueError("raised by the argument")

    __float__ = __index__ = __len__ = __iter__ = __getitem__ = __fspath__ = __bool__ = __array__ = __call__ = _raise
    __hash__ = object.__hash__

    def __repr__(self):
        return "Raises()"


class Endless:
    """Is as long as one waits, and its own list."""

    def __iter__(self):
        while True:
            yield 1.0

    def __len__(self):
        return 2**62

    def tolist(self):
        return self

    def __fspath__(self):
        return self

    def __repr__(self):
        return "Endless()"


class Lies:
    """Says that it is short and is a number, and is not."""

    size = -1
    shape = (2**40, 2**40)

    def __len__(self):
        return 3

    def __getitem__(self, place):
        raise IndexError(f"nothing at {place}")

    def __float__(self):
        return float("nan")

    def __repr__(self):
        return "Lies()"


def inside():
    """A dictionary that holds itself, and a list that does."""
    table = {}
    table["a"] = table
    row = []
    row.append(row)
    return random.choice([table, row, {"flight": table}, {"a": row}])


def deep(rng):
    """Lists or tables in one another."""
    value = rng.choice([1.0, [], {}])
    table = rng.random() < 0.5
    for _ in range(rng.choice([10, 70, 500, 10_000])):
        value = {"a": value} if table else [value]
    return value


def number(rng):
    """A number, or what may be taken for one."""
    import numpy as np

    return rng.choice(
        [0, -1, 1, 2, 7, 0.0, -0.0, 0.5, 1e-3, -1e-3, 5e-324, 1e-300, 1e12, 1e300, -1e300, float("nan"), float("inf"),
         -float("inf"), 2**31, 2**63 - 1, 2**63, 2**64, -(2**63) - 1, 10**400, True, np.float32(0.1), np.int8(-3), np.float64("nan"),
         np.uint64(2**64 - 1), 1j, rng.uniform(-10.0, 10.0), rng.randrange(100)]
    )


def text(rng):
    """A text."""
    return rng.choice(
        ["", "a", "\0", "\ud800", "roll", "flight.duration_s", "a.b.c.d", "=", "a=b", '"', "'''", "[[[", "{", "nan", "x" * 1_000_000,
         "é" * 50, "../../etc", "/", "/nonexistent/file.toml", "glide.toml\n", "[" * 5000, "a." * 5000, "🦇", "__class__", "f64", "dask"]
    )


def path(rng, pool):
    """A path, seldom of a file that is meant."""
    return rng.choice(
        [pool.folder, pool.folder / "absent", Path("/"), Path("/dev/null"), Path("/dev/zero"), Path("/dev/full"), Path("/proc/self/mem"),
         Path("/proc/self/status"), pool.fifo, pool.binary, pool.empty, pool.parquet, pool.csv, Path("x" * 300), b"glide.toml",
         pool.folder / "new" / "deep" / "file", "", ".", pool.locked]
    )


def array(rng):
    """An array."""
    import numpy as np

    size = rng.choice([0, 1, 2, 3, 8, 13, 100, 1000, 300_000])
    wild = np.array([0.0, 1.0, -1.0, np.nan, np.inf, 1e300, -1e300, 5e-324])
    made = wild[np.random.default_rng(rng.randrange(2**31)).integers(0, len(wild), size)]
    kind = rng.randrange(12)
    if kind == 0:
        return made.astype(np.float32)
    if kind == 1:
        return np.asfortranarray(made.reshape(-1, 1) + np.zeros((1, 3)))
    if kind == 2:
        return made[::-1]
    if kind == 3:
        return made[::2].astype(object)
    if kind == 4:
        return np.zeros((2, 2, 2))
    if kind == 5:
        return np.zeros(3, dtype=[("a", "f8"), ("b", "i4")])
    if kind == 6:
        return np.array(["a", "b"])
    if kind == 7:
        return np.broadcast_to(np.float64(1.0), (5_000_000,))
    if kind == 8:
        return np.zeros(5_000_000)
    if kind == 9:
        return np.array(made, dtype=">f8")
    if kind == 10:
        return np.ma.masked_invalid(made)
    return made


def anything(rng, pool):
    """Whatever a user might hand over."""
    kind = rng.randrange(12)
    if kind < 4:
        return number(rng)
    if kind == 4:
        return text(rng)
    if kind == 5:
        return path(rng, pool)
    if kind == 6:
        return array(rng)
    if kind == 7:
        return rng.choice([inside(), deep(rng)])
    if kind == 8:
        return [number(rng) for _ in range(rng.choice([0, 1, 2, 3, 8, 13, 200]))]
    if kind == 9:
        return {text(rng): number(rng) for _ in range(rng.randrange(4))}
    if kind == 10:
        return rng.choice(
            [None, (), [], {}, set(), b"", b"\xff" * 100, bytearray(10), memoryview(b"abc"), range(10**9), iter([1, 2]), object(), type,
             len, Raises(), Endless(), Lies(), Exception("an exception"), sys, slice(None), NotImplemented, ..., lambda *_: None,
             pool.thrower, frozenset([1]), complex(1, 1)]
        )
    return rng.choice(pool.objects())


def spoiled(rng, table):
    """A table of keys with another value, or none, at one to three of its keys."""
    table = copy.deepcopy(table)
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        at = table
        for _ in range(6):
            keys = list(at) if isinstance(at, dict) else list(range(len(at)))
            if not keys:
                break
            key = rng.choice(keys)
            below = at[key]
            if isinstance(below, dict | list) and rng.random() < 0.9:
                at = below
                continue
            act = rng.randrange(10)
            if act == 0:
                del at[key]
            elif act == 1:
                at[key] = rng.choice([inside(), [], {}, None, b"x", object(), Endless(), "", "nan"])
            elif isinstance(below, float | int) and act < 5:
                at[key] = below * rng.choice([-1.0, 0.0, 0.5, 2.0, 10.0, 1e3, 1e-3])
            else:
                at[key] = number(rng)
            break
    return table
