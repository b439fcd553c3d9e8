//! The closed forms that trials compare with, against reference values and by other methods.

use std::f64::consts::{FRAC_1_PI, PI};

use approx::{assert_abs_diff_eq, assert_relative_eq};
use glam::DVec3;
use trials::bsdf::{oren_nayar_albedo, oren_nayar_printed_albedo};
use trials::cie::{parallel_corner, upright_corner};
use trials::form_factors::{parallel, perpendicular};
use trials::fresnel::walsh;
use trials::ggx::reflected;
use trials::manufactured::patch::{GLASS, METAL};
use trials::radiosity::{NEIGHBOURS, OPPOSITE};
use trials::references::cornell::{BY_EYE, by_eye};
use trials::references::squares;
use trials::scenes::{RECTANGLE, TRIANGLE, WALL, corners, polygon_irradiance, sphere_irradiance};
use whitefurnace::geometry::form_factor::polygon;
use whitefurnace::harness::domain::Domain;
use whitefurnace::material::OrenNayar;
use whitefurnace::material::ggx::Ggx;

use library_tests::reference::{oren_nayar, rows};

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

/// The average of R over the hemisphere from outside, from inside.
#[test]
fn hemispherical_reflectances() {
    for [n, outside, inside] in rows(include_str!("../library/data/fresnel_average.csv")) {
        assert_relative_eq!(walsh(n), outside, max_relative = 1e-10);
        let found = 1.0 - (1.0 - walsh(n)) / (n * n);
        assert_relative_eq!(found, inside, max_relative = 1e-11);
    }
}

/// At α = 1 facet normals are uniform, and light along the normal is reflected by 1 − ln 2.
#[test]
fn the_roughest_metal_reflects_a_third() {
    let metal = Ggx {
        reflectance: DVec3::ONE,
        alpha: 1.0,
    };
    assert_abs_diff_eq!(reflected(metal, DVec3::Z), 1.0 - 2f64.ln(), epsilon = 1e-7);
}

/// Form factors of unit squares, opposite at distance 1 and at right angles with a common edge: the
/// closed forms, and quadrature of the irradiance over the lit square.
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

/// Compares the closed forms of rectangles with Lambert's formula and quadrature.
#[test]
fn rectangles_agree_with_lambert_and_with_quadrature() {
    let (a, b, c) = (1.3, 0.7, 0.9);
    let flat = [[0.0, 0.0], [0.0, b], [a, b], [a, 0.0]].map(|[x, y]| DVec3::new(x, y, c));
    assert_abs_diff_eq!(
        parallel_corner(a, b, c),
        polygon(DVec3::Z, &flat),
        epsilon = 1e-14
    );
    let upright = [[0.0, 0.0], [0.0, a], [b, a], [b, 0.0]].map(|[y, z]| DVec3::new(c, y, z));
    assert_abs_diff_eq!(
        upright_corner(a, b, c),
        polygon(DVec3::Z, &upright),
        epsilon = 1e-14
    );
    let integrand = |p: DVec3| {
        let [y, z] = [b * p.x, a * p.y];
        c * z / (PI * (c * c + y * y + z * z).powi(2))
    };
    let quadrature = a * b * Domain::Square.integrate_all(1e-10, &integrand).value;
    assert_abs_diff_eq!(upright_corner(a, b, c), quadrature, epsilon = 1e-9);
}

/// Hottel's closed form for equal squares at the distance of their side, and the closure of a cube.
#[test]
fn the_plates_references_are_hottels() {
    let root = 2f64.sqrt();
    let bracket = (4.0f64 / 3.0).sqrt().ln() + 2.0 * root * (1.0 / root).atan() - PI / 2.0;
    assert_abs_diff_eq!(OPPOSITE, 2.0 / PI * bracket, epsilon = 1e-15);
    assert_abs_diff_eq!(4.0 * NEIGHBOURS + OPPOSITE, 1.0, epsilon = 1e-15);
}

/// Compares the references of the trials of scenes with quadrature over the light.
#[test]
fn polygon_and_sphere_irradiance_agree_with_quadrature() {
    // Light that arrives along y at the origin, from an emitter that faces it, over a domain
    // spanned by two edges.
    let over = |domain: Domain, [corner, first, last]: [DVec3; 3]| {
        let (a, b) = (first - corner, last - corner);
        let normal = a.cross(b).normalize();
        let f = |p: DVec3| {
            let y = corner + p.x * a + p.y * b;
            let direction = y.normalize();
            direction.z.max(0.0) * normal.dot(-direction).max(0.0) / y.length_squared()
        };
        domain.integrate_all(1e-9, &f).value * a.cross(b).length()
    };
    let [a, b, _, d] = RECTANGLE;
    let square = over(Domain::Square, [a, d, b]);
    assert_abs_diff_eq!(square, polygon_irradiance(&RECTANGLE), epsilon = 1e-7);
    assert_abs_diff_eq!(square, 0.752_274_688_454_107_5, epsilon = 1e-7);
    let [a, b, _, d] = WALL;
    let wall = over(Domain::Square, [a, b, d]);
    assert_abs_diff_eq!(wall, polygon_irradiance(&WALL), epsilon = 1e-7);
    let triangle = over(Domain::Triangle, TRIANGLE);
    assert_abs_diff_eq!(triangle, polygon_irradiance(&TRIANGLE), epsilon = 1e-7);
    // The solid angle of a sphere is a cone around the zenith with sin θ = R/d.
    let cone = PI * 0.25_f64.powi(2);
    assert_abs_diff_eq!(cone, sphere_irradiance(0.5, 2.0, 1.0), epsilon = 1e-15);
}

/// The light of all zones along a glossy lobe is that of an even field, an integral over facets.
#[test]
fn zones_of_a_glossy_lobe_sum_to_its_albedo() {
    for (patch, channel) in [(METAL, 0), (METAL, 1), (METAL, 2), (GLASS, 0)] {
        let [zones, facets] = patch.under_an_even_field(channel);
        assert_abs_diff_eq!(zones, facets, epsilon = 2e-5);
    }
}

/// The images of squares that Mitsuba keeps have the mean that their geometry gives.
#[test]
fn squares_fill_their_share_of_mitsubas_images() {
    for [found, closed_form] in squares() {
        assert_abs_diff_eq!(found, closed_form, epsilon = 3e-6);
    }
}

/// The measured reflectances of the Cornell box in red, green and blue are those in the book.
#[test]
fn reflectances_of_the_cornell_box_by_eye() {
    for (found, rounded) in by_eye().into_iter().zip(BY_EYE) {
        assert_abs_diff_eq!(found, DVec3::from_array(rounded), epsilon = 5e-4);
    }
}
