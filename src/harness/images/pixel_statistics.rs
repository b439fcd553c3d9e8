//! Welch's test of two images given by the statistics of independent pixels: the image mean, tiles
//! and pixels (Jung, Hanika and Dachsbacher, "Detecting Bias in Monte Carlo Renderers using Welch's
//! t-test", JCGT 9(2), 2020).
//!
//! Only the image mean carries a claim of equivalence: per-pixel tests are far less sensitive to a
//! bias that is the same everywhere.

use super::side::{grid, pixels_of};
use crate::harness::graded::grade;
use crate::harness::ks::kolmogorov_smirnov;
use crate::harness::mean::{Sigma, skewness_of_sum, welch_satterthwaite};
use crate::harness::outcome::{ALPHA, Cell, Claim, Outcome};
use crate::harness::power::Sensitivity;
use crate::harness::tails::{student_two_sided, student_upper};

/// One channel of an image with the statistics of each pixel, row by row. The count is that of
/// independent replications: whole grids where samples within a pixel are stratified.
#[derive(Clone, Copy, Debug)]
pub struct PixelStatistics<'a> {
    /// Mean of each pixel.
    pub mean: &'a [f64],
    /// Sample variance of one replication of each pixel.
    pub variance: &'a [f64],
    /// Number of replications of each pixel.
    pub count: &'a [u64],
}

/// Map of p-values.
#[derive(Clone, Debug, PartialEq)]
pub struct PValueMap {
    /// Number of tiles across.
    pub width: usize,
    /// Number of tiles down.
    pub height: usize,
    /// p-value of each tile, row by row; `None` where nothing is judged: neither image has any
    /// variance and both agree, or the tile was left out. NaN, where an image's mean or variance is
    /// NaN, fails.
    pub p: Vec<Option<f64>>,
    /// Difference of each tile's means in standard errors; NaN where nothing is judged.
    pub sigmas: Vec<f64>,
    /// Degrees of freedom of each tile's difference.
    pub dof: Vec<f64>,
}

impl PValueMap {
    /// Iterates over the tiles that are judged, with their p-values.
    fn judged(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let tiles = self.p.iter().enumerate();
        tiles.filter_map(|(tile, p)| Some((tile, (*p)?)))
    }

    /// Counts the p-values in `bins` equal bins of [0, 1]: flat if there is no bias. NaN counts
    /// as 0.
    pub fn histogram(&self, bins: usize) -> Vec<u64> {
        let mut counts = vec![0; bins];
        for (_, p) in self.judged() {
            counts[((p * bins as f64) as usize).min(bins - 1)] += 1;
        }
        counts
    }

    /// Tests by Kolmogorov-Smirnov whether the p-values are uniform. `delta` is the distance that
    /// would matter: the pixels' values are means of few samples, and only nearly normal.
    pub fn flatness(&self, name: &str, delta: f64) -> Outcome {
        let mut p: Vec<f64> = self.judged().map(|(_, p)| p).collect();
        let mut outcome = kolmogorov_smirnov(name, &mut p, |p| p, delta);
        outcome.claim = Claim::Equivalent { margin: delta };
        // Graded controls of the exact claim do not apply to this one.
        outcome.graded = Vec::new();
        outcome
    }

