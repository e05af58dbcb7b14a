"""What the calibration hands on."""

from __future__ import annotations

from dataclasses import dataclass

from stages.biped.quantity import quantity


@dataclass(frozen=True)
class Told:
    """How well runs tell one parameter of the design, the robot being weighed."""

    name: str = quantity("-", "parameter, by its file and key")
    unit: str = quantity("-", "its unit")
    value: float = quantity("SI", "value of the design")
    sd_one_run: float = quantity("SI", "smallest standard deviation of an unbiased estimate from one run")
    sd: float = quantity("SI", "the same from all runs of the campaign")
    goes_with: str = quantity("-", "unknown that its error is tied to most")
    correlation: float = quantity("1", "correlation with that")


@dataclass(frozen=True)
class Result:
    """What the campaign's sensors can tell of the design before anything is fitted."""

    runs: int = quantity("1", "runs of the campaign")
    told: tuple[Told, ...] = quantity("-", "a row for each parameter")
    not_seen: tuple[str, ...] = quantity("-", "combinations that no sensor sees, in words")

    def summary(self) -> str:
        """What was found, in one line."""
        shares = [100 * row.sd / row.value for row in self.told if row.value]
        unseen = f"; {len(self.not_seen)} combination is not seen" if self.not_seen else ""
        return f"{self.runs} runs tell parameters to {min(shares):.2g} to {max(shares):.2g} %, once weighed{unseen}"

    def tables(self) -> list[tuple[str, tuple[str, ...], list[tuple[str, ...]]]]:
        """Standard deviations, as (title, columns, rows of text)."""
        rows: list[tuple[str, ...]] = [
            (row.name, f"{row.value:.6g} {row.unit}", f"{row.sd_one_run:.2g}", f"{row.sd:.2g}", row.goes_with,
             f"{row.correlation:+.3f}")
            for row in self.told
        ]
        columns = ("parameter", "value", "sd, one run", f"sd, {self.runs} runs", "goes with", "correlation")
        return [("What the campaign's sensors can tell", columns, rows)]
