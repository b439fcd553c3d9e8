//! Reads rows of numbers from text: separated by commas, semicolons, tabs or blanks, with decimal
//! points or commas.

use std::io::BufRead;

use super::read::{DigitCounts, Row, RowCallback};

/// Calls `each` with each row of numbers.
///
/// # Errors
/// The problem, with the line.
pub fn rows(mut file: impl BufRead, each: RowCallback) -> Result<(), String> {
    let (mut text, mut bytes) = (Text::default(), Vec::new());
    loop {
        bytes.clear();
        if file
            .read_until(b'\n', &mut bytes)
            .map_err(|error| error.to_string())?
            == 0
        {
            return Ok(());
        }
        let chunk = std::str::from_utf8(&bytes).map_err(|_| {
            format!(
                "line {}: not UTF-8: neither text nor an array; save it as CSV, or by numpy.save",
                text.line + 1
            )
        })?;
        // Lines that end with CR alone come as one chunk.
        let complete = chunk.ends_with(['\n', '\r']);
        let chunk = chunk.strip_suffix('\n').unwrap_or(chunk);
        let chunk = chunk.strip_suffix('\r').unwrap_or(chunk);
        let mut lines = chunk.split('\r').peekable();
        while let Some(line) = lines.next() {
            text.line += 1;
            let whole = complete || lines.peek().is_some();
            text.read(line, whole, each)
                .map_err(|error| format!("line {}: {error}", text.line))?;
        }
    }
}

/// State of the parser: what the text has shown so far.
#[derive(Default)]
struct Text {
    line: usize,
    names: Option<Vec<String>>,
    style: Option<Style>,
    numbers: Vec<f64>,
    digits: Vec<DigitCounts>,
    /// Decimals of the last number of each line as long as they are all equal, and the number of
    /// lines.
    fixed: Option<(i32, usize)>,
}

/// Separator and decimal mark of numbers.
#[derive(Clone, Copy, PartialEq)]
struct Style {
    separator: Separator,
    decimal_comma: bool,
}

#[derive(Clone, Copy, PartialEq)]
enum Separator {
    Character(char),
    /// Blanks and tabs.
    Blank,
}

impl Separator {
    /// Returns the separator of a line: the first of these that occurs.
    fn of(line: &str) -> Self {
        [';', '\t', ',', '|']
            .into_iter()
            .find(|&c| line.contains(c))
            .map_or(Self::Blank, Self::Character)
    }

    fn fields(self, line: &str) -> Vec<&str> {
        match self {
            Self::Blank => line.split_whitespace().collect(),
            Self::Character(separator) => line.split(separator).map(str::trim).collect(),
        }
    }
}

impl Text {
    fn read(&mut self, line: &str, whole: bool, each: RowCallback) -> Result<(), String> {
        let line = line.trim_start_matches('\u{feff}').trim();
        if let Some(comment) = line.strip_prefix(['#', '%']).or(line.strip_prefix("//")) {
            // numpy.savetxt writes a header as a comment.
            let names = names(comment);
            if self.style.is_none()
                && names
                    .iter()
                    .all(|name| super::columns::NAMES.contains(&name.as_str()))
            {
                self.names = Some(names);
            }
            return Ok(());
        }
        // Brackets of printed lists, and separators at the end.
        const BRACKETS: [char; 7] = ['[', ']', '(', ')', '{', '}', ' '];
        let data = line
            .trim_start_matches(BRACKETS)
            .trim_end_matches(BRACKETS)
            .trim_end_matches([',', ';', '\t']);
        let data = data.trim_end_matches(BRACKETS);
        if data.is_empty() {
            return Ok(());
        }
        let first = self.style.is_none();
        let style = match self.style {
            Some(style) => style,
            None if is_header(line) => {
                self.names = Some(names(line));
                return Ok(());
            }
            None => *self.style.insert(Style::of(data)),
        };
        if first && is_ambiguous(style, data) {
            return Err(
                "commas may be decimal marks here, or separate whole numbers: separate the numbers by semicolons"
                    .to_owned(),
            );
        }
        self.numbers.clear();
        self.digits.clear();
        for field in style.fields(data) {
            let (number, digits) = style.number(field)?;
            self.numbers.push(number);
            self.digits.push(digits);
        }
        let cut = "; the file ends within this line: has it been cut off?";
        let last = self.digits.last().map_or(0, |digits| digits.decimals);
        match self.fixed {
            Some((decimals, lines)) if !whole && lines >= 10 && last < decimals => {
                return Err(format!(
                    "its last number has fewer decimals than those before{cut}"
                ));
            }
            Some((decimals, lines)) if decimals == last => self.fixed = Some((decimals, lines + 1)),
            Some(_) => self.fixed = Some((last, 0)),
            None => self.fixed = Some((last, usize::from(first))),
        }
        let row = Row {
            names: self.names.as_deref(),
            numbers: &self.numbers,
            digits: Some(&self.digits),
        };
        each(&row).map_err(|error| if whole || first { error } else { error + cut })
    }
}

