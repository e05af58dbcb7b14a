from dataclasses import dataclass

from toystages.body.quantity import quantity


@dataclass(frozen=True)
class Result:
    force: float = quantity("N", "peak force", symbol="F")

    def summary(self):
        return f"peak force {self.force:.3g} N"
