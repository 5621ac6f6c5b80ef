"""Many runs of one scenario or case, on this machine or on many."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache, partial
from itertools import islice
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from wingbeat import _wingbeat
from wingbeat._documents import Overrides, Source, document
from wingbeat._extras import needed
from wingbeat._record import Record
from wingbeat._verdicts import judged

if TYPE_CHECKING:
    from distributed import Client

Row: TypeAlias = list[float]
# Number of a candidate and its values.
Candidate: TypeAlias = tuple[int, list[float]]

# What an unfinished sweep holds, and a finished one.
IDENTITY, LOG, DATA = "sweep.toml", "rows.log", "record.parquet"
# What a search leaves beside it.
SUMMARY, BEST = "summary.json", "best.toml"
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


def make_candidates(text: str, batch: list[Candidate]) -> list[Row]:
    """Candidates of the search that ``text`` holds, by their numbers and values."""
    rows = _flown(_checked(text), batch)
    if len(rows) < len(batch):
        raise RuntimeError(f"candidates {[run for run, _ in batch]} were stopped")
    return rows


def _flown(native: _wingbeat.Sweep, batch: list[Candidate]) -> list[Row]:
    """Rows of candidates; none of those that were stopped."""
    rows = [native.candidate(run, values) for run, values in batch]
    return [row for row in rows if row is not None]


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
    """Makes all runs of a sweep, or the candidates of a search, into a folder.

    Rows are the same on any number of cores and machines. What was interrupted or killed goes on from what is done when the same
    call is made again.

    Parameters
    ----------
    source
        A sweep file, or a dictionary of the same keys: ``scenario`` or ``case``, ``set``, ``draws``, and ``sampling`` as ``grid``,
        ``latin_hypercube`` or ``random``; with ``search`` the goals of a search for the numbers in ``draws``.
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
        A row per run, also in ``record.parquet`` of the folder. A search has a row per candidate with its ``cost``, and leaves
        ``summary.json`` and ``best.toml``, the scenario of the best one, in the folder too.
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
    try:
        with _workers(native, text, engine, cores, address) as made:
            if native.searches:
                while generation := native.candidates(list(log.rows.values())):
                    for row in made(iter([[candidate] for candidate in generation])):
                        log.append(row)
            else:
                left = [run for run in range(native.runs) if run not in log.rows]
                for row in made(iter(native.batches(left))):
                    log.append(row)
    finally:
        log.close()
    rows = [log.rows[run] for run in range(native.runs)]
    record = Record(native.table(rows))
    if native.searches:
        summary, best = native.found(rows)
        _put(folder / SUMMARY, lambda path: path.write_text(summary, encoding="utf-8"))
        _put(folder / BEST, lambda path: path.write_text(best, encoding="utf-8"))
        judged(summary)
    _put(folder / DATA, record.write)
    log.remove()
    return record


def _put(path: Path, write: Callable[[Path], object]) -> None:
    """Has a file written beside its place and moves it there: what stands there is whole."""
    beside = path.with_name(f".{path.name}.partial")
    write(beside)
    beside.replace(path)


# Makes batches of runs, or of candidates.
Made: TypeAlias = "Callable[[Iterator[list[Any]]], Iterator[Row]]"


@contextmanager
def _workers(native: _wingbeat.Sweep, text: str, engine: str, cores: int | None, address: str | None) -> Iterator[Made]:
    """What makes runs: threads, or the workers of Dask."""
    if engine == "local":
        make: Callable[[list[Any]], list[Row]] = partial(_flown, native) if native.searches else native.rows
        yield lambda todo: _local(native, todo, cores, make)
        return
    with _client(cores, address) as client:
        [shared] = client.scatter([text], broadcast=True)
        call = make_candidates if native.searches else make_runs
        yield lambda todo: _dask(client, todo, (call, shared))


def _local(
    native: _wingbeat.Sweep, todo: Iterator[list[Any]], cores: int | None, make: Callable[[list[Any]], list[Row]]
) -> Iterator[Row]:
    """Rows as they are done, on threads: the library leaves the interpreter to others."""
    from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait

    pool = ThreadPoolExecutor(cores or os.cpu_count() or 1, thread_name_prefix="wingbeat")
    try:
        pending = {pool.submit(make, batch) for batch in islice(todo, WINDOW)}
        while pending:
            # Looks for Ctrl-C between: a wait without an end hears it only when a run is done.
            done, pending = wait(pending, LOOK_S, FIRST_COMPLETED)
            for future in done:
                yield from future.result()
            pending |= {pool.submit(make, batch) for batch in islice(todo, len(done))}
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


def _dask(client: Client, todo: Iterator[list[Any]], call: tuple[Any, ...]) -> Iterator[Row]:
    """Rows as they are done by the workers; what a killed worker had is made by another one."""
    as_completed = needed("distributed", "dask").as_completed

    def submit(batch: list[Any]) -> Any:
        return client.submit(*call, batch, pure=False, retries=0)

    futures = as_completed([submit(batch) for batch in islice(todo, WINDOW)], with_results=True)
    for future, rows in futures:
        future.release()
        yield from rows
        for batch in islice(todo, 1):
            futures.add(submit(batch))
