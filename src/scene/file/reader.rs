//! TOML in which every value knows its line, and errors of one line.

use std::fmt::Display;
use std::ops::RangeInclusive;
use std::rc::Rc;

use glam::DVec3;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::synonyms::advice;
use crate::error::Error;
use crate::suggest::did_you_mean;

/// Largest coordinate, length and radiance: none of their products is near the largest number.
pub(super) const LARGEST: f64 = 1e9;

/// A text and the file it is from.
pub(super) struct Source<'s> {
    pub file: &'s str,
    pub text: &'s str,
}

impl Source<'_> {
    /// Parses the text as a table.
    pub fn parse(&self) -> Result<Spanned<DeTable<'_>>, Error> {
        DeTable::parse(self.text).map_err(|error| {
            let at = error.span().map_or(self.text.len(), |span| span.start);
            self.error_at(
                at,
                format!("this is not TOML: {}", error.message().replace('\n', " ")),
            )
        })
    }

    /// Returns the error at a byte of the text.
    pub fn error_at(&self, at: usize, message: impl Display) -> Error {
        error_at_line(self.file, self.line(at), message)
    }

    /// Returns the line of a byte of the text, from 1.
    fn line(&self, at: usize) -> usize {
        let before = &self.text.as_bytes()[..at.min(self.text.len())];
        1 + before.iter().filter(|byte| **byte == b'\n').count()
    }
}

/// Returns the error at a line of a file.
pub(super) fn error_at_line(file: impl Display, line: usize, message: impl Display) -> Error {
    Error::Scene {
        scene: format!("{file}, line {line}"),
        message: message.to_string(),
    }
}

/// Quotes the start of a user's text, on one line.
pub(super) fn quote(text: &str) -> String {
    let start: String = text.chars().take(40).collect();
    format!(
        "{start:?}{}",
        if start.len() < text.len() { "..." } else { "" }
    )
}

/// A value and its position.
#[derive(Clone)]
pub(super) struct Value<'s> {
    source: &'s Source<'s>,
    /// Keys from the root of the file.
    path: Rc<str>,
    value: &'s Spanned<DeValue<'s>>,
}

impl<'s> Value<'s> {
    /// Returns an error about the value; the message ends a sentence that begins with its keys.
    pub fn error(&self, message: impl Display) -> Error {
        self.source
            .error_at(self.value.span().start, format!("{} {message}", self.path))
    }

    pub fn number(&self, range: RangeInclusive<f64>) -> Result<f64, Error> {
        let number = match self.value.get_ref() {
            DeValue::Integer(n) => i64::from_str_radix(n.as_str(), n.radix())
                .ok()
                .map(|n| n as f64),
            DeValue::Float(x) => x.as_str().parse().ok(),
            _ => None,
        };
        number
            .filter(|number| range.contains(number))
            .ok_or_else(|| {
                let (low, high) = (range.start(), range.end());
                self.error(format!("must be a number from {low} to {high}"))
            })
    }

    /// Reads an index below `count`.
    pub fn index(&self, count: usize) -> Result<u32, Error> {
        let last = count.saturating_sub(1) as f64;
        let index = self
            .number(0.0..=last)
            .ok()
            .filter(|index| index.fract() == 0.0 && count > 0);
        index.map(|index| index as u32).ok_or_else(|| {
            self.error(format!(
                "points at a vertex that is not there: there are {count}, and the first is 0"
            ))
        })
    }

