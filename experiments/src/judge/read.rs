//! Rows of numbers from CSV and NPY files.

use std::fs::File;
use std::io::{BufReader, Read as _};
use std::path::Path;

use npyz::{NpyFile, Order};
use whitefurnace::error::Error;

/// What is done with a row, beside the names in a CSV's header if it has one.
type Each<'a> = &'a mut dyn FnMut(Option<&[String]>, &[f64]) -> Result<(), String>;

/// Hands each row to `each`. What that finds wrong is told with the file and the line of a CSV, or the index of a row of
/// an array.
///
/// # Errors
/// [`Error::File`] or [`Error::Option`].
pub fn rows(path: &Path, each: Each) -> Result<(), Error> {
    let open = || File::open(path).map_err(Error::file("read", path));
    let mut magic = [0; 6];
    let length = open()?.read(&mut magic).map_err(Error::file("read", path))?;
    let wrong = |message: String| Error::Option(format!("{}: {message}", path.display()));
    if magic[..length] == *b"\x93NUMPY" {
        let bytes = std::fs::metadata(path).map_err(Error::file("read", path))?.len();
        npy(BufReader::new(open()?), bytes, each).map_err(wrong)
    } else {
        csv(BufReader::new(open()?), each).map_err(wrong)
    }
}

fn csv(file: BufReader<File>, each: Each) -> Result<(), String> {
    let mut reader =
        csv::ReaderBuilder::new().has_headers(false).trim(csv::Trim::All).comment(Some(b'#')).from_reader(file);
    let (mut record, mut numbers, mut header) = (csv::StringRecord::new(), Vec::new(), None);
    while reader.read_record(&mut record).map_err(|error| error.to_string().replace('\n', " "))? {
        let line = record.position().map_or(1, csv::Position::line);
        numbers.clear();
        for field in &record {
            match field.parse::<f64>() {
                Ok(number) => numbers.push(number),
                Err(_) if line == 1 && numbers.is_empty() => break,
                Err(_) => return Err(format!("line {line}: “{}” is no number", field.escape_debug())),
            }
        }
        if numbers.is_empty() {
            header = Some(record.iter().map(str::to_lowercase).collect::<Vec<_>>());
        } else {
            each(header.as_deref(), &numbers).map_err(|error| format!("line {line}: {error}"))?;
        }
    }
    Ok(())
}

/// An array of two dimensions of 32 or 64-bit floats.
fn npy(file: BufReader<File>, bytes: u64, each: Each) -> Result<(), String> {
    let first_line = |error: std::io::Error| error.to_string().lines().next().unwrap_or_default().to_owned();
    let array = NpyFile::new(file).map_err(|error| format!("no header of an array: {}", first_line(error)))?;
    let &[rows, columns] = array.shape() else {
        return Err(format!(
            "an array of shape {:?}: a row for each sample is needed, as of shape (n, 3)",
            array.shape()
        ));
    };
    if columns == 0 {
        return Err("an array without columns".to_owned());
    }
    let size = match array.dtype().num_bytes() {
        Some(size)
            if rows.checked_mul(columns).and_then(|n| n.checked_mul(size as u64)).is_some_and(|all| all <= bytes) =>
        {
            size
        }
        _ => return Err(format!("shorter than its shape {rows} × {columns} says, or not of numbers")),
    };
    let columns_first = array.order() == Order::Fortran;
    let text = |error: std::io::Error| error.to_string();
    let kind = array.dtype().descr();
    // Either width as 64 bits.
    let numbers: Box<dyn Iterator<Item = Result<f64, String>>> = if size == 8 {
        let data =
            array.data::<f64>().map_err(|_| format!("numbers of type {kind}: save them as float32 or float64"))?;
        Box::new(data.map(move |number| number.map_err(text)))
    } else {
        let data =
            array.data::<f32>().map_err(|_| format!("numbers of type {kind}: save them as float32 or float64"))?;
        Box::new(data.map(move |number| number.map(f64::from).map_err(text)))
    };
    let (rows, columns) = (rows as usize, columns as usize);
    let mut row = Vec::with_capacity(columns.min(1 << 16));
    let mut tell = |number: usize, row: &[f64]| each(None, row).map_err(|error| format!("row {number}: {error}"));
    if columns_first {
        let all = numbers.collect::<Result<Vec<f64>, String>>()?;
        for i in 0..rows {
            row.clear();
            row.extend((0..columns).map(|k| all[k * rows + i]));
            tell(i, &row)?;
        }
        return Ok(());
    }
    let mut numbers = numbers;
    for i in 0..rows {
        row.clear();
        for _ in 0..columns {
            row.push(numbers.next().ok_or("too short")??);
        }
        tell(i, &row)?;
    }
    Ok(())
}
