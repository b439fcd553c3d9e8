//! Tests of areas of images: of each area, and of all of one kind.

use super::*;

/// One channel of one area of the images, compared.
#[derive(Clone, Copy, Debug)]
pub struct AreaTest {
    /// Area of the images.
    pub area: Area,
    /// Number of the channel.
    pub channel: usize,
    /// Means of the two sides.
    pub means: [f64; 2],
    /// Value that differences are relative to.
    pub scale: f64,
    /// Standard error of the difference.
    pub standard_error: f64,
    /// Degrees of freedom of the standard error.
    pub dof: f64,
    /// Skewness of the difference, and its value if the sides' did not cancel; NaN if unknown.
    pub skewness: [f64; 2],
    /// Difference in standard errors, minus possible rounding.
    pub sigmas: f64,
    /// Two-sided p-value, before Bonferroni; 1 where nothing varies, but 0 where
    /// [`MIN_CONSTANT_VALUES`] constants differ, and where any values differ in a channel without
    /// noise.
    pub p: f64,
    /// Whether its channel has no noise on either side: see [`MIN_NOISELESS_VALUES`].
    pub noiseless: bool,
    /// Largest relative difference that may be rounding.
    pub rounding: f64,
    /// Whether skewness leaves the tail at the level of its kind valid, or the difference is far.
    pub judged: bool,
    /// Whether the difference is so large that it stands in spite of skewness: see
    /// [`LARGE_DIFFERENCE_FACTOR`].
    pub is_large: bool,
}

impl AreaTest {
    /// Returns the relative difference.
    pub fn difference(&self) -> f64 {
        (self.means[0] - self.means[1]) / self.scale
    }

    /// Returns the interval of the relative difference at a two-sided level.
    pub fn interval(&self, level: f64) -> [f64; 2] {
        let half =
            student_upper(level / 2.0, self.dof.clamp(1.0, 1e9)) * self.standard_error / self.scale;
        [-1.0, 1.0].map(|side| self.difference() + side * (half + self.rounding))
    }

    /// Returns the smallest relative difference that would be detected at a level in other images
    /// like these, except with probability [`MISS_PROBABILITY`], averaged over the estimates of the
    /// standard error.
    pub fn minimum_detectable_effect(&self, level: f64) -> f64 {
        let estimates = if self.standard_error > 0.0 {
            smallest_effect_in_estimates(self.dof, level, MISS_PROBABILITY)
        } else {
            0.0
        };
        estimates * self.standard_error / self.scale + self.rounding
    }

    /// Returns whether the difference, if any, is within [`SINGLE_SUM_ERROR`].
    pub fn may_be_single_sums(&self) -> bool {
        (self.means[0] - self.means[1]).abs()
            <= SINGLE_SUM_ERROR * self.means[0].abs().max(self.means[1].abs())
    }

    /// Returns whether the area is evidence: images show noise here, or nowhere in the channel, or
    /// two constants differ beyond doubt.
    pub fn varies(&self) -> bool {
        self.standard_error > 0.0 || self.noiseless || self.p == 0.0
    }
}

/// Tests of one kind of area, channel by channel.
#[derive(Clone, Debug)]
pub struct AreaKind {
    /// Name of the kind.
    pub name: &'static str,
    /// Numbers across and down, where the areas are a grid.
    pub grid: [usize; 2],
    /// Tests of all areas of the kind.
    pub tests: Vec<AreaTest>,
    /// Level of each test.
    pub level: f64,
    /// Whether enough of the varying areas are judged.
    pub is_counted: bool,
}

impl AreaKind {
    /// Iterates over the areas that are judged.
    pub fn judged(&self) -> impl Iterator<Item = &AreaTest> {
        self.tests.iter().filter(|test| test.judged)
    }

    /// Returns the number of areas that vary.
    pub fn varying(&self) -> usize {
        self.tests.iter().filter(|test| test.varies()).count()
    }

    /// Returns whether an area differs.
    pub fn rejects(&self, test: &AreaTest) -> bool {
        (self.is_counted || test.is_large) && test.judged && test.p < self.level
    }

    /// Iterates over the areas that differ.
    pub fn rejected(&self) -> impl Iterator<Item = &AreaTest> {
        self.tests.iter().filter(|test| self.rejects(test))
    }
}
