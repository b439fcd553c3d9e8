//! Reads rows of numbers from text files and numpy arrays.

use std::fs::File;
use std::io::{BufReader, Cursor, Read as _};
use std::path::{Path, PathBuf};

use whitefurnace::error::Error;

use super::{npy, text};

/// A row of numbers as it is in a file.
pub struct Row<'a> {
    /// Names of the columns in lower case, if the file has them; - for a column without.
    pub names: Option<&'a [String]>,
    /// The values.
    pub numbers: &'a [f64],
    /// Their digits, if they are printed.
    pub digits: Option<&'a [DigitCounts]>,
}

/// Digits of a printed number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DigitCounts {
    /// Digits after the decimal point, minus the exponent.
    pub decimals: i32,
    /// Digits from the first that is not 0.
    pub significant: i32,
}

impl DigitCounts {
    /// Counts the digits of a number with a decimal point.
    pub fn of(text: &str) -> Self {
        let (digits, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
        let behind = digits
            .split_once('.')
            .map_or(0, |(_, behind)| behind.len() as i32);
        let figures = digits
            .chars()
            .filter(char::is_ascii_digit)
            .skip_while(|c| *c == '0')
            .count() as i32;
        Self {
            decimals: behind - exponent.parse::<i32>().unwrap_or(0).clamp(-400, 400),
            significant: figures,
        }
    }
}

/// Callback for each row.
pub type RowCallback<'a> = &'a mut dyn FnMut(&Row) -> Result<(), String>;

/// Calls `each` with each row of a file. Its errors are reported with the file and the line of a
/// text, or the index of a row of an array. `file.npz:name` chooses an array of an archive.
///
/// # Errors
/// [`Error::File`] or [`Error::Option`].
pub fn rows(path: &Path, each: RowCallback) -> Result<(), Error> {
    let (path, chosen) = split_array_name(path);
    let open = || File::open(&path).map_err(Error::file("read", &path));
    let mut start = Vec::new();
    open()?
        .take(512)
        .read_to_end(&mut start)
        .map_err(Error::file("read", &path))?;
    let wrong = |message: String| Error::Option(format!("{}: {message}", path.display()));
    if start.starts_with(b"\x93NUMPY") {
        let bytes = std::fs::metadata(&path)
            .map_err(Error::file("read", &path))?
            .len();
        return npy::array(BufReader::new(open()?), bytes, each).map_err(wrong);
    }
    if start.starts_with(b"PK") {
        let bytes = std::fs::read(&path).map_err(Error::file("read", &path))?;
        return npy::archive(&bytes, chosen.as_deref(), &path, each).map_err(wrong);
    }
    if let Some((_, what)) = FILE_SIGNATURES
        .iter()
        .find(|(magic, _)| start.starts_with(magic))
    {
        return Err(wrong(format!("{what}, which is not read: {REMEDY}")));
    }
    if let Some(decode) = utf16(&start) {
        let bytes = std::fs::read(&path).map_err(Error::file("read", &path))?;
        let units: Vec<u16> = bytes
            .chunks_exact(2)
            .map(|pair| decode([pair[0], pair[1]]))
            .collect();
        let decoded =
            String::from_utf16(&units).map_err(|_| wrong("damaged UTF-16 text".to_owned()))?;
        if bytes.len() % 2 == 1 {
            return Err(wrong(
                "UTF-16 text with half a character at its end: has it been cut off?".to_owned(),
            ));
        }
        return text::rows(Cursor::new(decoded), each).map_err(wrong);
    }
    if start.contains(&0) {
        return Err(wrong(format!("neither text nor a numpy array: {REMEDY}")));
    }
    text::rows(BufReader::new(open()?), each).map_err(wrong)
}

const REMEDY: &str = "save the numbers as text (CSV), or by numpy.save";

/// First bytes of common files of other formats, and what they are.
const FILE_SIGNATURES: [(&[u8], &str); 9] = [
    (
        b"\x1f\x8b",
        "a file compressed by gzip (unpack it by gunzip)",
    ),
    (b"BZh", "a file compressed by bzip2 (unpack it by bunzip2)"),
    (b"\xfd7zXZ", "a file compressed by xz (unpack it by unxz)"),
    (
        b"\x28\xb5\x2f\xfd",
        "a file compressed by zstd (unpack it by unzstd)",
    ),
    (b"\x89HDF", "a file of HDF5"),
    (b"PAR1", "a file of Parquet"),
    (b"MATLAB", "a file of MATLAB"),
    (b"\x76\x2f\x31\x01", "an image in EXR"),
    (b"\x89PNG", "an image in PNG"),
];

/// Splits a path into the file and the array's name after a colon.
fn split_array_name(path: &Path) -> (PathBuf, Option<String>) {
    match path.to_str().and_then(|name| name.rsplit_once(':')) {
        Some((file, array)) if !path.exists() && Path::new(file).is_file() => {
            (file.into(), Some(array.to_owned()))
        }
        _ => (path.to_owned(), None),
    }
}

/// Returns how two bytes make a character of a text that starts with these bytes, if it is UTF-16.
fn utf16(start: &[u8]) -> Option<fn([u8; 2]) -> u16> {
    match start {
        [0xff, 0xfe, 0, 0, ..] => None,
        [0xff, 0xfe, ..] | [1..=127, 0, 1..=127, 0, ..] => Some(u16::from_le_bytes),
        [0xfe, 0xff, ..] | [0, 1..=127, 0, 1..=127, ..] => Some(u16::from_be_bytes),
        _ => None,
    }
}
