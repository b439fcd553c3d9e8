//! Sets of colour images on trial by `compare`.

use whitefurnace::harness::images::{Comparison, Rules, Side, compare};

use crate::experiments::prelude::*;

/// An image: each channel row by row.
pub(super) type Planes = [Vec<f64>; 3];

/// Divides an image into its channels, given the radiance of a pixel.
pub(super) fn planes<P>(pixels: &[P], radiance: impl Fn(&P) -> DVec3) -> Planes {
    let plane = |channel| {
        pixels
            .iter()
            .map(|pixel| radiance(pixel)[channel])
            .collect()
    };
    [0, 1, 2].map(plane)
}

/// Returns the result of `compare` on two sets of images of this width.
pub(super) fn compare_planes(width: u32, sets: [&[Planes]; 2], rules: &Rules) -> Comparison {
    let sides = [0, 1, 2].map(|channel| {
        sets.map(|images| Side::Images(images.iter().map(|image| &image[channel][..]).collect()))
    });
    compare(width as usize, &sides, rules)
}
