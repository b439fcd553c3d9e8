//! Tests of reported pdfs by the samples alone. The distance from a sample to its nearest neighbour
//! says how dense the samples are there: Bickel and Breiman, "Sums of Functions of Nearest Neighbor
//! Distances, Moment Bounds, Limit Theorems and a Goodness of Fit Test", Annals of Probability
//! 11(1), 1983.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::neighbours::{extent, nearest_neighbours};
use super::{Precision, Rounding};
use crate::harness::domain::Domain;
use crate::harness::mean::{Values, mean};
use crate::harness::outcome::{Claim, Outcome};
use crate::math::moments::Moments;

/// Draws per block, if no other number is chosen.
const BLOCK: usize = 2048;
/// Levels of the tree of regions.
const LEVELS: usize = 3;
/// Number of regions of equal probability.
const REGIONS: usize = 1 << LEVELS;
/// Number of components of Neyman's smooth test of the uniform values.
const COMPONENTS: usize = 2;
/// Relative rounding of a reported pdf above which it is not judged.
const MAX_PDF_ROUNDING: f64 = 0.01;
/// Share of samples that may repeat another one of their block, beside those that rounding makes
/// equal.
const MAX_REPEATED: f64 = 1e-3;

/// Samples so far, each judged by its own reported pdf.
///
/// For a sample in a block of m draws let V be the solid angle nearer to it than its nearest
/// neighbour, and p the mean of its pdf there. If that is the density of the draws, m p V has mean
/// 1, and (1 − p V)^(m − 1) is uniform in [0, 1]. The mean is tested in regions of equal
/// probability, which the first block decides: a normalised pdf that is wrong is too high in some
/// and too low in others. Blocks are independent, samples of one are not. Samples near a jump of
/// the density, a share of about 1/√m of all, are misjudged, so claims have a margin. At the
/// horizon none are: neighbours and solid angles are taken on the sample's own side.
pub struct OwnPdfs {
    precision: Precision,
    block_size: usize,
    block: Vec<Draw>,
    regions: Option<Regions>,
    /// One more than the mean of m p V − 1 in a region.
    densities: [Values; REGIONS],
    /// Means of cos kπu over uniform values u, k from 1.
    components: [Values; COMPONENTS],
    /// Samples in blocks that were judged, those with a pdf that is exact enough, and those at the
    /// same place as another.
    kept: u64,
    judged: u64,
    repeated: u64,
    /// Expected excess of m p V by the rounding of directions.
    rounding: Moments,
    integrals: Option<Integrals>,
}

/// A draw: its direction and reported pdf, `None` for a lost sample.
type Draw = Option<Reported>;

#[derive(Clone, Copy)]
struct Reported {
    direction: DVec3,
    pdf: f64,
}

/// Regions of equal probability: a tree of planes across coordinate axes.
struct Regions {
    /// Plane i divides into those of 2i + 1 and 2i + 2.
    planes: [Plane; REGIONS - 1],
    /// Mean direction of the samples that decided each region.
    centres: [DVec3; REGIONS],
}

#[derive(Clone, Copy, Default)]
struct Plane {
    axis: usize,
    at: f64,
}

/// Means of g/pdf for functions g of the direction, which are their integrals over the domain.
struct Integrals {
    domain: Domain,
    values: [Values; INTEGRANDS.len()],
    /// Whether a pdf was rounded so much that its reciprocal says nothing.
    is_coarse: bool,
}

/// A function g of the direction.
struct Integrand {
    name: &'static str,
    g: fn(DVec3) -> f64,
    /// Its integral over the upper hemisphere.
    upper: f64,
}

/// Functions that fall with the cosine, as most pdfs do at most.
const INTEGRANDS: [Integrand; 4] = [
    Integrand {
        name: "integral of |z|",
        g: |w| w.z.abs(),
        upper: PI,
    },
    Integrand {
        name: "integral of z²",
        g: |w| w.z * w.z,
        upper: TAU / 3.0,
    },
    Integrand {
        name: "integral of |z|(1 + x)",
        g: |w| w.z.abs() * (1.0 + w.x),
        upper: PI,
    },
    Integrand {
        name: "integral of |z|(1 + y)",
        g: |w| w.z.abs() * (1.0 + w.y),
        upper: PI,
    },
];

