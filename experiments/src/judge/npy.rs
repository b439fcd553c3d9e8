//! Reads rows of numbers from numpy arrays: one in a file, or several in an archive.

use std::io::{Cursor, Read};
use std::path::Path;

use flate2::read::DeflateDecoder;
use npyz::{DType, Endianness, NpyHeader, Order, TypeChar, TypeStr};

use super::columns::NAMES;
use super::read::{Row, RowCallback};
use super::text;

/// A number at the same position in every element of an array.
struct Column {
    name: Option<String>,
    /// Offset in bytes from the start of the row.
    offset: usize,
    number: fn(&[u8]) -> f64,
    size: usize,
}

/// Calls `each` with each row of a two-dimensional array, or an array of structures; the file has
/// `bytes` bytes.
///
/// # Errors
/// The problem, with the index of the row.
pub fn array(mut file: impl Read, bytes: u64, each: RowCallback) -> Result<(), String> {
    let header = NpyHeader::from_reader(&mut file).map_err(|error| {
        format!(
            "no header of an array: {}",
            error.to_string().lines().next().unwrap_or_default()
        )
    })?;
    let dtype = header.dtype();
    let columns = columns(&dtype)?;
    let plain = columns[0].name.is_none();
    let (rows, width) = match (header.shape(), plain) {
        (&[rows, width], true) => (rows, width),
        (&[rows], false) => (rows, 1),
        (&[], _) => return Err("a single value: an array of shape (n, 3) is needed".to_owned()),
        (shape, true) => {
            return Err(format!(
                "an array of shape {shape:?}: a row for each sample is needed, as of shape (n, 3); reshape(-1, 3) gives it, if \
                 x, y, z come last"
            ));
        }
        (shape, false) => {
            return Err(format!(
                "structures in shape {shape:?}: an array of shape (n,) is needed"
            ));
        }
    };
    if width == 0 {
        return Err("an array without columns".to_owned());
    }
    let size = dtype.num_bytes().filter(|&size| {
        rows.checked_mul(width)
            .and_then(|n| n.checked_mul(size as u64))
            .is_some_and(|all| all <= bytes)
    });
    let Some(size) = size else {
        return Err(format!(
            "shorter than its shape {rows} × {width} says: the file has been cut off"
        ));
    };
    let (rows, width) = (rows as usize, width as usize);
    let names: Option<Vec<String>> = columns.iter().map(|column| column.name.clone()).collect();
    let cut = |_| "shorter than its shape says: the file has been cut off".to_owned();
    let mut numbers = vec![0.0; width * columns.len()];
    let mut tell = |i: usize, numbers: &[f64]| {
        let row = Row {
            names: names.as_deref(),
            numbers,
            digits: None,
        };
        each(&row).map_err(|error| format!("row {i}: {error}"))
    };
    let columns_first = plain && header.order() == Order::Fortran;
    let mut bytes = vec![0; size * width * if columns_first { rows } else { 1 }];
    if columns_first {
        file.read_exact(&mut bytes).map_err(cut)?;
    }
    for i in 0..rows {
        if columns_first {
            for (k, number) in numbers.iter_mut().enumerate() {
                *number = (columns[0].number)(&bytes[(k * rows + i) * size..][..size]);
            }
        } else {
            file.read_exact(&mut bytes).map_err(cut)?;
            for (k, number) in numbers.iter_mut().enumerate() {
                let column = &columns[k % columns.len()];
                *number = (column.number)(
                    &bytes[(k / columns.len()) * size + column.offset..][..column.size],
                );
            }
        }
        tell(i, &numbers)?;
    }
    Ok(())
}

/// Returns the columns of an element: a number, or a structure of numbers, of which three together
/// are x, y, z.
fn columns(dtype: &DType) -> Result<Vec<Column>, String> {
    let DType::Record(fields) = dtype else {
        let DType::Plain(kind) = dtype else {
            return Err("an array of arrays: an array of shape (n, 3) is needed".to_owned());
        };
        return Ok(vec![Column {
            name: None,
            offset: 0,
            number: number(kind)?,
            size: size(kind),
        }]);
    };
    let (mut columns, mut offset) = (Vec::new(), 0);
    for field in fields {
        let (kinds, names) = match &field.dtype {
            DType::Array(3, inner) => (inner.as_ref(), NAMES[..3].to_vec()),
            one => (one, vec![field.name.as_str()]),
        };
        let DType::Plain(kind) = kinds else {
            return Err(format!(
                "the structure's “{}” is neither a number nor three",
                field.name.escape_debug()
            ));
        };
        // Padding of a structure has no name.
        let padding = kind.type_char() == TypeChar::RawData && field.name.is_empty();
        for name in names.into_iter().filter(|_| !padding) {
            columns.push(Column {
                name: Some(text::name(name)),
                offset,
                number: number(kind)?,
                size: size(kind),
            });
            offset += size(kind);
        }
        offset += if padding { size(kind) } else { 0 };
    }
    if columns.is_empty() {
        Err("structures without numbers".to_owned())
    } else {
        Ok(columns)
    }
}

