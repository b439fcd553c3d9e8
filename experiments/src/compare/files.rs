//! Reads the images that are compared, and checks that they can be.

use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};
use whitefurnace::error::Error;
use whitefurnace::harness::images::MIN_NOISELESS_VALUES;
use whitefurnace::image::provenance;
use whitefurnace::image::read::{ChannelKind, LoadedImage, decode};

/// An image and its file.
pub(super) struct Input {
    pub path: PathBuf,
    /// SHA-256 of the file.
    pub digest: String,
    pub picture: LoadedImage,
    /// Provenance that `render` wrote, if it made the image.
    pub provenance: Option<String>,
}

impl Input {
    /// Returns true if a standard error of its pixels is above 0.
    pub fn has_noise(&self) -> bool {
        let mut errors = self.picture.standard_errors.iter().flatten().flatten();
        errors.any(|error| *error > 0.0)
    }
}

/// Returns the number of images in words.
pub(super) fn count(inputs: &[Input]) -> String {
    match inputs {
        [one] => one.path.display().to_string(),
        several => format!("{} images", several.len()),
    }
}

/// A layer given by an option, and the option's name for messages.
pub(super) struct Layer {
    pub name: Option<String>,
    pub option: &'static str,
}

/// Reads the files that match these names and patterns.
pub(super) fn read(option: &str, patterns: &[String], layer: &Layer) -> Result<Vec<Input>, Error> {
    let mut inputs = Vec::new();
    for pattern in patterns {
        // A file may be called `a[1].exr`.
        if Path::new(pattern).is_file() {
            inputs.push(read_one(Path::new(pattern), layer)?);
            continue;
        }
        let input_error = |error: String| Error::Option(format!("{option} {pattern}: {error}"));
        let mut paths = glob::glob(pattern)
            .map_err(|error| input_error(error.to_string()))?
            .peekable();
        if paths.peek().is_none() {
            return Err(input_error("no such file".to_owned()));
        }
        for path in paths {
            inputs.push(read_one(
                &path.map_err(|error| input_error(error.to_string()))?,
                layer,
            )?);
        }
    }
    Ok(inputs)
}

/// Reads one file.
pub(super) fn read_one(path: &Path, layer: &Layer) -> Result<Input, Error> {
    let bytes = std::fs::read(path).map_err(Error::file("read", path))?;
    let digest = Sha256::digest(&bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let picture = decode(path, &bytes, layer.name.as_deref(), layer.option)?;
    if bytes.starts_with(b"#?") {
        let path = path.display();
        return Err(Error::Option(format!(
            "{path} has eight bits a value, too few to judge: write EXR or PFM"
        )));
    }
    Ok(Input {
        path: path.to_owned(),
        digest,
        picture,
        provenance: provenance(&bytes),
    })
}

/// Lists which channels were read from the images of a side, each combination once.
pub(super) fn readings(inputs: &[Input]) -> String {
    let mut all: Vec<String> = Vec::new();
    for input in inputs {
        let reading = input.picture.describe();
        if !all.contains(&reading) {
            all.push(reading);
        }
    }
    all.join("; or ")
}

/// Returns an error that names two files.
fn pair_error<T>(one: &Input, other: &Input, what: &str) -> Result<T, Error> {
    Err(Error::Option(format!(
        "{} and {} {what}",
        one.path.display(),
        other.path.display()
    )))
}

/// Crops all images to the part of the frame that they have in common, if they differ in it.
///
/// # Errors
/// If they have no part in common, or differ and `common` is not asked for.
pub(super) fn crop_to_common(a: &mut [Input], b: &mut [Input], common: bool) -> Result<(), Error> {
    let frame = |p: &LoadedImage| (p.size, p.corner);
    let first = &a[0];
    let Some(other) = a
        .iter()
        .chain(&*b)
        .find(|input| frame(&input.picture) != frame(&first.picture))
    else {
        return Ok(());
    };
    let [left, top] = [0, 1].map(|i| {
        a.iter()
            .chain(&*b)
            .map(|input| i64::from(input.picture.corner[i]))
            .max()
    });
    let [right, bottom] = [0, 1].map(|i| {
        let end = |input: &Input| i64::from(input.picture.corner[i]) + input.picture.size[i] as i64;
        a.iter().chain(&*b).map(end).min()
    });
    let side = |low: Option<i64>, high: Option<i64>| {
        (high? - low?)
            .try_into()
            .ok()
            .filter(|side: &usize| *side > 0)
    };
    let words = |size: [usize; 2], corner: [i32; 2]| {
        format!(
            "{} × {} at ({}, {})",
            size[0], size[1], corner[0], corner[1]
        )
    };
    let frames = |what: &str| {
        let [one, two] =
            [first, other].map(|input| words(input.picture.size, input.picture.corner));
        pair_error(
            first,
            other,
            &format!("differ in size or place: {one}, {two}{what}"),
        )
    };
    let (Some(width), Some(height)) = (side(left, right), side(top, bottom)) else {
        return frames("; no pixel is common to all");
    };
    let (size, corner) = (
        [width, height],
        [left, top].map(|edge| edge.unwrap_or_default() as i32),
    );
    if !common {
        let moved = first.picture.corner != other.picture.corner;
        let place = if moved {
            "; --ignore-place lays their upper left pixels on one another"
        } else {
            ""
        };
        return frames(&format!(
            "; --common judges the part that all have, {}{place}",
            words(size, corner)
        ));
    }
    for input in a.iter_mut().chain(b) {
        input.picture = input.picture.cropped(corner, size);
    }
    Ok(())
}

/// Refuses images that cannot be compared: different channels, different primaries, or the same
/// noise twice.
pub(super) fn check(a: &[Input], b: &[Input]) -> Result<(), Error> {
    let all: Vec<&Input> = a.iter().chain(b).collect();
    for (i, input) in all.iter().enumerate() {
        let (picture, first) = (&input.picture, &all[0].picture);
        let any = picture.kind == ChannelKind::Three || first.kind == ChannelKind::Three;
        if picture.labels() != first.labels()
            && !(any && picture.channels.len() == first.channels.len())
        {
            return pair_error(
                all[0],
                input,
                &format!(
                    "are different images: {}; {}",
                    first.describe(),
                    picture.describe()
                ),
            );
        }
        if !picture.has_primaries(first.primaries) {
            let what = format!(
                "have different primaries, x, y of red, green, blue and white {:?}; {:?}: convert one, or mend its attribute \
                 chromaticities (without it they are those of Rec. 709)",
                first.primaries, picture.primaries
            );
            return pair_error(all[0], input, &what);
        }
        let real = |input: &Input| {
            input
                .path
                .canonicalize()
                .unwrap_or_else(|_| input.path.clone())
        };
        let is_same = |other: &&Input| {
            real(other) == real(input) && other.picture.channels == picture.channels
        };
        if all[..i].iter().any(is_same) {
            return Err(Error::Option(format!(
                "{} is given twice",
                input.path.display()
            )));
        }
    }
    for (first, second) in duplicates(&all) {
        if shares_noise(first, [a, b]) {
            let what = if first.digest == second.digest {
                "have the same bytes, one is a copy: each image needs a seed of its own"
            } else {
                "have the same pixels, a seed used twice: each image needs its own (or give an exact one as --reference)"
            };
            return pair_error(first, second, what);
        }
    }
    Ok(())
}

/// Makes one image of a side usable alone: by its standard errors, or as an image without noise if
/// all its pixels are equal.
///
/// # Errors
/// If it has neither.
pub(super) fn fill_standard_errors(option: &str, inputs: &mut [Input]) -> Result<(), Error> {
    let [Input { path, picture, .. }] = inputs else {
        return Ok(());
    };
    if picture.standard_errors.is_none() {
        if (picture.values[0].len() as f64) < MIN_NOISELESS_VALUES
            || !picture.values.iter().all(|plane| is_constant(plane))
        {
            return Err(Error::Option(format!(
                "{option} has one image, {}, without standard errors (channels stderr.R, ...): give two or more, at best \
                 four, or one as --reference",
                path.display()
            )));
        }
        picture.standard_errors = Some(
            picture
                .values
                .iter()
                .map(|plane| vec![0.0; plane.len()])
                .collect(),
        );
    }
    Ok(())
}

/// Returns the images whose pixels equal those of an earlier one, each with that earlier one.
fn duplicates<'a>(all: &[&'a Input]) -> Vec<(&'a Input, &'a Input)> {
    let earlier = |i: usize| {
        all[..i]
            .iter()
            .find(|other| other.picture.values == all[i].picture.values)
    };
    (0..all.len())
        .filter_map(|i| Some((*earlier(i)?, all[i])))
        .collect()
}