impl OwnPdfs {
    /// Starts without samples, for numbers of this precision.
    pub fn new(precision: Precision) -> Self {
        Self {
            precision,
            block_size: BLOCK,
            block: Vec::with_capacity(BLOCK),
            regions: None,
            densities: [Values::new(1.0); REGIONS],
            components: [Values::new(0.0); COMPONENTS],
            kept: 0,
            judged: 0,
            repeated: 0,
            rounding: Moments::default(),
            integrals: None,
        }
    }

    /// Starts without samples of a pdf that is positive over a whole domain,
    /// [`Domain::Hemisphere`] or [`Domain::Sphere`]: integrals over it are tested as well, as
    /// means of g/pdf.
    pub fn covering(precision: Precision, domain: Domain) -> Self {
        Self {
            integrals: Some(Integrals {
                domain,
                values: INTEGRANDS.map(|integrand| Values::new(integrand.upper)),
                is_coarse: false,
            }),
            ..Self::new(precision)
        }
    }

    /// Takes blocks of this many draws, 64 or more, before the first sample. Small blocks need
    /// fewer samples for a verdict, but have wider gaps between samples, over which a density that
    /// is not smooth changes.
    pub fn with_block_size(mut self, block_size: usize) -> Self {
        self.block_size = block_size.max(8 * REGIONS);
        self
    }

    /// Adds a sample: a unit vector, `None` if it was lost, and its reported pdf with respect to
    /// solid angle, 1/sr. Samples must be independent: low-discrepancy points keep distances.
    pub fn push(&mut self, direction: Option<DVec3>, pdf: f64) {
        let draw = direction.map(|direction| Reported {
            direction: direction.normalize(),
            pdf,
        });
        let is_coarse = draw.is_some_and(|draw| is_coarse(&self.precision, draw.pdf));
        if let Some(integrals) = &mut self.integrals {
            integrals.is_coarse |= is_coarse;
            for (values, Integrand { g, .. }) in integrals.values.iter_mut().zip(INTEGRANDS) {
                values.push(draw.map_or(0.0, |draw| g(draw.direction) / draw.pdf));
            }
        }
        self.block.push(draw);
        if self.block.len() == self.block_size {
            self.judge_block();
            self.block.clear();
        }
    }

    fn judge_block(&mut self) {
        let kept: Vec<Reported> = self.block.iter().copied().flatten().collect();
        let Some(regions) = &self.regions else {
            self.regions = Regions::new(&kept);
            return;
        };
        let directions: Vec<DVec3> = kept.iter().map(|draw| draw.direction).collect();
        let draws = self.block_size as f64;
        // Two independent errors, uniform within the rounding, in each tangent direction.
        let error = self.precision.direction.half_width(0.75);
        let (mut densities, mut components) = ([0.0; REGIONS], [0.0; COMPONENTS]);
        for (&Reported { direction, pdf }, neighbour) in
            kept.iter().zip(nearest_neighbours(&directions))
        {
            self.kept += 1;
            self.repeated += u64::from(neighbour.square == 0.0);
            if is_coarse(&self.precision, pdf) {
                continue;
            }
            self.judged += 1;
            let between = mean_between(pdf, kept[neighbour.index].pdf);
            let probability = between * cap_on_own_side(direction.z, neighbour.square);
            densities[regions.of(direction)] += draws * probability - 1.0;
            let uniform = (1.0 - probability.min(1.0)).powf(draws - 1.0);
            for (component, k) in components.iter_mut().zip(1..) {
                *component += (f64::from(k) * PI * uniform).cos();
            }
            self.rounding
                .push(draws * pdf * PI * 4.0 / 3.0 * error * error);
        }
        let per_region = draws / REGIONS as f64;
        for (values, sum) in self.densities.iter_mut().zip(densities) {
            values.push(1.0 + sum / per_region);
        }
        for (values, sum) in self.components.iter_mut().zip(components) {
            values.push(sum / draws);
        }
    }

