"""`bipedstudy claims`: what the study's sources claim, what is measured, the verdict and its cause.

Beside them stands what results/proof.json says, a proof of the study's design. A file can say anything: that a proof
was made or checked here is known by its digest, which is kept where the user's agreements are, not among the results.
"""

import functools
import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import click

from pipeline import completion, layout, trust
from pipeline.cache import disk
from pipeline.commands import options, status
from pipeline.errors import StudyError
from pipeline.graph import CAPTIONS, CLAIMS, PROOF
from pipeline.parameters import yaml_text
from pipeline.parameters.value import DEFAULT_LEVEL
from pipeline.study import Study, shown

#: What a verdict may be; "holds if" is completed by a condition. Then what one does, and several; how they look.
VERDICTS = {
    "holds": (("holds", "hold"), "yes"),
    "holds if": (("holds on a condition", "hold on a condition"), "if"),
    "does not hold": (("does not hold", "do not hold"), "no"),
    "not decided at this accuracy": (("is not decided at this accuracy", "are not decided at this accuracy"), "open"),
    "open": (("is open", "are open"), "open"),
    "does not apply": (("does not apply", "do not apply"), "none"),
}
#: Columns of the printed sentences: no more, however wide the terminal, so that they can be read.
_WIDEST = 100
_INDENT = 12
UNCHECKED = "a proof file says so, not checked here"
#: What a page says of any proof.
MEANS = f"results/{PROOF}: exists, is alone in a ball, stable or not, as a theorem."


@dataclass(frozen=True)
class Claim:
    """A claim: what is said (`plain` without terms) and implied, what is measured, the verdict, its causes."""

    id: str
    section: str
    words: str
    implies: str
    measured: str
    verdict: str
    condition: str
    causes: list[str]
    rests_on: list[str]
    numbers: list[str] = field(default_factory=list)
    beside: str = ""
    figures: list[str] = field(default_factory=list)
    plain: str = ""

    @property
    def full_verdict(self) -> str:
        """The verdict with its condition and what stands beside it."""
        return " ".join(filter(None, (self.verdict, self.condition, self.beside and f"({self.beside})")))

    @property
    def style(self) -> str:
        """The verdict's class on a page."""
        return VERDICTS[self.verdict][1]

    def parts(self) -> Iterator[tuple[str, str]]:
        """The parts with their names, in the order in which they are read; what is empty is left out."""
        yield from [("in short", self.plain)] if self.plain else ()
        yield "says", f'"{self.words}" ({self.section})'
        yield "implies", self.implies
        yield "measured", self.measured
        yield "verdict", self.full_verdict
        yield from (("because", cause) for cause in self.causes)
        for name, items in (("rests on", self.rests_on), ("shown in", self.figures)):
            if items:
                yield name, ", ".join(items)


@dataclass(frozen=True)
class Claims:
    """results/claims.yaml: the accuracy of the study, sentences that sum it up, claims, and tables beside them (title,
    columns, rows).
    """

    claims: list[Claim] = field(default_factory=list)
    headlines: list[str] = field(default_factory=list)
    tables: list[dict[str, Any]] = field(default_factory=list)
    level: str = DEFAULT_LEVEL

    def key(self) -> list[tuple[str, str]]:
        """The verdicts that occur, counted, in words, and how each looks."""
        counts = Counter(claim.verdict for claim in self.claims)
        return [(f"{counts[one]} {words[counts[one] > 1]}", style)
                for one, (words, style) in VERDICTS.items() if counts[one]]  # fmt: skip

    def counted(self) -> str:
        """The verdicts that occur, counted, in words."""
        many = [words for words, _ in self.key()]
        at = "" if self.level == DEFAULT_LEVEL else f" at accuracy {self.level}"
        return f"{len(self.claims)} claims{at}: {', '.join(many)}."


@click.command("claims", epilog=options.examples("claims"))
@click.argument("names", nargs=-1, metavar="[CLAIM]...", shell_complete=completion.claims)
@options.own_study
@functools.partial(options.answers, others=("markdown", "into"))
@click.option("--markdown", is_flag=True, help="Print what --into writes.")
@click.option(
    "--into", type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="Write claims and headlines into FILE, each between its marks, <!-- claims --> and <!-- headlines -->.",
)  # fmt: skip
def claims(study: Study, names: tuple[str, ...], form: options.Form, markdown: bool, into: Path | None) -> None:
    """Print each CLAIM (default: all): what is said, what is measured, the verdict, and why."""
    found = read(study)
    status.say(study, study.graph.maker(CLAIMS))
    known = [claim.id for claim in found.claims]
    if unknown := sorted({*names} - {*known}):
        raise StudyError(f'there is no claim "{unknown[0]}" (claims: {", ".join(known)})')
    if names:
        found = Claims([claim for claim in found.claims if claim.id in names], level=found.level)
    if into is not None:
        place(into, {"claims": as_markdown(found), "headlines": "\n".join(f"- {said}" for said in found.headlines)})
    elif markdown:
        click.echo(as_markdown(found))
    else:
        lines = [as_text(claim, min(layout.width(), _WIDEST)) + "\n" for claim in found.claims]
        rows = ({name: "; ".join(value) if isinstance(value, list) else value for name, value in asdict(claim).items()}
                for claim in found.claims)  # fmt: skip
        form.give([*lines, *(layout.folded(found.counted(), 0) if len(lines) > 1 else ())], asdict(found), rows,
                  ((table["title"], table["columns"], table["rows"]) for table in found.tables))  # fmt: skip