fn size(kind: &TypeStr) -> usize {
    kind.num_bytes().unwrap_or(0)
}

/// Returns the function that decodes a number's bytes.
fn number(kind: &TypeStr) -> Result<fn(&[u8]) -> f64, String> {
    macro_rules! either {
        ($number:ty) => {
            if kind.endianness() == Endianness::Big {
                |bytes| <$number>::from_be_bytes(bytes.try_into().unwrap_or_default()) as f64
            } else {
                |bytes| <$number>::from_le_bytes(bytes.try_into().unwrap_or_default()) as f64
            }
        };
    }
    Ok(match (kind.type_char(), size(kind)) {
        (TypeChar::Float, 8) => either!(f64),
        (TypeChar::Float, 4) => either!(f32),
        (TypeChar::Float, 2) if kind.endianness() == Endianness::Big => {
            |bytes| f16_to_f64(u16::from_be_bytes([bytes[0], bytes[1]]))
        }
        (TypeChar::Float, 2) => |bytes| f16_to_f64(u16::from_le_bytes([bytes[0], bytes[1]])),
        (TypeChar::Int, 1) => either!(i8),
        (TypeChar::Int, 2) => either!(i16),
        (TypeChar::Int, 4) => either!(i32),
        (TypeChar::Int, 8) => either!(i64),
        (TypeChar::Uint | TypeChar::Bool, 1) => either!(u8),
        (TypeChar::Uint, 2) => either!(u16),
        (TypeChar::Uint, 4) => either!(u32),
        (TypeChar::Uint, 8) => either!(u64),
        _ => {
            return Err(format!(
                "numbers of type {kind}: save them as float32 or float64"
            ));
        }
    })
}

/// Converts a 16-bit float.
fn f16_to_f64(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023) / 1024.0);
    let size = match exponent {
        0 => fraction * 2f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction) * 2f64.powi(exponent - 15),
    };
    if bits >> 15 == 0 { size } else { -size }
}

/// An array in an archive: its name, shape, and file.
struct Member {
    name: String,
    shape: Vec<u64>,
    bytes: Vec<u8>,
}

/// Calls `each` with each row of an archive: of its only array, of the `chosen` one, or of arrays
/// named x, y, z, weight and pdf, or of shape (n, 3) for x, y, z.
///
/// # Errors
/// The problem, and the arrays that may be chosen.
pub fn archive(
    file: &[u8],
    chosen: Option<&str>,
    path: &Path,
    each: RowCallback,
) -> Result<(), String> {
    let mut members = Vec::new();
    for (name, bytes) in
        unzip(file).ok_or("a damaged zip archive, or one above 4 GB: has it been cut off?")?
    {
        let Some(name) = name.strip_suffix(".npy").map(str::to_owned) else {
            continue;
        };
        let header = NpyHeader::from_reader(bytes.as_slice())
            .map_err(|_| format!("its array {name} has no header"))?;
        members.push(Member {
            name,
            shape: header.shape().to_vec(),
            bytes,
        });
    }
    if let Some(chosen) = chosen {
        members.retain(|member| member.name == chosen);
    }
    match members.as_slice() {
        [] if chosen.is_some() => Err(format!(
            "no array in it is called {}",
            chosen.unwrap_or_default()
        )),
        [] => Err(
            "a zip archive without numpy arrays: save the numbers as CSV, or by numpy.save"
                .to_owned(),
        ),
        [one] => array(one.bytes.as_slice(), one.bytes.len() as u64, each),
        several => join_columns(several, each).unwrap_or_else(|| {
            let list: Vec<String> = several
                .iter()
                .map(|one| format!("{} {:?}", one.name, one.shape))
                .collect();
            let name = path.display();
            Err(format!(
                "several arrays, {}: choose one as in {name}:{}",
                list.join(", "),
                several[0].name
            ))
        }),
    }
}