    pub fn array(&self) -> Result<impl ExactSizeIterator<Item = Self> + use<'s>, Error> {
        let (source, path) = (self.source, Rc::clone(&self.path));
        let array = self
            .value
            .get_ref()
            .as_array()
            .ok_or_else(|| self.error("must be an array"))?;
        Ok(array.iter().map(move |value| Self {
            source,
            path: Rc::clone(&path),
            value,
        }))
    }

    /// Reads an array of two values of one kind.
    pub fn two<T>(&self, each: impl Fn(&Self) -> Result<T, Error>) -> Result<[T; 2], Error> {
        let items = self
            .array()?
            .map(|item| each(&item))
            .collect::<Result<Vec<T>, _>>()?;
        items
            .try_into()
            .map_err(|_| self.error("must be an array of two"))
    }

    fn three(&self, range: RangeInclusive<f64>) -> Result<DVec3, Error> {
        let three = self.array().ok().filter(|array| array.len() == 3);
        let numbers = three.ok_or_else(|| self.error("must be three numbers, as in [0, 0, 1]"))?;
        let numbers: Vec<f64> = numbers
            .map(|number| number.number(range.clone()))
            .collect::<Result<_, _>>()?;
        Ok(DVec3::from_slice(&numbers))
    }

    pub fn point(&self) -> Result<DVec3, Error> {
        self.three(-LARGEST..=LARGEST)
    }

    /// Reads a colour: one number for all channels, or three.
    pub fn colour(&self, range: RangeInclusive<f64>) -> Result<DVec3, Error> {
        if self.value.get_ref().is_array() {
            self.three(range)
        } else {
            Ok(DVec3::splat(self.number(range)?))
        }
    }

    pub fn text(&self) -> Result<&'s str, Error> {
        self.value
            .get_ref()
            .as_str()
            .ok_or_else(|| self.error("must be a text in quotation marks"))
    }

    pub fn truth(&self) -> Result<bool, Error> {
        self.value
            .get_ref()
            .as_bool()
            .ok_or_else(|| self.error("must be true or false"))
    }

    /// Reads the choice whose name is given.
    pub fn choice<T: Copy>(
        &self,
        choices: &[(&'static str, T)],
    ) -> Result<(&'static str, T), Error> {
        let name = self.text()?;
        choices
            .iter()
            .find(|choice| choice.0 == name)
            .copied()
            .ok_or_else(|| {
                let names: Vec<&str> = choices.iter().map(|choice| choice.0).collect();
                let hint = advice(name, &names).unwrap_or_else(|| did_you_mean(name, names));
                self.error(format!("cannot be {}{hint}", quote(name)))
            })
    }

    pub fn is_table(&self) -> bool {
        self.value.get_ref().is_table()
    }

    pub fn table(&self) -> Result<Table<'s>, Error> {
        let (source, path, at) = (self.source, Rc::clone(&self.path), self.value.span().start);
        let entries = self
            .value
            .get_ref()
            .as_table()
            .ok_or_else(|| self.error("must be a table of keys"))?;
        Ok(Table {
            source,
            path,
            at,
            entries,
        })
    }
}

/// A table of keys and values.
pub(super) struct Table<'s> {
    pub source: &'s Source<'s>,
    pub path: Rc<str>,
    pub at: usize,
    pub entries: &'s DeTable<'s>,
}

impl<'s> Table<'s> {
    pub fn root(source: &'s Source<'s>, table: &'s Spanned<DeTable<'s>>) -> Self {
        Self {
            source,
            path: "".into(),
            at: 0,
            entries: table.get_ref(),
        }
    }

    /// Returns an error about the table; the message ends a sentence that begins with its keys.
    pub fn error(&self, message: impl Display) -> Error {
        let what = if self.path.is_empty() {
            "the file"
        } else {
            &self.path
        };
        self.source.error_at(self.at, format!("{what} {message}"))
    }

    /// Returns a note about the table, with its file and line.
    pub fn note(&self, message: impl Display) -> String {
        format!(
            "{}, line {}: {} {message}",
            self.source.file,
            self.source.line(self.at),
            self.path
        )
    }

    pub fn get(&self, key: &str) -> Option<Value<'s>> {
        Some(self.value(key, self.entries.get(key)?))
    }

    /// Reads the value of a key that may be left out, and has this default.
    pub fn read_or<T>(
        &self,
        key: &str,
        default: T,
        read: impl FnOnce(Value<'s>) -> Result<T, Error>,
    ) -> Result<T, Error> {
        self.get(key).map_or(Ok(default), read)
    }

    /// Returns the value of a required key.
    pub fn need(&self, key: &str) -> Result<Value<'s>, Error> {
        let other = || {
            self.entries
                .keys()
                .find(|other| advice(other.get_ref(), &[key]).is_some())
        };
        let hint = || {
            other().map_or(String::new(), |other| {
                format!("; {} is not known here", quote(other.get_ref()))
            })
        };
        self.get(key)
            .ok_or_else(|| self.error(format!("needs the key {key}{}", hint())))
    }

    /// Iterates over all keys with their values, in the order of the file.
    pub fn entries(&self) -> impl Iterator<Item = (&'s str, Value<'s>)> {
        let mut rows: Vec<_> = self.entries.iter().collect();
        rows.sort_by_key(|(key, _)| key.span().start);
        rows.into_iter()
            .map(|(key, value)| (key.get_ref().as_ref(), self.value(key.get_ref(), value)))
    }

    pub fn value(&self, key: &str, value: &'s Spanned<DeValue<'s>>) -> Value<'s> {
        let dot = if self.path.is_empty() { "" } else { "." };
        let key = if key.chars().all(|c| c.is_alphanumeric() || "-_".contains(c)) {
            key.to_owned()
        } else {
            quote(key)
        };
        Value {
            source: self.source,
            path: format!("{}{dot}{key}", self.path).into(),
            value,
        }
    }
}