    /// Returns the smallest p-value times the number of tiles (Bonferroni), with the worst tile; no
    /// size of effect is claimed.
    pub fn smallest(&self, name: &str, n: u64) -> Outcome {
        let rank = |p: f64| if p.is_nan() { f64::NEG_INFINITY } else { p };
        let worst = self.judged().min_by(|a, b| rank(a.1).total_cmp(&rank(b.1)));
        let tests = self.judged().count();
        let Some((worst, p)) = worst else {
            return Self::none_judged(name, n);
        };
        Outcome {
            name: name.to_owned(),
            statistic: "Welch map",
            value: self.sigmas[worst],
            dof: None,
            // Unlike `min`, this keeps NaN.
            p: (p * tests as f64).clamp(0.0, 1.0),
            n,
            valid_from: 2,
            estimate: self.sigmas[worst],
            reference: 0.0,
            interval: [self.sigmas[worst]; 2],
            claim: Claim::Test,
            // An effect on the worst tile, in its standard errors.
            sensitivity: Sensitivity::Normal {
                standard_error: 1.0,
                dof: self.dof[worst],
                tests: tests.max(1),
            },
            worst: format!(
                "({}, {}) of {} × {}: {:+.2} sigmas",
                worst % self.width,
                worst / self.width,
                self.width,
                self.height,
                self.sigmas[worst]
            ),
            cells: self.cells(),
            graded: Vec::new(),
        }
    }

    /// Returns the outcome of a map without a judged tile.
    fn none_judged(name: &str, n: u64) -> Outcome {
        Outcome {
            statistic: "Welch map",
            claim: Claim::Test,
            sensitivity: Sensitivity::Normal {
                standard_error: f64::INFINITY,
                dof: f64::INFINITY,
                tests: 1,
            },
            ..Outcome::identity(name, n, 0.0, 0.0, "")
        }
        .undecided("no tile was judged", u64::MAX)
    }

    fn cells(&self) -> Vec<Cell> {
        (0..self.p.len())
            .map(|i| Cell {
                place: format!("x {} y {}", i % self.width, i / self.width),
                expected: 0.0,
                observed: self.sigmas[i],
                sigmas: self.sigmas[i],
            })
            .collect()
    }
}

/// Difference of the means of a set of pixels.
struct Difference {
    difference: f64,
    variance: f64,
    dof: f64,
}

impl Difference {
    /// Returns the difference in standard errors. Without any variance, 0/0 is no evidence (NaN)
    /// and x/0 is certain (infinite).
    fn sigmas(&self) -> f64 {
        self.difference / self.variance.sqrt()
    }
}

fn difference(a: &PixelStatistics, b: &PixelStatistics, pixels: &[usize]) -> Difference {
    let share = 1.0 / pixels.len() as f64;
    let part = |s: &PixelStatistics, i: usize| {
        (
            s.variance[i] / s.count[i] as f64 * share * share,
            s.count[i],
        )
    };
    let parts = || pixels.iter().flat_map(|&i| [part(a, i), part(b, i)]);
    Difference {
        difference: pixels.iter().map(|&i| a.mean[i] - b.mean[i]).sum::<f64>() * share,
        variance: parts().map(|(v, _)| v).sum(),
        dof: welch_satterthwaite(parts()),
    }
}

/// One channel of an image of independent pixels, with the skewness of their replications.
#[derive(Clone, Copy, Debug)]
pub struct ImageMoments<'a> {
    /// Mean, variance and count of each pixel.
    pub statistics: &'a PixelStatistics<'a>,
    /// Skewness of one replication of each pixel.
    pub skewness: &'a [f64],
}

/// Tests the means of two images: `delta` is relative to the mean of the second. The claim is
/// exact, as for two unbiased estimators; [`Outcome::as_equivalence`] makes it approximate.
pub fn image_mean(name: &str, a: ImageMoments, b: ImageMoments, delta: f64) -> Outcome {
    grade(compare_means(name, a, b, delta), |effect| {
        let mean: Vec<f64> = a.statistics.mean.iter().map(|x| x + effect).collect();
        let wrong = PixelStatistics {
            mean: &mean,
            ..*a.statistics
        };
        let wrong = ImageMoments {
            statistics: &wrong,
            ..a
        };
        Some(compare_means(name, wrong, b, delta))
    })
}