/// Returns the files in a zip archive with their names, stored or compressed by deflate; `None` if
/// the archive is damaged.
///
/// Offsets in records are those of PKWARE's APPNOTE 6.3, sections 4.3.7, 4.3.12 and 4.3.16.
fn unzip(file: &[u8]) -> Option<Vec<(String, Vec<u8>)>> {
    let number = |at: usize, bytes: usize| {
        let slice = file.get(at..at.checked_add(bytes)?)?;
        Some(
            slice
                .iter()
                .rev()
                .fold(0, |sum, &byte| sum << 8 | usize::from(byte)),
        )
    };
    // The last record gives the position of the directory.
    let end = file.windows(4).rposition(|bytes| bytes == b"PK\x05\x06")?;
    let (count, mut entry) = (number(end + 10, 2)?, number(end + 16, 4)?);
    let mut files = Vec::new();
    for _ in 0..count {
        if file.get(entry..entry.checked_add(4)?)? != b"PK\x01\x02" {
            return None;
        }
        let [method, packed, size] = [
            number(entry + 10, 2)?,
            number(entry + 20, 4)?,
            number(entry + 24, 4)?,
        ];
        let [name, extra, comment] = [28, 30, 32].map(|at| number(entry + at, 2));
        let (name, local) = (name?, number(entry + 42, 4)?);
        let data =
            local.checked_add(30 + number(local.checked_add(26)?, 2)? + number(local + 28, 2)?)?;
        let data = file.get(data..data.checked_add(packed)?)?;
        let mut bytes = Vec::new();
        match method {
            0 => bytes.extend_from_slice(data),
            8 => {
                DeflateDecoder::new(data)
                    .take(size as u64)
                    .read_to_end(&mut bytes)
                    .ok()?;
            }
            _ => return None,
        }
        let is_whole = bytes.len() == size;
        files.push((
            String::from_utf8_lossy(file.get(entry + 46..entry + 46 + name)?).into_owned(),
            bytes,
        ));
        if !is_whole {
            return None;
        }
        entry += 46 + name + extra? + comment?;
    }
    Some(files)
}

/// Joins arrays whose names are those of columns into rows; `None` if the names are others.
fn join_columns(members: &[Member], each: RowCallback) -> Option<Result<(), String>> {
    let rows = *members[0].shape.first()?;
    let mut names: Vec<String> = Vec::new();
    for member in members {
        match *member.shape.as_slice() {
            [n, 3] if n == rows => names.extend(NAMES[..3].iter().map(|&name| name.to_owned())),
            [n] if n == rows => names.push(text::name(&member.name)),
            _ => return None,
        }
    }
    let known = |name: &String| {
        NAMES.contains(&name.as_str()) && names.iter().filter(|other| *other == name).count() == 1
    };
    if !names.iter().all(known)
        || NAMES[..3]
            .iter()
            .any(|axis| !names.iter().any(|name| name == axis))
    {
        return None;
    }
    let columns: Result<Vec<Vec<f64>>, String> = members.iter().map(numbers).collect();
    Some(columns.and_then(|columns| {
        let mut row = Vec::with_capacity(names.len());
        for i in 0..rows as usize {
            row.clear();
            for numbers in &columns {
                let width = numbers.len() / rows as usize;
                row.extend_from_slice(&numbers[i * width..][..width]);
            }
            each(&Row {
                names: Some(&names),
                numbers: &row,
                digits: None,
            })
            .map_err(|error| format!("row {i}: {error}"))?;
        }
        Ok(())
    }))
}

/// Returns all numbers of a member, row by row.
fn numbers(member: &Member) -> Result<Vec<f64>, String> {
    let mut numbers = Vec::new();
    let mut keep = |row: &Row| {
        numbers.extend_from_slice(row.numbers);
        Ok(())
    };
    let told = |error: String| format!("its array {}: {error}", member.name);
    if let &[n] = member.shape.as_slice() {
        // A column is a table of width 1.
        let mut bytes = Cursor::new(&member.bytes);
        let header = NpyHeader::from_reader(&mut bytes).map_err(|error| error.to_string())?;
        let column = columns(&header.dtype()).map_err(told)?.swap_remove(0);
        let data = &member.bytes[bytes.position() as usize..];
        if data.len() as u64 != n * column.size as u64 {
            return Err(told("its size is not what its shape says".to_owned()));
        }
        return Ok(data
            .chunks_exact(column.size.max(1))
            .map(column.number)
            .collect());
    }
    array(
        member.bytes.as_slice(),
        member.bytes.len() as u64,
        &mut keep,
    )
    .map_err(told)?;
    Ok(numbers)
}