def as_text(claim: Claim, width: int) -> str:
    """A claim in lines of at most `width` columns."""
    return "\n".join([
        f"{claim.id}: {claim.verdict}{claim.beside and f' ({claim.beside})'}",
        *(layout.beside(f"  {name}".ljust(_INDENT), text, width) for name, text in claim.parts() if text),
    ])  # fmt: skip


def as_markdown(found: Claims) -> str:
    """All claims: a table of verdicts, every claim with what is judged, and the tables."""
    verdicts = [(f"[{claim.id}](#{claim.id})", claim.section, claim.full_verdict) for claim in found.claims]
    lines = [found.counted(), "", *layout.markdown(("claim", "section", "verdict"), verdicts), ""]
    for claim in found.claims:
        parts = [f"- *{name}*: {text}" for name, text in claim.parts() if name not in ("rests on", "shown in")]
        lines += [f"### {claim.id}", "", *parts, ""]
    for table in found.tables:
        lines += [f"## {table['title']}", "", *layout.markdown(table["columns"], table["rows"]), ""]
    return "\n".join(lines).rstrip()


def place(path: Path, texts: dict[str, str]) -> None:
    """Put each text between its marks in a file that has them. Raises `StudyError` if a mark is missing."""
    disk.check(path, shown(path), disk.TEXT)
    content, found = path.read_text(encoding="utf-8"), False
    for name, text in texts.items():
        first, last = f"<!-- {name} -->", f"<!-- /{name} -->"
        before, start, rest = content.partition(first)
        _, end, after = rest.partition(last)
        if bool(start) != bool(end):
            raise StudyError(f"{shown(path)}: the text goes between the lines {first} and {last}; one is missing")
        if start:
            content, found = f"{before}{start}\n{text}\n{end}{after}", True
    if not found:
        marks = " or ".join(f"<!-- {name} --> and <!-- /{name} -->" for name in texts)
        raise StudyError(f"{shown(path)}: there are no lines {marks} to write between")
    path.write_text(content, encoding="utf-8")


def read(study: Study) -> Claims:
    """results/claims.yaml, each claim with what a proof says of it, and the figures that show something of it, where
    figures have been drawn.

    Raises `StudyError` if it is missing, was damaged, or was made by an earlier version, `Declined` if its stage said
    no.
    """
    path = study.store.place(CLAIMS)
    if not path.exists():  # one that lies there is read, though no stage makes it any more
        path = study.there(CLAIMS, "run comparison")
    plain = yaml_text.read(path, shown(path)).plain()
    try:
        found = Claims([Claim(**claim) for claim in plain["claims"]], plain["headlines"], plain["tables"],
                       plain.get("level", DEFAULT_LEVEL))  # fmt: skip
    except (TypeError, KeyError):
        raise StudyError(f"{shown(path)}: not the claims of this version; make them anew with: bipedstudy run "
                         "comparison") from None  # fmt: skip
    for claim in found.claims:
        if claim.verdict not in VERDICTS:
            raise StudyError(f"{shown(path)}: claim {claim.id}: the verdict must be one of {', '.join(VERDICTS)}")
    said = proven(study)
    for place, claim in enumerate(found.claims):
        if words := said.get(claim.id):
            beside = f"{claim.beside}; {words}" if claim.beside else words
            found.claims[place] = replace(claim, beside=beside)
    captions = study.store.place(CAPTIONS)
    figures = yaml_text.read(captions, shown(captions)).plain() if captions.exists() else {}
    for figure in figures.get("figures", ()) if isinstance(figures, dict) else ():
        for claim in found.claims:
            if claim.id in figure.get("claims", ()):
                claim.figures.append(figure["name"])
    return found


def keep_proof(study: Study, content: bytes) -> None:
    """Put a proof beside the results, as one that was made or checked here."""
    disk.write(study.results / PROOF, content)
    trust.vouch(study.root, disk.digest(content))


def proven(study: Study) -> dict[str, str]:
    """Claim -> what a proof says of it, if it is of the very parameters that the claims' results were made with.

    A study without a stage of claims has none. The proof's keys are names of parameter files, with values, and `says`.
    """
    content = disk.read(study.results / PROOF, disk.MEMO)
    maker = [stage.name for stage in study.graph.stages.values() if CLAIMS in stage.outs]
    entry = study.store.current(*maker) if maker else None
    if content is None or entry is None:
        return {}
    try:
        plain, used = json.loads(content), entry.ingredients["parameters"]
        of = [used[file][key] == value for file in used if file in plain for key, value in plain[file].items()]
        says = {str(claim): str(words) for claim, words in plain["says"].items()} if of and all(of) else {}
    except (ValueError, KeyError, TypeError, AttributeError):
        return {}
    here = trust.vouched(study.root, disk.digest(content))
    return {claim: words if here else UNCHECKED for claim, words in says.items()}