    /// Returns the outcomes: the mean of m p V in each region, the components of the smooth test,
    /// and the integrals, if the domain is covered. `margin`, in (0, 1), is how far the mean of the
    /// pdf in a region and the integrals may be off, relative.
    pub fn outcomes(&self, margin: f64) -> Vec<Outcome> {
        let claim = Claim::Equivalent { margin };
        let regions = self.regions.as_ref();
        let centres = regions.map_or([DVec3::ZERO; REGIONS], |regions| regions.centres);
        let densities = self.densities.iter().zip(centres).zip(1..);
        let densities = densities.map(|((values, centre), k)| {
            let mut outcome = mean(&format!("pdf in region {k}"), values, 1.0, claim);
            let [x, y, z] = centre.to_array();
            outcome.worst += &format!("; the region is around ({x:.2}, {y:.2}, {z:.2})");
            outcome
        });
        let components = self.components.iter().zip(1..).map(|(values, k)| {
            let name = format!("component {k} of the distances");
            mean(&name, values, 0.0, claim)
        });
        let outcomes = densities
            .chain(components)
            .map(|outcome| self.checked(self.in_draws(outcome), margin));
        outcomes
            .chain([self.repeated()])
            .chain(self.integral_outcomes(margin))
            .collect()
    }

    /// Counts draws in place of blocks in an outcome.
    fn in_draws(&self, mut outcome: Outcome) -> Outcome {
        let scale = |outcome: &mut Outcome| {
            for count in [&mut outcome.n, &mut outcome.valid_from] {
                *count = count.saturating_mul(self.block_size as u64);
            }
        };
        scale(&mut outcome);
        outcome
            .graded
            .iter_mut()
            .for_each(|graded| scale(&mut graded.outcome));
        outcome
    }

    /// Makes an outcome undecided that the rounding of numbers may have brought about.
    fn checked(&self, outcome: Outcome, margin: f64) -> Outcome {
        if self.judged < self.kept / 2 || self.excess() > 0.25 * margin {
            return outcome.undecided("the numbers are too coarse for this density", u64::MAX);
        }
        outcome
    }

    /// Returns the expected relative excess of m p V by the rounding of directions.
    fn excess(&self) -> f64 {
        if self.rounding.count() > 0 {
            self.rounding.mean()
        } else {
            0.0
        }
    }

    /// Returns the outcome of directions that are equal, of which a density has none.
    fn repeated(&self) -> Outcome {
        let share = self.repeated as f64 / self.kept.max(1) as f64;
        let found = format!("{} of {} samples repeat another", self.repeated, self.kept);
        let tolerance = MAX_REPEATED + self.excess();
        Outcome::identity("repeated directions", self.kept, share, tolerance, found)
    }

    fn integral_outcomes(&self, margin: f64) -> Vec<Outcome> {
        let Some(integrals) = &self.integrals else {
            return Vec::new();
        };
        let is_sphere = integrals.domain == Domain::Sphere;
        let hemispheres = if is_sphere { 2.0 } else { 1.0 };
        let outcome = |values: &Values, Integrand { name, upper, .. }: Integrand| {
            let reference = upper * hemispheres;
            let moments = values.moments;
            let spread = moments.variance().sqrt() / reference;
            if integrals.is_coarse {
                let outcome = Outcome::identity(name, moments.count(), 0.0, margin, "");
                outcome.undecided("some pdfs are rounded by more than 1 %", u64::MAX)
            } else if moments.count() > 1 && spread <= self.constant_tolerance() {
                let (value, tolerance) = (moments.mean(), self.constant_tolerance());
                let error = (value / reference - 1.0).abs();
                let found = format!("every value is {value:e}, which should be {reference:e}");
                Outcome::identity(name, moments.count(), error, tolerance, found)
            } else {
                let delta = margin * reference;
                mean(name, values, reference, Claim::Equal { delta })
            }
        };
        let values = integrals.values.iter().zip(INTEGRANDS);
        values
            .map(|(values, integrand)| outcome(values, integrand))
            .collect()
    }

