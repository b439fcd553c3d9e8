//! Compares two sets of images by tiles and pixels. The skewness decides how far out the tail of a
//! tile's or pixel's test is valid. It is estimated from pilot images that the test does not use;
//! otherwise the selection of places would depend on the result.

use serde::{Deserialize, Serialize};
use whitefurnace::harness::images::{PValueMap, PixelStatistics, welch_map};

use super::SIZE;
use super::claims::{Case, Claim};
use crate::experiments::prelude::*;

const TILE: usize = 5;
/// Bins of a histogram of p-values.
const BINS: usize = 10;
/// One in this many images goes to the pilot, the rest to the test.
const PILOT_DIVISOR: u64 = 4;
/// Least fraction of tiles or pixels that must be judged for a statement about all.
const MIN_JUDGED_FRACTION: f64 = 0.5;

/// A tile or pixel: pilot values, which decide whether it is judged, and tested values.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct TileSamples {
    #[serde(with = "super::state")]
    pilot: Values,
    #[serde(with = "super::state")]
    tested: Values,
}

impl TileSamples {
    /// Returns true if the skewness of the pilot leaves the tail of the test valid at a level.
    fn valid_at(&self, level: f64) -> bool {
        self.pilot.moments.count() > 1
            && self.tested.moments.count() >= self.pilot.valid_from_at(level)
    }
}

/// Tiles and pixels of the images of one run.
#[derive(Serialize, Deserialize)]
pub(super) struct Maps {
    pilot: u64,
    images: u64,
    tiles: Vec<TileSamples>,
    pixels: Vec<TileSamples>,
}

impl Maps {
    /// Returns empty maps for this number of images.
    pub fn new(images: u64) -> Self {
        let pixels = (SIZE[0] * SIZE[1]) as usize;
        let empty = TileSamples {
            pilot: Values::new(1.0),
            tested: Values::new(1.0),
        };
        Self {
            pilot: images / PILOT_DIVISOR,
            images: 0,
            tiles: vec![empty; pixels / (TILE * TILE)],
            pixels: vec![empty; pixels],
        }
    }

    /// Adds an image; returns its mean.
    pub fn push(&mut self, image: &[DVec3]) -> f64 {
        let is_pilot = self.images < self.pilot;
        self.images += 1;
        let push = |place: &mut TileSamples, value| {
            if is_pilot {
                place.pilot.push(value);
            } else {
                place.tested.push(value);
            }
        };
        let width = SIZE[0] as usize;
        let mut tiles = vec![0.0; self.tiles.len()];
        for (i, (pixel, value)) in self.pixels.iter_mut().zip(image).enumerate() {
            let value = value.element_sum() / 3.0;
            push(pixel, value);
            tiles[i / width / TILE * (width / TILE) + i % width / TILE] += value;
        }
        for (tile, sum) in self.tiles.iter_mut().zip(&tiles) {
            push(tile, sum / (TILE * TILE) as f64);
        }
        tiles.iter().sum::<f64>() / image.len() as f64
    }
}

/// Returns the Welch map of the places that can be judged at a level, without the others, and the
/// number of judged places.
fn judged([a, b]: [&[TileSamples]; 2], width: usize, level: f64) -> (PValueMap, usize) {
    let table = |places: &[TileSamples]| {
        let column =
            |of: fn(&Moments) -> f64| places.iter().map(|p| of(&p.tested.moments)).collect();
        let count: Vec<u64> = places.iter().map(|p| p.tested.moments.count()).collect();
        (column(Moments::mean), column(Moments::variance), count)
    };
    let (ours, reference): (Table, Table) = (table(a), table(b));
    let [ours, reference] = [&ours, &reference].map(|(mean, variance, count)| PixelStatistics {
        mean,
        variance,
        count,
    });
    let mut map = welch_map(&ours, &reference, width, 1);
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        // NaN is not left out, but fails.
        let number = map.p[i].is_some_and(|p| !p.is_nan());
        if number && !(a.valid_at(level) && b.valid_at(level)) {
            map.p[i] = None;
            map.sigmas[i] = f64::NAN;
        }
    }
    let count = map.p.iter().flatten().count();
    (map, count)
}

/// Records the least p-value of the tiles, at `share` of the family-wise level. Where equality is
/// claimed and enough tiles are judged, it is a claim. Returns the map for drawing, and the
/// histogram of the pixels' p-values if enough of them are judged as far out as its first bin.
pub(super) fn note_map(
    run: &mut Run,
    case: &Case,
    [a, b]: [&Maps; 2],
    share: f64,
) -> (Map, Option<Vec<u64>>) {
    let enough = |count: usize, of: usize| count as f64 >= MIN_JUDGED_FRACTION * of as f64;
    let total = a.tiles.len();
    let (tiles, count) = judged(
        [&a.tiles, &b.tiles],
        SIZE[0] as usize / TILE,
        share / total as f64,
    );
    let (what, key) = (format!("{}, tiles", case.label()), case.key());
    run.number(&format!("{key}.tiles.judged"), count as f64);
    if enough(count, total) {
        let p = tiles.smallest("tiles", 2).p;
        run.number(&format!("{key}.tiles.p"), p);
        let value = format!("least p {p:.2e} after Bonferroni over {count} of {total}");
        if case.claim == Claim::Equal {
            run.claim(&what, value, p >= share);
        } else {
            run.note(&what, value);
        }
    } else {
        let least = 100.0 * MIN_JUDGED_FRACTION;
        run.note(
            &what,
            format!("undecided: skewness lets {count} of {total} be judged, not {least:.0} %"),
        );
    }
    let (pixels, count) = judged([&a.pixels, &b.pixels], SIZE[0] as usize, 1.0 / BINS as f64);
    run.number(&format!("{key}.pixels.judged"), count as f64);
    let histogram = enough(count, a.pixels.len()).then(|| pixels.histogram(BINS));
    (drawn(&name(case.estimator), tiles), histogram)
}

/// Draws where in the image an estimator differs from the path tracer.
fn drawn(estimator: &str, tiles: PValueMap) -> Map {
    let size = [tiles.width, tiles.height];
    Map {
        title: format!("{estimator} − mis"),
        axes: ["across (tiles)".into(), "up (tiles)".into()],
        ranges: size.map(|tiles| [0.0, tiles as f64]),
        size: size.map(|tiles| tiles as u32),
        values: tiles.sigmas,
        bound: 4.0,
        unit: "standard errors".into(),
    }
}

/// Means, variances and counts of tiles or pixels.
type Table = (Vec<f64>, Vec<f64>, Vec<u64>);
