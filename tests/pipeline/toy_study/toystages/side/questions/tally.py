"""`tally`: numbers of several seeds; a part at a time, so that it can be stopped between them."""

import os
import random
import time
from dataclasses import dataclass
from pathlib import Path

from toystages.body.quantity import Bound
from toystages.body.question import Answer, Column, Question, WrongOption, interval, option


class NoNumber(ValueError):
    pass


@dataclass(frozen=True)
class Options:
    count: int = option("1", "Numbers to draw", default=4, bound=Bound(minimum=1, maximum=100))
    pause: float = option("s", "Time that each takes, and every other twice", default=0.0, bound=Bound(minimum=0))
    wanted: tuple[float, float] = option("-", "Numbers to count", default=(0.0, 1000.0), read=interval)
    order: str = option("-", "How they are listed", default="drawn", choices=("drawn", "sorted"))
    skip: tuple[str, ...] = option("-", "Number to leave out", default=())
    marks: Path | None = option("-", "Folder for a file of each number that is computed", default=None)
    out: Path | None = option("-", "New HDF5 file for the numbers", default=None)


def number_of(parameters, pause, marks, seed):
    time.sleep(pause * (1 + seed % 2))
    if marks:
        Path(marks, f"{seed}-{os.getpid()}-{time.monotonic_ns()}").touch()
    if seed == 99:
        raise NoNumber("nothing grows from seed 99")
    if seed == 98:
        os._exit(7)
    return random.Random(seed).randrange(1000)


def ask(parameters, options, asking):
    seed = parameters.settings.seed
    if options.count == 13:
        raise WrongOption("--count = 13 brings bad luck")
    if seed == 0:
        raise NoNumber("nothing grows from seed 0")
    marks = str(options.marks) if options.marks else ""
    seeds, numbers = [seed + at for at in range(options.count)], []
    columns = [Column("number", "1", "what was drawn")]
    with asking.new_table(options.out, columns, options.count, {"first_seed": str(seed)}) as table:
        for at, number in enumerate(asking.each(number_of, seeds, options.pause, marks)):
            table.write(at, {"number": [number]})
            numbers.append(number)
    asking.note("all drawn")
    numbers = [number for number in numbers if str(number) not in options.skip]
    if options.order == "sorted":
        numbers.sort()
    low, high = options.wanted
    inside = sum(low <= number <= high for number in numbers)

    def draw(save):
        from matplotlib.figure import Figure

        figure = Figure()
        figure.subplots().plot(numbers)
        save(figure)

    return Answer(
        [f"{inside} of {len(numbers)} numbers lie within"],
        {"numbers": numbers, "inside": inside},
        tables=[("Numbers", ("place", "number"), list(enumerate(numbers)))],
        draw=draw,
        files={"numbers.csv": "\n".join(map(str, numbers)).encode()},
        parameters={"side.seed": seed + numbers.index(max(numbers))},
        remark="none lies within" if not inside else "",
        no=not inside,
    )


QUESTION = Question(
    "tally",
    """Draw numbers from the seed and those after it.

    Ends with 3 if none is wanted.
    """,
    Options,
    ask,
    draws=True,
    pool=True,
    leaves="a table of the numbers, and parameter files with the best seed",
)