/// Returns true if a line has words and nothing that begins as a number does.
fn is_header(line: &str) -> bool {
    let styles = [false, true].map(|decimal_comma| Style {
        separator: Separator::Blank,
        decimal_comma,
    });
    let is_number = |field: &&str| {
        let unsigned = plain(field).trim_start_matches(['+', '-', '\u{2212}', '.', ',']);
        unsigned.starts_with(|c: char| c.is_ascii_digit())
            || styles.iter().any(|style| style.number(field).is_ok())
    };
    line.contains(char::is_alphabetic) && !Separator::of(line).fields(line).iter().any(is_number)
}

/// Returns true if commas could be separators as well as decimal marks, as in 0,6,0,0,0,8: what
/// stands before each other comma are small numbers, or shorter ones than what follows.
fn is_ambiguous(style: Style, line: &str) -> bool {
    let fields: Vec<&str> = style
        .fields(line)
        .into_iter()
        .map(|field| plain(field).trim_start_matches(['-', '\u{2212}', '+']))
        .collect();
    let whole = |field: &&str| field.chars().all(|c| c.is_ascii_digit());
    let could_be = |is_pair: fn(&str, &str) -> bool| {
        fields.chunks(2).all(|pair| match pair {
            [before, behind] => is_pair(before, behind),
            _ => false,
        })
    };
    style.separator == Separator::Character(',')
        && fields.len() >= 6
        && fields.iter().all(whole)
        && (could_be(|before, _| ["0", "1"].contains(&before))
            || could_be(|before, behind| behind.len() > before.len()))
}

/// Returns the names in a header, in lower case, without quotes and units.
pub(super) fn names(line: &str) -> Vec<String> {
    Separator::of(line.trim())
        .fields(line.trim())
        .into_iter()
        .map(name)
        .collect()
}

/// Names of directions that may stand before the name of a coordinate, as in `wi_x`, `dir.y` or
/// `wz`.
const DIRECTION_NAMES: [&str; 9] = [
    "wi",
    "wo",
    "w",
    "omega",
    "dir",
    "direction",
    "d",
    "sample",
    "v",
];

/// Returns a column's name in lower case, without quotes, units and the name of the direction; -
/// for none.
pub(super) fn name(field: &str) -> String {
    let field = plain(field);
    let name = field
        .split(['(', '[', '/'])
        .next()
        .unwrap_or_default()
        .trim()
        .to_lowercase();
    if name.is_empty() {
        return "-".to_owned();
    }
    ["x", "y", "z"]
        .into_iter()
        .find(|axis| {
            let vector = name.strip_suffix(axis).unwrap_or_default();
            DIRECTION_NAMES.contains(&vector.trim_end_matches(['_', '.', '-', ' ']))
        })
        .map_or(name.clone(), str::to_owned)
}

/// Returns a field without quotes.
fn plain(field: &str) -> &str {
    field.trim().trim_matches(['"', '\'']).trim()
}

impl Style {
    /// Detects the style of a line of numbers.
    fn of(line: &str) -> Self {
        let separator = Separator::of(line);
        let points = Self {
            separator,
            decimal_comma: false,
        };
        let readable = |style: &Self| {
            style
                .fields(line)
                .iter()
                .all(|field| style.number(field).is_ok())
        };
        let separators = [separator, Separator::Blank];
        let commas = separators.map(|separator| Self {
            separator,
            decimal_comma: true,
        });
        // Commas that separate are not decimal.
        let commas = commas
            .into_iter()
            .filter(|style| style.separator != Separator::Character(','));
        let blanks = Self {
            separator: Separator::Blank,
            decimal_comma: false,
        };
        std::iter::once(points)
            .chain(commas)
            .chain([blanks])
            .find(readable)
            .unwrap_or(points)
    }

    fn fields(self, line: &str) -> Vec<&str> {
        self.separator.fields(line)
    }

    fn number(self, field: &str) -> Result<(f64, DigitCounts), String> {
        let field = plain(field);
        let wrong = |hint: &str| format!("“{}” is not a number{hint}", field.escape_debug());
        let mixed = || {
            Err(wrong(
                ": some lines have decimal commas, others decimal points",
            ))
        };
        let pointed = match (self.decimal_comma, field.contains(','), field.contains('.')) {
            (true, true, false) => field.replacen(',', ".", 1),
            (true, false, true) => return mixed(),
            (false, true, false) if self.separator != Separator::Blank => return mixed(),
            _ => field.to_owned(),
        };
        // Word processors replace hyphens.
        let pointed = pointed.replace('\u{2212}', "-");
        // Fortran writes exponents with D.
        let pointed = if pointed.starts_with(|c: char| c.is_alphabetic()) {
            pointed
        } else {
            pointed.replace(['D', 'd'], "e")
        };
        match pointed.parse() {
            Ok(number) => Ok((number, DigitCounts::of(&pointed))),
            Err(_) => Err(wrong("")),
        }
    }
}
