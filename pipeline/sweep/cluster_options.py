"""Options to compute on a dask cluster, and the client that they ask for."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import click

from pipeline.commands.options import Command
from pipeline.errors import StudyError


@dataclass(frozen=True)
class Cluster:
    """The scheduler's address, None for this machine, and the certificates by dask's names."""

    address: str | None = None
    certificates: Mapping[str, str] = field(default_factory=dict)

    @contextlib.contextmanager
    def client(self, note: Callable[[str], None]) -> Iterator[tuple[Any, int]]:
        """A client and how much it computes at a time; None and 0 on this machine. Raises `StudyError`."""
        if self.address is None:
            yield None, 0
            return
        from pipeline.sweep import cluster

        if cluster.is_open(self.address):
            note(f"the way to {self.address} is not encrypted, and whoever reaches that port, on your own computer "
                 "each of its users, can run programs there; docs/sweeps.md has the way with certificates")  # fmt: skip
        client = cluster.connected(self.address, self.certificates)
        if machines := cluster.unconfined(client):
            note(f"what is computed on {', '.join(machines)} is not confined there, as Landlock is missing: it can "
                 "read and write whatever the worker's user can")  # fmt: skip
        try:
            yield client, cluster.threads(client)
        finally:
            client.close()


HERE = Cluster()


def offered(function: Command) -> Command:
    """`--jobs` for this machine, `--cluster` and its certificates; the command gets `jobs` and a `Cluster`."""

    @click.option("--jobs", "-j", metavar="N", type=click.IntRange(min=1),
                  help="How much is computed side by side (default: cores).")  # fmt: skip
    @click.option("--cluster", "address", metavar="ADDRESS",
                  help="Compute on the dask cluster of the scheduler at ADDRESS.")  # fmt: skip
    @click.option("--tls-ca-file", metavar="FILE", help="Authority of its certificates, for ADDRESS = tls://...")
    @click.option("--tls-cert", metavar="FILE", help="Certificate that shows who you are.")
    @click.option("--tls-key", metavar="FILE", help="Its key, if it is not in the certificate's file.")
    @functools.wraps(function)
    def with_cluster(
        *given: Any, jobs: int | None, address: str | None, tls_ca_file: str | None, tls_cert: str | None,
        tls_key: str | None, **options: Any,
    ) -> Any:  # fmt: skip
        if jobs and address:
            raise StudyError("--jobs is for this machine; a cluster has as many workers as it has")
        files = {"tls_ca_file": tls_ca_file, "tls_client_cert": tls_cert, "tls_client_key": tls_key}
        certificates = {name: file for name, file in files.items() if file}
        if certificates and not address:
            raise StudyError("--tls-ca-file, --tls-cert and --tls-key are for --cluster tls://...")
        for file in certificates.values():
            if not Path(file).is_file():
                raise StudyError(f"--cluster {address}: there is no file {file}")
        return function(*given, jobs=jobs, cluster=Cluster(address, certificates), **options)

    return with_cluster
