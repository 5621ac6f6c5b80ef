//! What the words of a doc comment say about a unit.

/// A doc comment, cut into words; each mark is a word of its own, and code is the word `.
pub struct Doc {
    words: Vec<String>,
    /// Items that it leads to: by a link, or by "as `name`".
    pub references: Vec<String>,
}

/// Symbols of units, of which products, quotients and powers are made.
const SYMBOLS: [&str; 33] = [
    "m", "mm", "cm", "km", "um", "g", "kg", "s", "ms", "us", "min", "h", "N", "mN", "kN", "W", "mW", "V",
    "A", "J", "mJ", "Pa", "kPa", "Hz", "kHz", "rad", "deg", "K", "ohm", "px", "dB", "pt", "%",
];
/// Units in words.
const WORDS: [&str; 26] = [
    "metres",
    "millimetres",
    "seconds",
    "milliseconds",
    "microseconds",
    "minutes",
    "hours",
    "degrees",
    "radians",
    "newtons",
    "watts",
    "volts",
    "hertz",
    "kilograms",
    "joules",
    "pixels",
    "bytes",
    "percent",
    "cycles",
    "chords",
    "semi-chords",
    "semichords",
    "deviations",
    "turns",
    "counts",
    "frames",
];
/// Words that may stand before these.
const WHICH: [&str; 9] = ["half", "mean", "root", "tip", "standard", "whole", "full", "own", "reference"];
/// Words of quantities without a unit.
const BARE: [&str; 16] = [
    "dimensionless",
    "ratio",
    "ratios",
    "fraction",
    "fractions",
    "share",
    "shares",
    "coefficient",
    "coefficients",
    "correlation",
    "correlations",
    "probability",
    "efficiency",
    "logarithm",
    "unitless",
    "quaternion",
];
/// What a quantity is divided by.
const DIVISORS: [&str; 33] = [
    "chord",
    "chords",
    "span",
    "half",
    "semispan",
    "weight",
    "weights",
    "largest",
    "length",
    "noise",
    "variances",
    "reference",
    "mean",
    "distance",
    "mass",
    "limit",
    "finest",
    "speed",
    "amplitude",
    "density",
    "range",
    "ranges",
    "rms",
    "one",
    "true",
    "measured",
    "size",
    "deviation",
    "radius",
    "least",
    "dynamic",
    "finer",
    "displacement",
];

/// Whether `word` is written as a unit: `N`, `m/s2`, `1/rad`.
fn is_symbol(word: &str) -> bool {
    let known = |part: &str| SYMBOLS.contains(&part.trim_end_matches(|c: char| c.is_ascii_digit()));
    let mut parts = word.split('/');
    let first = parts.next().unwrap_or_default();
    let rest: Vec<&str> = parts.collect();
    rest.iter().all(|part| known(part)) && (known(first) || (first == "1" && !rest.is_empty()))
}

impl Doc {
    /// Cuts `text` into words.
    pub fn read(text: &str) -> Self {
        let mut doc = Self { words: Vec::new(), references: Vec::new() };
        for (i, part) in text.split('`').enumerate() {
            match i % 2 {
                0 => doc.prose(part),
                _ => doc.code(part),
            }
        }
        doc
    }

    fn code(&mut self, code: &str) {
        let before = self.words.last().map(|word| word.to_lowercase()).unwrap_or_default();
        if matches!(before.as_str(), "[" | "as" | "like") {
            let end = code.trim_end_matches("()").rsplit("::").next().unwrap_or(code);
            self.references.extend([end.to_owned(), format!("{end}()")]);
        }
        let is_unit = before == "in" && matches!(code, "unit" | "units" | "self.unit");
        self.words.push(if is_unit { "its unit" } else { "`" }.to_owned());
    }

