"""Small changes of C and C++ code, found from its tokens alone.

Each changes a place: a condition, the value of a declaration, or a statement. What is constant at compile time,
templates, labels and the preprocessor are left alone. A change that does not compile shows in the build.
"""

import dataclasses
import re

TOKEN = re.compile(r"""
    (?P<skip>//[^\n]*|/\*.*?\*/|^[ \t]*\#(?:[^\n\\]|\\.)*)
  | (?P<number>(?:0[xX][\da-fA-F']+|\d[\d']*(?:\.\d*)?(?:[eE][+-]?\d+)?)[uUlLfFzZ]*)
  | (?P<text>R"(?P<mark>[^(\s]*)\(.*?\)(?P=mark)"|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')
  | (?P<word>[A-Za-z_]\w*)
  | (?P<sign>::|->|\+\+|--|&&|\|\||<<=|>>=|[-+*/%&|^=!<>]=|<<|>>|\S)""", re.S | re.M | re.X)
SIGNS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "+": "-", "-": "+", "*": "/", "/": "*",
         "&&": "||", "||": "&&", "+=": "-=", "-=": "+=", "*=": "/="}
WORDS = {"true": "false", "false": "true", "min": "max", "max": "min"}
ASSIGNS = {"=", "+=", "-=", "*=", "/=", "|=", "&=", "^=", "<<=", ">>=", "<<", "++", "--"}
CONSTANT = {"constexpr", "constinit", "static_assert", "static", "using", "typedef", "template", "struct", "enum",
            "_Static_assert", "goto", "asm", "reserve"}


@dataclasses.dataclass(frozen=True)
class Mutant:
    file: str
    line: int
    form: str  # condition, value or statement
    begin: int  # start of the place [characters]
    end: int
    lines: range  # lines of the place
    before: str
    after: str

    @property
    def key(self) -> str:
        return f"{self.file} | {self.before} | {self.after}"

    def cuts(self, other: "Mutant") -> bool:
        """Whether the places of the two mutants overlap without being equal."""
        return self.file == other.file and (self.begin, self.end) != (other.begin, other.end) and (
            self.begin < other.end and other.begin < self.end)


