"""Records: named columns with units and frames."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from typing import TYPE_CHECKING, Any, TypeAlias, overload

import numpy as np
from numpy.typing import NDArray

from wingbeat import _wingbeat
from wingbeat._extras import needed

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class Column:
    """What a column of a record, a state or an input is."""

    name: str
    unit: str
    """SI unit; empty when dimensionless."""
    frame: str
    """Frame in which the number is resolved: ``W`` world, ``B`` body, ``WB`` body in world; empty when it has none."""
    low: float
    """Lower limit."""
    high: float
    """Upper limit."""


class Record(Mapping[str, Array]):
    """A run as columns: ``record["roll"]`` is an array that shares the run's memory and cannot be written to."""

    def __init__(self, columns: Sequence[tuple[str, str, str, float, float, Array]]) -> None:
        self._columns = [Column(*column[:5]) for column in columns]
        self._values = {column[0]: column[5] for column in columns}

    @classmethod
    def read(cls, path: str | PathLike[str]) -> Record:
        """A record that was written as Parquet."""
        return cls(_wingbeat.read_parquet(fspath(path)))

    def write(self, path: str | PathLike[str]) -> None:
        """Writes Parquet: the bytes that the program writes of the same run."""
        _wingbeat.write_parquet(fspath(path), self._given())

    def _given(self) -> list[tuple[str, str, str, float, float, Array]]:
        """The columns as the extension takes them."""
        return [(c.name, c.unit, c.frame, c.low, c.high, self._values[c.name]) for c in self._columns]

    def __getitem__(self, name: str) -> Array:
        try:
            return self._values[name]
        except KeyError:
            raise KeyError(f"{name}: allowed are {', '.join(self._values)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    @property
    def columns(self) -> list[Column]:
        """Names, units, frames and limits, in order."""
        return list(self._columns)

    @property
    def rows(self) -> int:
        """Number of instants."""
        return len(next(iter(self._values.values()))) if self._values else 0

    @property
    def units(self) -> dict[str, str]:
        """Units of the columns that have one."""
        return {column.name: column.unit for column in self._columns if column.unit}

    @property
    def frames(self) -> dict[str, str]:
        """Frames of the columns that have one."""
        return {column.name: column.frame for column in self._columns if column.frame}

    def to_numpy(self, names: Sequence[str] | None = None) -> Array:
        """The columns side by side, a copy: (rows, columns)."""
        chosen = list(self) if names is None else names
        table = np.empty((self.rows, len(chosen)))
        for place, name in enumerate(chosen):
            table[:, place] = self[name]
        return table

    def to_pandas(self) -> pd.DataFrame:
        """A table that shares the columns' memory; ``attrs`` holds units and frames, as pandas finds them in the file."""
        table: pd.DataFrame = needed("pandas", "tables").DataFrame(self._values, copy=False)
        table.attrs = {"units": self.units, "frames": self.frames}
        return table

    def plot(self, names: str | Sequence[str] | None = None, *, against: str | None = None) -> Figure:
        """Columns over time, or over the runs of a sweep, one panel per unit, limits dashed; joined by lines where what they are drawn over
        rises from run to run, else marks. Where none is named: of a flight attitude,
        position and commands, of a tethered wing lift, drag, power and hinges.
        """
        from wingbeat._figures import columns

        return columns(self, names, against)

    def __eq__(self, other: object) -> bool:
        """Whether both have the same columns with the same values; one that is not a number is equal to itself."""
        if not isinstance(other, Record):
            return NotImplemented
        values = other._values
        return self._columns == other._columns and all(
            np.array_equal(own, values[name], equal_nan=True) for name, own in self._values.items()
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"Record({self.rows} rows, {len(self)} columns)"


class Strips:
    """Loads and motion of the strips of all surfaces: an array (time, strip, component)."""

    def __init__(self, record: Record) -> None:
        self.record = record
        """One row per strip and instant."""
        times = record["t"]
        # All strips of an instant follow one another.
        self._count = int(np.count_nonzero(times == times[0])) if record.rows else 0

    @property
    def t(self) -> Array:
        """The instants, s."""
        return self.record["t"][:: max(self._count, 1)]

    @property
    def components(self) -> list[str]:
        """Names along the last axis."""
        return list(self.record)

    @property
    def count(self) -> int:
        """Number of strips."""
        return self._count

    def __getitem__(self, component: str) -> Array:
        """A component, (time, strip), without a copy."""
        return self.record[component].reshape(-1, max(self._count, 1))

    @overload
    def __array__(self, dtype: None = None, copy: bool | None = None) -> Array: ...
    @overload
    def __array__(self, dtype: Any, copy: bool | None = None) -> NDArray[Any]: ...
    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        if copy is False:
            raise ValueError("the components lie apart: an array of all of them is a copy")
        return self.array.astype(dtype, copy=False)

    @property
    def array(self) -> Array:
        """All components, a copy: (time, strip, component)."""
        return np.stack([self[name] for name in self.components], axis=-1)

    def __repr__(self) -> str:
        return f"Strips({len(self.t)} instants, {self.count} strips, {len(self.components)} components)"
