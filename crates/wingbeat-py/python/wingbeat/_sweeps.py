"""Many runs of one scenario or case, on this machine or on many."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from itertools import islice
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from wingbeat import _wingbeat
from wingbeat._documents import Overrides, Source, document
from wingbeat._extras import needed
from wingbeat._record import Record

if TYPE_CHECKING:
    from distributed import Client

Row: TypeAlias = list[float]

# What an unfinished sweep holds, and a finished one.
IDENTITY, LOG, DATA = "sweep.toml", "rows.log", "record.parquet"
# Runs that are given to a scheduler at once.
WINDOW = 2000
# Time between two looks for Ctrl-C, s.
LOOK_S = 0.1


@lru_cache(maxsize=4)
def _checked(text: str) -> _wingbeat.Sweep:
    """A sweep, checked once by each process."""
    return _wingbeat.Sweep(_wingbeat.Document.text("sweep", text))


def make_runs(text: str, batch: list[int]) -> list[Row]:
    """Runs of the sweep that ``text`` holds: the same rows wherever they are made."""
    rows = _checked(text).rows(batch)
    if len(rows) < len(batch):
        raise RuntimeError(f"runs {batch} were stopped")
    return rows


class _Log:
    """Rows on disk as soon as they are known; numbers keep all their digits."""

    def __init__(self, folder: Path, sweep: _wingbeat.Sweep) -> None:
        self._path = folder / LOG
        self.rows: dict[int, Row] = {}
        text = self._path.read_text(encoding="utf-8") if self._path.exists() else ""
        whole = text[: text.rfind("\n") + 1]
        for number, line in enumerate(whole.splitlines(), 1):
            row = [float(cell) for cell in line.split(",")]
            if not sweep.has_row(row) or int(row[0]) in self.rows:
                raise ValueError(
                    f"{self._path}:{number}: no run of this sweep, or one that is there already: move the file away"
                )
            self.rows[int(row[0])] = row
        # A last line that was cut short goes.
        self._path.write_text(whole, encoding="utf-8")
        self._file = self._path.open("a", encoding="utf-8")

    def append(self, row: Row) -> None:
        """Adds a row."""
        self._file.write(",".join(map(repr, row)) + "\n")
        self._file.flush()
        self.rows[int(row[0])] = row

    def close(self) -> None:
        """Closes the file."""
        self._file.close()

    def remove(self) -> None:
        """Removes the file."""
        self.close()
        self._path.unlink()


def sweep(
    source: Source,
    overrides: Overrides | None = None,
    *,
    out: str | PathLike[str],
    engine: Literal["local", "dask"] = "local",
    cores: int | None = None,
    address: str | None = None,
) -> Record:
    """Makes all runs of a sweep into a folder.

    Rows are the same on any number of cores and machines. What was interrupted or killed goes on from what is done when the same
    call is made again.

    Parameters
    ----------
    source
        A sweep file, or a dictionary of the same keys: ``scenario`` or ``case``, ``set``, ``draws``, and ``sampling`` as ``grid``,
        ``latin_hypercube`` or ``random``.
    overrides
        Keys of the sweep that are set otherwise: ``{"runs": 20}``, or ``{"scenario": {"flight": {"duration_s": 1.0}}}``.
    out
        Folder of the rows; new, empty, or that of the same sweep.
    engine
        ``local``, or ``dask``: on the scheduler at ``address``, or on a cluster of processes on this machine.
    cores
        Number of threads or processes; without it as many as there are processors.
    address
        Address of the scheduler of Dask, ``tcp://host:8786``.

    Returns
    -------
    Record
        A row per run, also in ``record.parquet`` of the folder.
    """
    if engine not in ("local", "dask"):
        raise ValueError(f"engine = {engine!r}: allowed is 'local', 'dask'")
    if cores is not None and cores < 1:
        raise ValueError(f"cores = {cores}: allowed is 1 or more")
    if address is not None and engine != "dask":
        raise ValueError("address: allowed with engine='dask'")
    native = _wingbeat.Sweep(document(source, overrides, "sweep"))
    text = native.resolved
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    identity = folder / IDENTITY
    if identity.exists():
        if identity.read_text(encoding="utf-8") != text:
            raise ValueError(f"{identity}: another sweep is here: allowed is another folder")
        if (folder / DATA).exists():
            return Record.read(folder / DATA)
    elif any(folder.iterdir()):
        raise ValueError(f"{folder}: allowed is a new or empty folder, or that of the same sweep")
    else:
        identity.write_text(text, encoding="utf-8")
    log = _Log(folder, native)
    todo = iter(native.batches([run for run in range(native.runs) if run not in log.rows]))
    try:
        rows = _local(native, todo, cores) if engine == "local" else _dask(text, todo, cores, address)
        for row in rows:
            log.append(row)
    finally:
        log.close()
    record = Record(native.table([log.rows[run] for run in range(native.runs)]))
    partial = folder / f".{DATA}.partial"
    record.write(partial)
    partial.replace(folder / DATA)
    log.remove()
    return record


def _local(native: _wingbeat.Sweep, todo: Iterator[list[int]], cores: int | None) -> Iterator[Row]:
    """Rows as they are done, on threads: the library leaves the interpreter to others."""
    from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait

    pool = ThreadPoolExecutor(cores or os.cpu_count() or 1, thread_name_prefix="wingbeat")
    try:
        pending = {pool.submit(native.rows, batch) for batch in islice(todo, WINDOW)}
        while pending:
            # Looks for Ctrl-C between: a wait without an end hears it only when a run is done.
            done, pending = wait(pending, LOOK_S, FIRST_COMPLETED)
            for future in done:
                yield from future.result()
            pending |= {pool.submit(native.rows, batch) for batch in islice(todo, len(done))}
    except BaseException:
        native.stop()
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


@contextmanager
def _client(cores: int | None, address: str | None) -> Iterator[Client]:
    """A scheduler's client: that at ``address``, or of a cluster of processes on this machine."""
    distributed = needed("distributed", "dask")
    if address is not None:
        with distributed.Client(address) as client:
            yield client
        return
    workers = cores or os.cpu_count() or 1
    with (
        distributed.LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


def _dask(text: str, todo: Iterator[list[int]], cores: int | None, address: str | None) -> Iterator[Row]:
    """Rows as they are done by the workers; what a killed worker had is made by another one."""
    as_completed = needed("distributed", "dask").as_completed

    with _client(cores, address) as client:
        [shared] = client.scatter([text], broadcast=True)

        def submit(batch: list[int]) -> Any:
            return client.submit(make_runs, shared, batch, pure=False, retries=0)

        futures = as_completed([submit(batch) for batch in islice(todo, WINDOW)], with_results=True)
        for future, rows in futures:
            future.release()
            yield from rows
            for batch in islice(todo, 1):
                futures.add(submit(batch))