    fn prose(&mut self, text: &str) {
        // Targets of links are no words.
        let text = match text.strip_prefix("](") {
            Some(target) => target.split_once(')').map_or("", |(_, rest)| rest),
            None => text,
        };
        for word in text.split_whitespace() {
            let mut rest = word;
            while let Some(mark) = rest.chars().next().filter(|c| "([,.;:)]*".contains(*c)) {
                self.words.push(mark.to_string());
                rest = &rest[mark.len_utf8()..];
            }
            let end = rest.trim_end_matches(['(', '[', ',', '.', ';', ':', ')', ']', '*', '?']);
            if !end.is_empty() {
                self.words.push(end.to_owned());
            }
            self.words.extend(rest[end.len()..].chars().map(String::from));
        }
    }

    fn word(&self, i: usize) -> &str {
        self.words.get(i).map_or(".", String::as_str)
    }

    /// The word before `i`; a full stop at the start.
    fn before(&self, i: usize) -> &str {
        if i == 0 { "." } else { self.word(i - 1) }
    }

    /// A symbol stands where units do: behind a mark, "in", code or another symbol, and not behind a number, which is then a
    /// quantity of its own. W and A are frames and articles elsewhere.
    fn symbol_at(&self, i: usize) -> bool {
        let word = self.word(i);
        let before = self.before(i);
        let is_letter = matches!(word, "W" | "A");
        let is_mark = |mark: &str| matches!(mark, "," | "(" | ")" | ";" | ":" | "`");
        is_symbol(word)
            && match before {
                "." => i == 0 && (is_symbol(self.word(1)) || matches!(self.word(1), "." | "," | ";" | ":")),
                "in" | "as" | "and" | "or" | "their" => !is_letter,
                "per" => i > 1 && is_mark(self.before(i - 1)),
                mark if is_mark(mark) => true,
                _ => is_symbol(before) && self.symbol_at(i - 1),
            }
    }

    fn word_at(&self, i: usize) -> bool {
        let word = self.word(i).to_lowercase();
        let adjective = WHICH.contains(&self.before(i).to_lowercase().as_str());
        let before = if adjective && i > 1 {
            self.before(i - 1)
        } else if adjective {
            "."
        } else {
            self.before(i)
        };
        let next = self.word(i + 1);
        // At the start of a sentence some are verbs or what a list holds: "Turns the loads", "Samples of a cycle".
        let is_first = match word.as_str() {
            "cycles" => !matches!(next, "of" | "as"),
            "chords" | "semichords" => self.word(i + 2) == "travel",
            "degrees" => false,
            "turns" | "counts" | "frames" => matches!(next, "per" | "a") || self.word(i + 4) == "per",
            _ => true,
        };
        WORDS.contains(&word.as_str())
            && (matches!(before, "," | "(" | ":" | "in" | ";" | "`") || (before == "." && is_first))
    }

    /// A ratio, or the words of one.
    fn bare_at(&self, i: usize) -> bool {
        let word = self.word(i).to_lowercase();
        let next = self.word(i + 1);
        let after = self.word(i + 2);
        let before = self.before(i);
        (BARE.contains(&word.as_str()) && !(word == "share" && (before == "that" || before.ends_with("'s"))))
            || match word.as_str() {
                "relative" => next != "to",
                "factor" | "factors" => matches!(next, "on" | "by" | "`"),
                "over" => match next {
                    "the" | "its" | "their" | "a" => DIVISORS.contains(&after),
                    "that" | "rms" | "speed" | "chord" | "length" | "half" | "dynamic" => true,
                    _ => false,
                },
                "in" => next == "parts" && after == "of",
                "unit" => matches!(next, "vector" | "vectors" | "normal" | "axis" | "direction"),
                "weights" => true,
                "reduced" => next == "frequency",
                "number" => {
                    matches!(before, "." | "a" | "Mean" | "mean")
                        && next == "of"
                        && !matches!(after, "the" | "its" | "a")
                }
                "samples" | "records" => before == "." && next == "per",
                "no" | "without" => next == "unit" && before != "names",
                "per" => before == "," && next == "half",
                _ => false,
            }
    }