fn compare_means(name: &str, a: ImageMoments, b: ImageMoments, delta: f64) -> Outcome {
    let skewness = skewness_of_sum([a, b].into_iter().flat_map(|image| {
        let s = image.statistics;
        let part = |(i, &skewness): (usize, &f64)| {
            (skewness, s.variance[i] / s.count[i] as f64, s.count[i])
        };
        image.skewness.iter().enumerate().map(part)
    }));
    let (a, b) = (a.statistics, b.statistics);
    // Replications of the pixels that vary: a deterministic image needs no second one.
    let counts = |s: &PixelStatistics| -> Vec<u64> {
        let vary = s.variance.iter().zip(s.count);
        vary.filter(|(v, _)| **v > 0.0).map(|(_, n)| *n).collect()
    };
    let all = || a.count.iter().chain(b.count).copied().min();
    let n = counts(a).into_iter().chain(counts(b)).min();
    let n = n.or_else(all).unwrap_or(0);
    let pixels: Vec<usize> = (0..a.mean.len()).collect();
    let d = difference(a, b, &pixels);
    let scale = b.mean.iter().sum::<f64>() / b.mean.len() as f64;
    let standard_error = d.variance.sqrt();
    let t = if d.difference == 0.0 {
        0.0
    } else {
        d.difference / standard_error
    };
    let half = student_upper(ALPHA / 2.0, d.dof.max(1.0)) * standard_error;
    let outcome = Outcome {
        name: name.to_owned(),
        statistic: "Welch",
        value: t,
        dof: Some(d.dof),
        p: student_two_sided(t, d.dof),
        n,
        valid_from: Sigma::Estimated.valid_from(n, skewness, ALPHA),
        estimate: d.difference,
        reference: 0.0,
        interval: [d.difference - half, d.difference + half],
        claim: Claim::Equal {
            delta: delta * scale.abs(),
        },
        sensitivity: Sensitivity::Normal {
            standard_error,
            dof: d.dof,
            tests: 1,
        },
        worst: format!("image means differ by {t:+.2} standard errors"),
        cells: segments(a, b),
        graded: Vec::new(),
    };
    if outcome.n < 2 {
        outcome.undecided("fewer than two replications", 2)
    } else if standard_error == 0.0 && d.difference == 0.0 {
        outcome.undecided("no pixel varies", u64::MAX)
    } else {
        outcome
    }
}

/// Number of parts of an image kept for the data file of its mean.
const MAX_SEGMENTS: usize = 64;

/// Returns the means of consecutive pixels of the first image against the second's.
fn segments(a: &PixelStatistics, b: &PixelStatistics) -> Vec<Cell> {
    let pixels: Vec<usize> = (0..a.mean.len()).collect();
    let cell = |part: &[usize]| {
        let d = difference(a, b, part);
        let expected = part.iter().map(|&i| b.mean[i]).sum::<f64>() / part.len() as f64;
        Cell {
            place: format!("{} pixels from {} on, row by row", part.len(), part[0]),
            expected,
            observed: expected + d.difference,
            sigmas: d.sigmas(),
        }
    };
    let length = pixels.len().div_ceil(MAX_SEGMENTS).max(1);
    pixels.chunks(length).map(cell).collect()
}

/// Tests square tiles of `tile` × `tile` pixels, 1 for pixels, and returns their p-values. Tiles at
/// the right and lower border may be smaller.
pub fn welch_map(a: &PixelStatistics, b: &PixelStatistics, width: usize, tile: usize) -> PValueMap {
    let ([across, down], tiles) = grid([width, a.mean.len() / width], [tile; 2]);
    let tiles: Vec<Difference> = tiles
        .iter()
        .map(|tile| difference(a, b, &pixels_of(width, tile).collect::<Vec<usize>>()))
        .collect();
    let p = |d: &Difference| {
        let is_degenerate = d.difference == 0.0 && d.variance == 0.0;
        (!is_degenerate).then(|| student_two_sided(d.sigmas(), d.dof))
    };
    PValueMap {
        width: across,
        height: down,
        p: tiles.iter().map(p).collect(),
        sigmas: tiles.iter().map(Difference::sigmas).collect(),
        dof: tiles.iter().map(|d| d.dof).collect(),
    }
}
