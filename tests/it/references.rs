//! Pure functions against reference values of 25 digits.

use approx::assert_relative_eq;
use whitefurnace::bsdf::OrenNayar;
use whitefurnace::fresnel::{reflectance, reflectance_p, reflectance_s};
use whitefurnace::trials::bsdf::{oren_nayar_albedo, oren_nayar_printed_albedo};
use whitefurnace::trials::fresnel::walsh;

use crate::support::{number, rows};

#[test]
fn closed_forms_of_oren_nayar_albedo() {
    for row in rows(include_str!("data/oren_nayar.csv")) {
        let constants = OrenNayar::new(number(row[0]));
        let t = number(row[1]).to_radians();
        assert_relative_eq!(
            oren_nayar_albedo(constants, t),
            number(row[2]),
            max_relative = 1e-12
        );
        assert_relative_eq!(
            oren_nayar_printed_albedo(constants, t),
            number(row[3]),
            max_relative = 1e-12
        );
    }
}

#[test]
fn fresnel_reflectances() {
    for row in rows(include_str!("data/fresnel.csv")) {
        let [n1, n2, cos] = [0, 1, 2].map(|i| number(row[i]));
        // At the critical angle 1 − R ≈ 4 (n₁/n₂) cos θ₂/cos θ₁, and cos θ₂ = 0 is known to √(4ε) only.
        let tolerance = if row[3] == "critical" {
            4.0 * (n1 / n2) * (4.0 * f64::EPSILON).sqrt() / cos
        } else {
            1e-11
        };
        let found = [reflectance_s, reflectance_p, reflectance].map(|r| r(cos, n1, n2));
        for (found, expected) in found.iter().zip([4, 5, 6].map(|i| number(row[i]))) {
            assert!(
                (found - expected).abs() <= tolerance,
                "{found}, should be {expected}: {row:?}"
            );
        }
    }
}

#[test]
fn hemispherical_reflectances() {
    for row in rows(include_str!("data/fresnel_average.csv")) {
        let n = number(row[0]);
        assert_relative_eq!(walsh(n), number(row[1]), max_relative = 1e-10);
        let inside = 1.0 - (1.0 - walsh(n)) / (n * n);
        assert_relative_eq!(inside, number(row[2]), max_relative = 1e-11);
    }
}
