"""What all databases in the schema of `stages.imu.sources.schema` have in common, whatever engine holds the tables."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from types import TracebackType
from typing import Any, TypeVar

import numpy as np

from stages.imu.errors import SourceRefused, printable
from stages.imu.sources.columns import device_from_row, experiment_from_row, number, numbers, recording_from_columns
from stages.imu.sources.schema import SAMPLE_VALUES, TABLES, Device, Experiment, Recording

Extent = tuple[Any, Any, Any]
S = TypeVar("S", bound="TableSource")


class TableSource(ABC):
    """A database with the three tables; use as a context manager.

    An engine says how to ask (`query`), what there is (`present`) and where each run lies (`extents`). Raises
    SourceRefused, in one sentence that names the source by `name`, for what is missing or has no meaning.
    """

    #: Column whose order is that of arrival.
    order = "sample_id"

    def __init__(self, name: str) -> None:
        self.name = name

    def __enter__(self: S) -> S:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @abstractmethod
    def query(self, sql: str, **values: Any) -> Iterator[tuple[Any, ...]]:
        """Rows of a SELECT with parameters written :name."""

    @abstractmethod
    def present(self) -> dict[str, set[str]]:
        """Tables that can be read, each with its columns."""

    @abstractmethod
    def extents(self) -> list[Extent]:
        """Experiment, first and last `order` of each run, in the order of arrival and in constant memory."""

    @abstractmethod
    def close(self) -> None:
        """Let go of the source."""

    def open_tables(self) -> None:
        """Check the tables and read the devices: the last step of a constructor. Closes the source if it fails."""
        try:
            self._check_tables()
            self.devices = self._devices()
        except BaseException:
            self.close()
            raise

    def runs(self) -> Iterator[tuple[Experiment, tuple[Recording, ...]]]:
        """Each experiment with its recordings; one experiment is in memory at a time."""
        experiments = {row["experiment_id"]: experiment_from_row(row) for row in self._rows("experiment")}
        extents = self.extents()
        if not extents:
            raise SourceRefused(f"{self.name}: table sample is empty")
        for experiment_id, first, last in extents:
            experiment = experiments.get(experiment_id) or Experiment(name=f"run {experiment_id}", origin="unknown")
            values = {"first": first, "last": last}
            if experiment_id is not None:
                values["run"] = experiment_id
            rows = self.query(
                f"SELECT device_id, {', '.join(SAMPLE_VALUES)} FROM sample WHERE {self.order} BETWEEN :first AND :last "
                f"AND experiment_id {'IS NULL' if experiment_id is None else '= :run'} ORDER BY {self.order}",
                **values,
            )
            table = numbers(list(rows), len(SAMPLE_VALUES) + 1)
            yield experiment, tuple(self._recordings(experiment, table))

    def _recordings(self, experiment: Experiment, table: np.ndarray) -> Iterator[Recording]:
        for device_id in np.unique(table[:, 0]):
            device = self.devices.get(device_id)
            if device is None:
                raise SourceRefused(f"{self.name}: table sample names device {device_id:g}, which table device lacks")
            yield recording_from_columns(experiment, device, table[table[:, 0] == device_id, 1:])

    def _devices(self) -> dict[float, Device]:
        devices = {}
        for row in self._rows("device"):
            identity = number(row["device_id"])
            if identity != identity:
                raise SourceRefused(f"{self.name}: table device has a row without a device_id")
            devices[identity] = device_from_row(row, f"{self.name}, device {identity:g}")
        return devices

    def _check_tables(self) -> None:
        present = self.present()
        for table, columns in TABLES.items():
            if table not in present:
                found = ", ".join(printable(name) for name in list(present)[:5]) or "no tables"
                raise SourceRefused(f"{self.name}: needs a table named {table}; found {found}")
            missing = [name for name, _, _ in columns if name not in present[table]]
            if missing:
                raise SourceRefused(f"{self.name}: table {table} lacks {', '.join(missing)}")

    def _rows(self, table: str) -> list[dict[str, Any]]:
        names = [name for name, _, _ in TABLES[table]]
        return [dict(zip(names, row)) for row in self.query(f"SELECT {', '.join(names)} FROM {table}")]
