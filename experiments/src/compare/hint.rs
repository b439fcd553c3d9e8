//! Guesses a systematic cause of a difference: pixels in another order or place, channels swapped,
//! a factor, a transfer curve.

use whitefurnace::harness::images::{self, Comparison, Rules};
use whitefurnace::harness::outcome::Verdict;
use whitefurnace::image::read::{ChannelKind, LoadedImage};

use super::sides;

/// A transformation that may have been applied to the images of one side.
#[derive(Clone, Copy, Debug)]
enum Transformation {
    UpsideDown,
    Mirrored,
    Turned,
    /// Rows and columns exchanged.
    Transposed,
    /// Moved by this many half pixels to the right and down. At half pixels the first side is
    /// replaced by the mean of the pixels around.
    Moved([isize; 2]),
    /// Moved like [`Moved`](Self::Moved), but at half pixels the second side is averaged.
    MovedFrom([isize; 2]),
    RedForBlue,
    Times(f64),
    /// Decoded from gamma 2.2 on this side.
    Gamma(usize),
    /// Decoded from sRGB on this side.
    Srgb(usize),
}

impl Transformation {
    /// Returns all changes that are possible for images of this size and number of channels.
    fn all(picture: &LoadedImage, factor: f64) -> Vec<Self> {
        let mut all = vec![
            Self::UpsideDown,
            Self::Mirrored,
            Self::Turned,
            Self::Times(factor),
        ];
        if picture.size[0] == picture.size[1] {
            all.push(Self::Transposed);
        }
        if picture.kind == ChannelKind::Rgb {
            all.push(Self::RedForBlue);
        }
        all.extend(
            [0, 1]
                .into_iter()
                .flat_map(|side| [Self::Gamma(side), Self::Srgb(side)]),
        );
        let steps = [-2, -1, 0, 1, 2].into_iter();
        let moves = steps
            .clone()
            .flat_map(|x| steps.clone().map(move |y| [x, y]));
        for step in moves
            .filter(|step| *step != [0, 0])
            .filter(|step| [0, 1].iter().all(|&i| picture.size[i] > 4 || step[i] == 0))
        {
            all.push(Self::Moved(step));
            if step.iter().any(|half| half % 2 != 0) {
                all.push(Self::MovedFrom(step));
            }
        }
        all
    }

    fn words(self) -> String {
        let side = |side: usize| ["first", "second"][side];
        match self {
            Self::UpsideDown => "the first is flipped upside down".to_owned(),
            Self::Mirrored => "the first is mirrored left to right".to_owned(),
            Self::Turned => "the first is turned by half a turn".to_owned(),
            Self::Transposed => "rows and columns of the first are exchanged".to_owned(),
            Self::RedForBlue => "red and blue of the first are swapped".to_owned(),
            Self::Times(factor) => format!("the first is multiplied by {factor:.5}"),
            Self::Gamma(k) => format!("the {} is decoded from gamma 2.2", side(k)),
            Self::Srgb(k) => format!("the {} is decoded from sRGB", side(k)),
            Self::Moved([x, y]) | Self::MovedFrom([x, y]) => {
                let by = |halves: isize, ways: [&str; 2]| match halves.abs() {
                    0 => None,
                    1 => Some(format!("half a pixel {}", ways[usize::from(halves > 0)])),
                    _ => Some(format!("one pixel {}", ways[usize::from(halves > 0)])),
                };
                let parts: Vec<String> = by(x, ["to the left", "to the right"])
                    .into_iter()
                    .chain(by(y, ["up", "down"]))
                    .collect();
                format!("the first is moved by {}", parts.join(" and "))
            }
        }
    }

    /// Returns an image of a side with this change applied.
    fn apply(self, picture: &LoadedImage, side: usize) -> LoadedImage {
        let [width, height] = picture.size;
        match (self, side) {
            (Self::UpsideDown, 0) => picture.remapped([width, height], |x, y| [x, height - 1 - y]),
            (Self::Mirrored, 0) => picture.remapped([width, height], |x, y| [width - 1 - x, y]),
            (Self::Turned, 0) => {
                picture.remapped([width, height], |x, y| [width - 1 - x, height - 1 - y])
            }
            (Self::Transposed, 0) => picture.remapped([width, height], |x, y| [y, x]),
            (Self::RedForBlue, 0) => {
                let mut swapped = picture.clone();
                swapped.values.swap(0, 2);
                swapped
                    .standard_errors
                    .iter_mut()
                    .for_each(|errors| errors.swap(0, 2));
                swapped
            }
            (Self::Times(factor), 0) => map_values(picture, |value| factor * value),
            (Self::Gamma(of), _) if of == side => {
                map_values(picture, |value| value.max(0.0).powf(2.2))
            }
            (Self::Srgb(of), _) if of == side => map_values(picture, srgb_to_linear),
            (Self::Moved(step), _) => shifted(picture, step, side == 0),
            (Self::MovedFrom(step), _) => shifted(
                picture,
                step.map(|halves| if side == 0 { halves } else { -halves }),
                side == 1,
            ),
            _ => picture.clone(),
        }
    }
}

/// Converts a value from sRGB to linear.
fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// Applies a function to all values, and scales their standard errors by its slope.
fn map_values(picture: &LoadedImage, change: impl Fn(f64) -> f64) -> LoadedImage {
    let mut result = picture.clone();
    for (channel, values) in result.values.iter_mut().enumerate() {
        for (i, value) in values.iter_mut().enumerate() {
            let before = *value;
            *value = change(before);
            if let Some(errors) = &mut result.standard_errors {
                let error = &mut errors[channel][i];
                *error = (change(before + *error) - *value).abs();
            }
        }
    }
    result
}

