"""A PostgreSQL server of the test's own: Debian's programs, a folder of its own, a socket in it, a free port."""

import contextlib
import os
import pwd
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

CERTIFICATE = ("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=lab.invalid")
USER, PASSWORD = "lab", "hunter2-secret"


@dataclass(frozen=True)
class Server:
    """Where the server listens."""

    folder: Path
    port: int

    def url(self, database: str = "postgres", user: str = USER, password: str = PASSWORD) -> str:
        return f"postgresql://{user}:{password}@/{database}?host={self.folder}&port={self.port}"

    def by_network(self, *options: str, password: str = PASSWORD, port: int | None = None) -> str:
        """The same server by its port, or another one at `port`."""
        return f"postgresql://{USER}:{password}@127.0.0.1:{port or self.port}/postgres?{'&'.join(options)}"

    @property
    def certificate(self) -> Path:
        """Its own certificate's file, where it offers TLS; the certificate says another host name."""
        return self.folder / "server.crt"


def missing() -> str:
    """Why no server can be started here; empty where one can."""
    if os.name != "posix":
        return "the server's socket needs a posix system"
    if _program("initdb") is None or _program("postgres") is None:
        return "PostgreSQL's server is not installed (Debian: postgresql)"
    if os.geteuid() == 0 and _unprivileged() is None:
        return "PostgreSQL does not run as root, and there is no user postgres or nobody"
    return ""


@contextlib.contextmanager
def running(tls: bool = False) -> Iterator[Server]:
    """A fresh server, stopped and removed at the end; with `tls` it offers that, with a certificate of its own."""
    account = _unprivileged() if os.geteuid() == 0 else None
    folder = Path(tempfile.mkdtemp(prefix="bipedstudy-pg-"))
    (folder / "password").write_text(PASSWORD)
    if account is not None:
        for path in (folder, folder / "password"):
            shutil.chown(path, account)
    how = {"cwd": folder, "user": account, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    initdb = [_program("initdb"), "-D", folder / "base", "-U", USER, "-A", "scram-sha-256", "-E", "UTF8"]
    server = None
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    try:
        subprocess.run([*initdb, f"--pwfile={folder / 'password'}", "--no-sync"], check=True, timeout=600, **how)
        command = [_program("postgres"), "-D", folder / "base", "-k", folder, "-p", str(port), "-F"]
        command += ["-c", "listen_addresses=127.0.0.1"]
        if tls:
            subprocess.run([*CERTIFICATE, "-keyout", folder / "server.key", "-out", folder / "server.crt"], check=True,
                           **how)  # fmt: skip
            (folder / "server.key").chmod(0o600)
            command += ["-c", "ssl=on"]
            command += ["-c", f"ssl_cert_file={folder}/server.crt", "-c", f"ssl_key_file={folder}/server.key"]
        server = subprocess.Popen(command, **how)
        _wait_for(folder / "base/postmaster.pid", server)
        yield Server(folder, port)
    finally:
        if server is not None:
            server.terminate()
            server.wait(60)
        shutil.rmtree(folder, ignore_errors=True)


def _wait_for(state: Path, server: subprocess.Popen[bytes]) -> None:
    """Until the server says in its file that it takes calls: its socket is there before."""
    for _ in range(1800):
        if state.exists() and "ready" in state.read_text():
            return
        if server.poll() is not None:
            break
        time.sleep(0.1)
    raise RuntimeError("the PostgreSQL server did not start")


def _program(name: str) -> str | None:
    debian = sorted(Path("/usr/lib/postgresql").glob(f"*/bin/{name}"))
    return str(debian[-1]) if debian else shutil.which(name)


def _unprivileged() -> str | None:
    names = {entry.pw_name for entry in pwd.getpwall()}
    return next((name for name in ("postgres", "nobody") if name in names), None)
