"""What a question is handed, without a study around it: parts are computed here, and what is said is remembered."""

import json
import math

from pipeline.questions.asking import Asked


class Asking:
    """Parts of an answer are computed with `parameters` and go through JSON as the engine's do; `parts` are those that
    are known. After so many as it `lives` it is stopped. `results` are those of stages, by name.
    """

    jobs = 2
    new_file, new_table = Asked.new_file, Asked.new_table

    def __init__(self, parameters=None, parts=None, lives=math.inf, **results):
        self.parameters, self.results, self.lives = parameters, results, lives
        self.parts, self.computed = {} if parts is None else parts, 0
        self.said, self.fractions, self.kept = [], [], b""

    def note(self, text):
        assert text
        self.said.append(text)

    def progress(self, fraction, what):
        assert 0.0 <= fraction <= 1.0 and what
        self.fractions.append(fraction)

    def keep(self, content):
        self.kept = content

    def result(self, stage="model_error"):
        return self.results.get(stage), f"results/{stage}.h5 is not there"

    def each(self, function, arguments, *shared):
        for argument in arguments:
            said = json.dumps([shared, argument])
            if (key := (function.__name__, said)) not in self.parts:
                if self.computed == self.lives:
                    raise KeyboardInterrupt
                self.computed += 1
                given, part = json.loads(said)
                self.parts[key] = json.loads(json.dumps(function(self.parameters, *given, part)))
            yield self.parts[key]

    def heads(self, columns, about):
        return {"table": about}
