//! Reference values, computed with 50 digits by closed forms and quadrature outside this project, and
//! the closed forms of the trials against them.

use std::f64::consts::FRAC_1_PI;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use glam::DVec3;
use whitefurnace::bsdf::OrenNayar;
use whitefurnace::harness::domain::Domain;
use whitefurnace::trials::bsdf::{oren_nayar_albedo, oren_nayar_printed_albedo};
use whitefurnace::trials::form_factors::{parallel, perpendicular};
use whitefurnace::trials::fresnel::walsh;
use whitefurnace::trials::scenes::{corners, polygon_irradiance};

/// The rows of a table in `data`: fields between commas; lines with # are remarks.
pub fn fields(table: &'static str) -> impl Iterator<Item = Vec<&'static str>> {
    table
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split(',').collect())
}

/// A number of a table.
pub fn number(text: &str) -> f64 {
    text.parse().expect("a number in a table")
}

/// The rows of a table of N numbers each.
fn rows<const N: usize>(table: &'static str) -> Vec<[f64; N]> {
    let row = |fields: Vec<&str>| {
        let numbers: Vec<f64> = fields.into_iter().map(number).collect();
        numbers.try_into().expect("a full row")
    };
    fields(table).map(row).collect()
}

/// n₁, n₂, cos θ₁, R_s, R_p, R.
pub fn fresnel() -> Vec<[f64; 6]> {
    rows(include_str!("data/fresnel.csv"))
}

/// n, average of R over the hemisphere from outside, from inside.
pub fn fresnel_average() -> Vec<[f64; 3]> {
    rows(include_str!("data/fresnel_average.csv"))
}

/// σ, θ in degrees, directional albedo of the corrected and of the printed form.
pub fn oren_nayar() -> Vec<[f64; 4]> {
    rows(include_str!("data/oren_nayar.csv"))
}

/// r, ρ, θ in degrees, directional albedo of EON: single scattering, both lobes.
pub fn eon() -> Vec<[f64; 5]> {
    rows(include_str!("data/eon.csv"))
}

/// σ, A, B, average albedo of the corrected and of the printed form.
pub fn oren_nayar_average() -> Vec<[f64; 5]> {
    rows(include_str!("data/oren_nayar_average.csv"))
}

#[test]
fn closed_forms_of_oren_nayar_albedo() {
    for [sigma, degrees, corrected, printed] in oren_nayar() {
        let (constants, theta) = (OrenNayar::new(sigma), degrees.to_radians());
        let found = oren_nayar_albedo(constants, theta);
        assert_relative_eq!(found, corrected, max_relative = 1e-12);
        let found = oren_nayar_printed_albedo(constants, theta);
        assert_relative_eq!(found, printed, max_relative = 1e-12);
    }
}

#[test]
fn hemispherical_reflectances() {
    for [n, outside, inside] in fresnel_average() {
        assert_relative_eq!(walsh(n), outside, max_relative = 1e-10);
        let found = 1.0 - (1.0 - walsh(n)) / (n * n);
        assert_relative_eq!(found, inside, max_relative = 1e-11);
    }
}

/// Between unit squares, opposite at distance 1 and at right angles with a common edge: the closed
/// forms, and quadrature of the irradiance over the lit square.
#[test]
fn form_factors_of_squares() {
    let quadrature = |light: [DVec3; 4]| {
        let irradiance = |p: DVec3| polygon_irradiance(&light.map(|vertex| vertex - p));
        FRAC_1_PI * Domain::Square.integrate_all(1e-9, &irradiance).value
    };
    let opposite = 0.199_824_895_698_387_4;
    assert_relative_eq!(parallel(1.0, 1.0), opposite, max_relative = 1e-14);
    let ceiling = corners(DVec3::new(0.5, 0.5, 1.0), 0.5);
    assert_abs_diff_eq!(quadrature(ceiling), opposite, epsilon = 1e-8);
    let adjacent = 0.200_043_776_075_403_1;
    assert_relative_eq!(perpendicular(1.0, 1.0), adjacent, max_relative = 1e-14);
    let wall = [DVec3::ZERO, DVec3::Y, DVec3::Y + DVec3::Z, DVec3::Z];
    assert_abs_diff_eq!(quadrature(wall), adjacent, epsilon = 1e-6);
    // Large plates see little but each other; factors are reciprocal by area.
    assert_relative_eq!(parallel(1e4, 1e4), 1.0, max_relative = 1e-3);
    let [there, back] = [perpendicular(2.0, 0.5), perpendicular(0.5, 2.0)];
    assert_relative_eq!(0.5 * there, 2.0 * back, max_relative = 1e-13);
}
