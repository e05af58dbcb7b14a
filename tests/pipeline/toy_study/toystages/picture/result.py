from dataclasses import dataclass

from toystages.body.quantity import quantity


@dataclass(frozen=True)
class Result:
    names: tuple[str, ...] = quantity("-", "figures drawn")
    files: dict[str, bytes] = quantity("-", "files")

    def summary(self):
        return f"{len(self.names)} figures"