    /// The unit of something else that is named: "in the unit of", "in their declared units".
    fn unit_at(&self, i: usize) -> bool {
        let whose =
            |word: &str| matches!(word, "its" | "own" | "their" | "whose" | "that" | "SI" | "caller's");
        // "Per unit of the command" says nothing of what is gained.
        let of = matches!(self.word(i + 1), "of" | "and") && !matches!(self.before(i), "per" | "a" | "one");
        let owned =
            whose(self.before(i)) || (i > 1 && whose(self.before(i - 1)) && self.before(i) == "declared");
        let word = self.word(i);
        word == "its unit"
            || (matches!(word, "unit" | "units") && (owned || of || self.word(i + 2) == "ends"))
    }

    fn names_at(&self, i: usize) -> bool {
        self.symbol_at(i) || self.word_at(i) || self.bare_at(i) || self.unit_at(i)
    }

    /// Whether what is named at `i` is of an argument: "`angle` rad", "`place` (m, W)", "the share `x`".
    fn is_of_argument(&self, i: usize) -> bool {
        let code = |i: usize| self.word(i) == "`";
        let first = (0..i)
            .rev()
            .take(6)
            .take_while(|&j| !matches!(self.word(j), ")" | "." | ";"))
            .find(|&j| self.word(j) == "(");
        let in_brackets = first.is_some_and(|open| open > 0 && code(open - 1));
        in_brackets || (i > 0 && code(i - 1)) || (self.bare_at(i) && code(i + 1))
    }

    /// Whether it names a unit, or says that there is none.
    pub fn names_unit(&self) -> bool {
        (0..self.words.len()).any(|i| self.names_at(i))
    }

    /// Whether it names one that is not an argument's.
    pub fn names_unit_of_result(&self) -> bool {
        (0..self.words.len()).any(|i| self.names_at(i) && !self.is_of_argument(i))
    }

    /// Whether the docs of a type or module speak for all that is in it: "in the caller's units", "values are in the units of
    /// their parameters".
    pub fn speaks_for_all(&self) -> bool {
        let callers = |i: usize| self.before(i) == "caller's";
        let are_in =
            |i: usize| i > 3 && self.words[i - 3..i] == ["are", "in", "the"] && self.word(i + 1) == "of";
        (0..self.words.len()).any(|i| matches!(self.word(i), "unit" | "units") && (callers(i) || are_in(i)))
    }

    /// Whether the docs of a type settle the units of its fields: "lengths in m", "SI units", "energies of a beam, J.".
    pub fn settles_fields(&self) -> bool {
        let plural = |i: usize| self.word(i).ends_with('s') || self.word(i).eq_ignore_ascii_case("all");
        let unit = |i: usize| self.symbol_at(i) || self.word_at(i);
        (1..self.words.len()).any(|i| match self.word(i) {
            "in" => plural(i - 1) && (unit(i + 1) || (i + 2..i + 5).any(|j| self.unit_at(j))),
            "units" => self.before(i) == "SI",
            "dimensionless" => matches!(self.before(i), "are" | "all"),
            _ => {
                matches!(self.before(i), "," | "(")
                    && unit(i)
                    && matches!(self.word(i + 1), "." | ";" | ":" | ")")
            }
        })
    }

    /// Whether it goes on from the item before: "The same of the pitch".
    pub fn continues(&self) -> bool {
        (self.word(0) == "The" && self.word(1) == "same") || self.words.iter().any(|word| word == "likewise")
    }

    /// Whether it is of a rotation matrix, which has no unit.
    pub fn says_rotation(&self) -> bool {
        let of = |word: &String| {
            word.to_lowercase().starts_with("rotation") || word.starts_with("R_") || word == "axes"
        };
        self.words.iter().any(of)
    }
}
