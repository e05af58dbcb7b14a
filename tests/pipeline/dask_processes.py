"""A dask cluster of this machine in processes that can be killed one by one, and certificates made for it."""

import contextlib
import os
import shutil
import socket
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from tests.pipeline.toy import HOME

_STARTS_S = 60.0
_LOOKS_S = 3.0
_NEW_KEY = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes")


@dataclass(frozen=True)
class Certificates:
    """An authority's certificate, and one that it signed with its key."""

    authority: Path
    certificate: Path
    key: Path

    def options(self) -> list[str]:
        """As dask's programs and `bipedstudy sweep` take them."""
        return ["--tls-ca-file", str(self.authority), "--tls-cert", str(self.certificate), "--tls-key", str(self.key)]


def certificates(folder: Path) -> Certificates:
    """An authority of its own in `folder`, with a certificate. Skips the test where there is no openssl."""
    openssl = shutil.which("openssl") or pytest.skip("needs the program openssl to make certificates")
    folder.mkdir()

    def run(*words: str) -> None:
        subprocess.run([openssl, *words], cwd=folder, check=True, capture_output=True)

    run("req", "-x509", *_NEW_KEY, "-keyout", "authority.key", "-out", "authority.pem", "-days", "2",
        "-subj", f"/CN=authority {folder.name}")  # fmt: skip
    run("req", *_NEW_KEY, "-keyout", "key.pem", "-out", "request.pem", "-subj", "/CN=member")
    run("x509", "-req", "-in", "request.pem", "-CA", "authority.pem", "-CAkey", "authority.key", "-CAcreateserial",
        "-out", "certificate.pem", "-days", "2")  # fmt: skip
    return Certificates(folder / "authority.pem", folder / "certificate.pem", folder / "key.pem")


@dataclass
class Cluster:
    """A scheduler and workers with one thread each; `first_on_path` goes before this checkout on the workers' path."""

    folder: Path
    secured: Certificates | None = None
    first_on_path: tuple[Path, ...] = ()
    scheduler: subprocess.Popen[bytes] | None = None
    workers: list[subprocess.Popen[bytes]] = field(default_factory=list)
    port: int = 0

    @property
    def address(self) -> str:
        return f"{'tls' if self.secured else 'tcp'}://127.0.0.1:{self.port}"

    def start_scheduler(self) -> None:
        """Start a scheduler, at the port of the one before, and wait until it listens."""
        self.port = self.port or free_port()
        self.scheduler = self._start("dask_scheduler", "--host", self.address.rpartition(":")[0],
                                     "--port", str(self.port), "--no-dashboard", "--no-show")  # fmt: skip
        end = time.monotonic() + _STARTS_S
        while time.monotonic() < end:
            assert self.scheduler.poll() is None, "the scheduler did not start"
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", self.port), 1):
                return
            time.sleep(0.1)
        raise AssertionError("no scheduler listens")

    def start_workers(self, count: int) -> None:
        """Have `count` workers that are alive."""
        self.workers = [worker for worker in self.workers if worker.poll() is None]
        while len(self.workers) < count:
            self.workers.append(self._start("dask_worker", self.address, "--nthreads", "1", "--no-nanny",
                                            "--no-dashboard", "--local-directory", str(self.folder)))  # fmt: skip

    def wait_for_workers(self, count: int) -> None:
        """Wait until the scheduler knows `count` workers; those that end meanwhile are replaced."""
        from distributed import Client
        from distributed.security import Security

        files = self.secured and {"tls_ca_file": str(self.secured.authority), "tls_client_key": str(self.secured.key),
                                  "tls_client_cert": str(self.secured.certificate)}  # fmt: skip
        with Client(self.address, security=Security(**(files or {})), timeout=_STARTS_S) as client:
            end = time.monotonic() + _STARTS_S
            while True:
                self.start_workers(count)
                try:
                    return client.wait_for_workers(count, timeout=_LOOKS_S)
                except TimeoutError:
                    assert time.monotonic() < end, "no workers come"

    def close(self) -> None:
        """End all of it."""
        for process in (*self.workers, self.scheduler):
            if process is not None:
                process.kill()
                process.wait()

    def _start(self, program: str, *words: str) -> subprocess.Popen[bytes]:
        path = os.pathsep.join(map(str, (*self.first_on_path, HOME)))
        secured = self.secured.options() if self.secured else []
        with open(self.folder / f"{program}.log", "ab") as log:
            return subprocess.Popen([sys.executable, "-m", f"distributed.cli.{program}", *words, *secured], stdout=log,
                                    stderr=log, cwd=self.folder, env={**os.environ, "PYTHONPATH": path})  # fmt: skip


def free_port() -> int:
    """A port of this machine that nobody uses."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