    /// Relative variation up to which values are equal but for rounding.
    fn constant_tolerance(&self) -> f64 {
        if [self.precision.direction, self.precision.pdf] == [Rounding::DOUBLE; 2] {
            1e-9
        } else {
            1e-5
        }
    }
}

/// Returns whether a pdf is rounded so much that it is not judged.
fn is_coarse(precision: &Precision, pdf: f64) -> bool {
    let Rounding {
        absolute, relative, ..
    } = precision.pdf;
    // A bound of the half-width, which itself takes a logarithm.
    let most = absolute.max(1.001 * relative * pdf);
    most > MAX_PDF_ROUNDING * pdf && precision.pdf.half_width(pdf) > MAX_PDF_ROUNDING * pdf
}

impl Regions {
    /// Divides at medians; `None` for fewer than four samples per region.
    fn new(samples: &[Reported]) -> Option<Self> {
        if samples.len() < 4 * REGIONS {
            return None;
        }
        let mut directions: Vec<DVec3> = samples.iter().map(|draw| draw.direction).collect();
        let mut regions = Self {
            planes: [Plane::default(); REGIONS - 1],
            centres: [DVec3::ZERO; REGIONS],
        };
        regions.divide(0, &mut directions);
        Some(regions)
    }

    fn divide(&mut self, node: usize, directions: &mut [DVec3]) {
        let Some(plane) = self.planes.get_mut(node) else {
            let sum: DVec3 = directions.iter().sum();
            self.centres[node - self.planes.len()] = sum.normalize_or_zero();
            return;
        };
        let [low, high] = extent(directions);
        let (axis, middle) = ((high - low).max_position(), directions.len() / 2);
        directions.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
        *plane = Plane {
            axis,
            at: directions[middle][axis],
        };
        let (below, above) = directions.split_at_mut(middle);
        self.divide(2 * node + 1, below);
        self.divide(2 * node + 2, above);
    }

    /// Returns the region of a direction.
    fn of(&self, direction: DVec3) -> usize {
        let node = (0..LEVELS).fold(0, |node, _| {
            let Plane { axis, at } = self.planes[node];
            2 * node + 1 + usize::from(direction[axis] >= at)
        });
        node - self.planes.len()
    }
}

/// Returns an estimate of the mean of a pdf over the directions nearer than the nearest neighbour,
/// from its values at both ends.
///
/// With the gradient g and the Laplacian l of the density p, the mean over a disc of radius r is
/// p + l r²/8. The neighbour is found where the density is high, so that its density has the mean
/// p + l r²/4 + g² r²/(2p); of all power means of both ends, that of the exponent −3 has no error
/// in r².
fn mean_between(here: f64, at_neighbour: f64) -> f64 {
    let ratio = here / at_neighbour;
    here * (0.5 * (1.0 + ratio * ratio * ratio)).cbrt().recip()
}

/// Returns the solid angle, sr, of the directions whose squared distance from a direction of
/// height z, as unit vectors, is below `square`, on its side of the horizon.
///
/// A cap of angular radius α around a direction at the angle θ from the pole has
/// 2π(1 − cos α); the part of it above the horizon, where it crosses that, is
/// 2(π − acos(cos θ/sin α) − cos α acos(−cot θ cot α)): Tovchigrechko and Vakser, "How Common Is
/// the Funnel-like Energy Landscape in Protein-Protein Interactions?", Protein Science 10(8), 2001.
pub fn cap_on_own_side(z: f64, square: f64) -> f64 {
    let z = z.abs().min(1.0);
    // The distance is 2 sin α/2.
    let square = square.min(4.0);
    let cos = 1.0 - 0.5 * square;
    let sin = (square * (1.0 - 0.25 * square)).sqrt();
    if z >= sin {
        // Beyond a right angle the cap holds the whole hemisphere.
        return if cos >= 0.0 { PI * square } else { TAU };
    }
    let horizontal = (1.0 - z * z).sqrt();
    let first = (z / sin).acos();
    let second = (-z * cos / (horizontal * sin)).clamp(-1.0, 1.0).acos();
    2.0 * (PI - first - cos * second)
}