/// Returns true if a repeated image has noise, so that its copies are no independent evidence. It
/// has none if all its pixels are equal, or if the images of a side vary in at most a fraction
/// [`MAX_RARE_FRACTION`] of the pixels and this image has the majority's value there: rare events
/// without a hit.
fn shares_noise(image: &Input, sides: [&[Input]; 2]) -> bool {
    let planes = &image.picture.values;
    if image.has_noise() {
        return true;
    }
    if planes.iter().all(|plane| is_constant(plane)) {
        return false;
    }
    let (pixels, images) = (planes[0].len(), sides[0].len() + sides[1].len());
    let differ = |one: &Input, other: &Input, i: usize| {
        one.picture
            .values
            .iter()
            .zip(&other.picture.values)
            .any(|(one, other)| one[i] != other[i])
    };
    let varies = |i: usize| {
        sides
            .iter()
            .any(|side| side.iter().any(|input| differ(input, &side[0], i)))
    };
    let varying: Vec<usize> = (0..pixels).filter(|&i| varies(i)).collect();
    let is_odd = |i: usize| {
        2 * sides
            .into_iter()
            .flatten()
            .filter(|input| differ(input, image, i))
            .count()
            >= images
    };
    varying.len() as f64 > (MAX_RARE_FRACTION * pixels as f64).max(4.0)
        || varying.into_iter().any(is_odd)
}

/// Largest fraction of pixels that rare events may hit.
const MAX_RARE_FRACTION: f64 = 0.01;

/// Returns true if all values are equal.
fn is_constant(plane: &[f64]) -> bool {
    plane.iter().all(|value| *value == plane[0])
}

/// Returns a note if two images are equal without that being an error.
pub(super) fn note(a: &[Input], b: &[Input]) -> Option<String> {
    let all: Vec<&Input> = a.iter().chain(b).collect();
    let (first, second) = duplicates(&all)
        .into_iter()
        .find(|(first, second)| first.digest == second.digest)?;
    let (first, second) = (first.path.display(), second.path.display());
    Some(format!(
        "{first} and {second} have the same bytes: renders without noise, or one a copy of the other"
    ))
}
