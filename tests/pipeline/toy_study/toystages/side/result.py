from dataclasses import dataclass

from toystages.body.quantity import quantity


@dataclass(frozen=True)
class Result:
    number: int = quantity("1", "a number")
    files: dict[str, bytes] = quantity("-", "files")

    def summary(self):
        return f"number {self.number}"