/// Returns the part of the image left when each direction of the step loses a pixel on both sides,
/// moved by half pixels if it `moves`. At half pixels the value is the mean of the neighbours.
fn shifted(picture: &LoadedImage, step: [isize; 2], moves: bool) -> LoadedImage {
    let size = [0, 1].map(|i| picture.size[i] - 2 * usize::from(step[i] != 0));
    let inner = step.map(|halves| isize::from(halves != 0));
    let at = |offset: [isize; 2]| {
        let [left, top] = [0, 1].map(|i| (inner[i] - if moves { offset[i] } else { 0 }) as usize);
        picture.remapped(size, |x, y| [x + left, y + top])
    };
    // Half a pixel lies between 0 and 1 pixels.
    let ends = step.map(|halves| {
        if halves % 2 == 0 {
            [halves / 2; 2]
        } else {
            [0, halves]
        }
    });
    let corners = [0, 1, 2, 3].map(|k| at([ends[0][k % 2], ends[1][k / 2]]));
    if !moves || step.iter().all(|halves| halves % 2 == 0) {
        let [corner, ..] = corners;
        return corner;
    }
    let mut result = corners[0].clone();
    for channel in 0..result.values.len() {
        for i in 0..result.values[channel].len() {
            result.values[channel][i] = corners
                .iter()
                .map(|corner| corner.values[channel][i])
                .sum::<f64>()
                / 4.0;
            if let Some(errors) = &mut result.standard_errors {
                let squares = corners
                    .iter()
                    .filter_map(|corner| corner.standard_errors.as_ref());
                // Each corner counts twice if only one direction moves by half pixels.
                let share = if step.iter().all(|halves| halves % 2 != 0) {
                    4.0
                } else {
                    8.0_f64.sqrt()
                };
                errors[channel][i] = squares
                    .map(|errors| errors[channel][i].powi(2))
                    .sum::<f64>()
                    .sqrt()
                    / share;
            }
        }
    }
    result
}

/// Returns the mean excess of the squared differences over the noise variance, relative to the
/// noise and a twentieth of the values.
fn residual(a: &LoadedImage, b: &LoadedImage) -> f64 {
    let errors = |picture: &LoadedImage, channel: usize, i: usize| {
        picture
            .standard_errors
            .as_ref()
            .map_or(0.0, |errors| errors[channel][i].powi(2))
    };
    let mut sum = 0.0;
    let mut count = 0.0;
    for channel in 0..a.values.len() {
        let (x, y) = (&a.values[channel], &b.values[channel]);
        let overall = y.iter().map(|value| value.abs()).sum::<f64>() / y.len() as f64;
        for i in 0..x.len() {
            let variance = errors(a, channel, i) + errors(b, channel, i);
            let scale =
                0.05 * (0.5 * (x[i].abs() + y[i].abs()) + 0.2 * overall) + f64::MIN_POSITIVE;
            sum += ((x[i] - y[i]).powi(2) - variance) / (variance + scale * scale);
            count += 1.0;
        }
    }
    sum / count
}

/// Describes the change that makes the sides agree, or nearly so, and the verdict of a comparison
/// after it. Of several it is the one with the smallest residual, if that is less than a quarter of
/// the original.
pub(super) fn hint(
    sides_of: [&[&LoadedImage]; 2],
    exact: bool,
    rules: &Rules,
    found: &Comparison,
) -> Option<String> {
    let pixels = &found.kinds[3];
    let count = pixels.grid[0] * pixels.grid[1];
    let mean = |side: usize| -> LoadedImage {
        let plane = |value: &dyn Fn(&images::AreaTest) -> f64| -> Vec<Vec<f64>> {
            pixels
                .tests
                .chunks(count)
                .map(|places| places.iter().map(value).collect())
                .collect()
        };
        // Standard error of the difference, half of its square on each side.
        let errors = plane(&|place| place.standard_error * 0.5_f64.sqrt());
        LoadedImage {
            values: plane(&|place| place.means[side]),
            standard_errors: Some(errors),
            ..sides_of[side][0].clone()
        }
    };
    let means = [mean(0), mean(1)];
    let total = |picture: &LoadedImage| picture.values.iter().flatten().sum::<f64>();
    let factor = total(&means[1]) / total(&means[0]);
    let before = residual(&means[0], &means[1]);
    let left = |change: &Transformation| {
        residual(&change.apply(&means[0], 0), &change.apply(&means[1], 1))
    };
    let tried = Transformation::all(&means[0], factor)
        .into_iter()
        .map(|change| (left(&change), change));
    let (least, best) = tried
        .filter(|(left, _)| left.is_finite())
        .min_by(|x, y| x.0.total_cmp(&y.0))?;
    if before <= 0.0 || least > before / 4.0 {
        return None;
    }
    let changed = [0, 1].map(|side| {
        sides_of[side]
            .iter()
            .map(|picture| best.apply(picture, side))
            .collect::<Vec<LoadedImage>>()
    });
    let pictures = changed
        .each_ref()
        .map(|side| side.iter().collect::<Vec<_>>());
    let rules = Rules {
        regions: Vec::new(),
        ..rules.clone()
    };
    let again = images::compare(
        pictures[0][0].size[0],
        &sides([&pictures[0], &pictures[1]], exact),
        &rules,
    );
    let what = match again.verdict {
        Verdict::Holds => "they agree when",
        Verdict::Undecided { .. } => "no difference remains when",
        Verdict::Fails => "most of the difference disappears when",
    };
    Some(format!("{what} {}", best.words()))
}