class Source:
    def __init__(self, file: str, code: str):
        self.file, self.code = file, code
        found = [m for m in TOKEN.finditer(code) if m.lastgroup != "skip"]
        self.text = [m.group() for m in found] + [""]
        self.kind = [m.lastgroup for m in found] + [None]
        self.span = [m.span() for m in found]
        self.partner: dict[int, int] = {}  # index of each bracket's partner
        self.outer: list[int | None] = []  # index of the bracket that encloses each token
        self.body: dict[int, str] = {}  # for each { that begins statements: block or lambda
        opened: list[int] = []
        for i, text in enumerate(self.text):
            if text in (")", "]", "}") and opened:
                self.partner[i] = opened[-1]
                self.partner[opened.pop()] = i
            self.outer.append(opened[-1] if opened else None)
            if text == "{" and (body := self.body_of(i)):
                self.body[i] = body
            if text in ("(", "[", "{"):
                opened.append(i)

    def body_of(self, i: int) -> str | None:
        before = i - 1
        for back in range(i - 1, max(i - 12, 0), -1):  # (...) -> type {
            if self.text[back] in (";", "{", "}"):
                break
            if self.text[back] == "->" and self.text[back - 1] in (")", "const", "noexcept"):
                before = back - 1
        while self.text[before] in ("const", "noexcept", "override", "mutable"):
            before -= 1
        opens = self.partner.get(before, 0)
        if self.text[before] == "]" or self.text[before] == ")" and self.text[opens - 1] == "]":
            return "lambda"
        inside = self.outer[i] in self.body and self.text[before] in (";", "{", "}")
        return "block" if inside or self.text[before] in (")", "else", "do", "try") else None

    def over(self, i: int, step: int) -> int:
        """The next token, where brackets and what is in them count as one."""
        return self.partner.get(i, i) + step

    def condition(self, opens: int, inner: int) -> tuple[str, int, int] | None:
        """The condition of the if, while or for with this bracket, if the token belongs to it."""
        direct = [i for i in range(opens + 1, self.partner[opens]) if self.outer[i] == opens]
        ends = [opens, *(i for i in direct if self.text[i] == ";"), self.partner[opens]]
        part = 1 if self.text[opens - 1] == "for" else len(ends) - 2
        if part + 1 >= len(ends):
            return None
        first, last = ends[part] + 1, ends[part + 1] - 1
        declares = any(self.text[i] == "=" for i in direct if first <= i <= last)
        return ("condition", first, last) if first <= inner <= last and not declares else None

    def is_expression(self, i: int) -> bool:
        """Whether the statement is a call or an assignment, and so no declaration."""
        while self.text[i] in ("*", "++", "--"):
            i += 1
        if self.kind[i] != "word":
            return False
        i += 1
        while self.text[i] in ("::", ".", "->", "(", "["):
            i = self.over(i, 1) if self.text[i] in ("(", "[") else i + 2
        return self.text[i] in ASSIGNS or self.text[i] == ";" and self.text[i - 1] in (")", "++", "--")

    def place(self, inner: int) -> tuple[str, int, int] | None:
        """Form, first and last token of the place around a token."""
        around = self.outer[inner]
        while around is not None and around not in self.body:
            if self.text[around - 1] in ("if", "while", "for"):
                return self.condition(around, inner)
            if self.text[around - 1] in ("sizeof", "decltype", "alignof", "constexpr", "switch", "catch"):
                return None
            inner, around = around, self.outer[around]
        if around not in self.partner:
            return None
        first = last = inner
        while self.text[first - 1] not in (";", "{") and self.body.get(self.partner.get(first - 1, -1)) != "block":
            first = self.over(first - 1, 0)
        while self.text[last] not in (";", "}", ""):
            last = self.over(last, 1)
        while self.text[first] in ("else", "if", "while", "for", "case", "default", "do"):
            if self.text[first] in ("case", "default"):
                while self.text[first] != ":" and first < last:
                    first += 1
            first = self.partner[first + 1] + 1 if self.text[first + 1] == "(" else first + 1
        if self.text[last] != ";" or first > inner or CONSTANT & set(self.text[first:last]):
            return None
        if self.text[first] in ("return", "throw", "break", "continue") or self.is_expression(first):
            return "statement", first, last
        value = next((i + 1 for i in range(first, inner) if self.text[i] == "=" and self.outer[i] == around), None)
        return ("value", value, last - 1) if value and self.text[value] not in ("{", "[") else None

    def joined(self, first: int, last: int, change: dict[int, str]) -> str:
        """The tokens on one line, without comments."""
        gaps = [" " if self.span[i][1] != self.span[i + 1][0] else "" for i in range(first, last)] + [""]
        return "".join(change.get(i, self.text[i]) + gap for i, gap in zip(range(first, last + 1), gaps))

    def changed(self, i: int) -> str | None:
        """What token i becomes."""
        text, code, (begin, end) = self.text[i], self.code, self.span[i]
        if self.kind[i] == "number" and code[begin - 1] not in "<[" and code[end] != ">":  # no index, no template
            if re.search(r"[.eE]", text) and not text.startswith("0x"):
                return f"(2 * {text})" if float(re.sub(r"[fFlL']", "", text)) else "1.0"
            return f"({text} + 1)"
        if self.kind[i] == "word" and text in WORDS and (text not in ("min", "max") or self.text[i + 1] == "("):
            return WORDS[text]
        spaced = code[begin - 1].isspace() and code[end].isspace()
        if text == "!" and not spaced:
            return " "
        return SIGNS.get(text) if spaced else None

    def mutants(self):
        for i in range(1, len(self.span)):
            negates = self.text[i] == "(" and self.text[i - 1] == "if"
            place = self.place(i + negates) if self.text[i] not in (")", "]", "}") else None
            if not place:
                continue
            form, first, last = place
            begin, end = self.span[first][0], self.span[last][1]
            before = self.joined(first, last, {})
            variants = [f"!({before})"] if negates else []
            if (change := self.changed(i)) and not (self.text[i] == "+" and '"' in before):  # no concatenation of texts
                variants.append(self.joined(first, last, {i: change}))
            if form == "statement" and first == i and (self.text[i] not in ("return", "throw") or last == i + 1):
                variants.append(";")
            line, *lines = (self.code.count("\n", 0, at) + 1 for at in (self.span[i][0], begin, end))
            for after in variants if not re.search(r"^\s*#", self.code[begin:end], re.M) else []:
                yield Mutant(self.file, line, form, begin, end, range(lines[0], lines[1] + 1), before, after)
