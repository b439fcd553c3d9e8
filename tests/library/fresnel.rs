//! Tests of equations (10)-(12) and of refraction.

use whitefurnace::material::fresnel::{
    reflectance, reflectance_p, reflectance_s, refract, squared_cos_refracted,
};

use crate::prelude::*;
use crate::reference;

/// Bound on the error of cos θ₂: its square is off by 4 U (1 + ρ²), ρ = n₁/n₂, from seven roundings
/// and that of cos θ₁; the root divides that by 2 cos θ₂, and the error is at most the root of the
/// square's.
fn cosine_error(cos_2: f64, n1: f64, n2: f64) -> f64 {
    let square = 4.0 * UNIT_ROUNDOFF * (1.0 + (n1 / n2).powi(2));
    (square / (2.0 * cos_2)).min(square.sqrt()) + UNIT_ROUNDOFF * cos_2
}

/// Bound on the errors of R_s, R_p and R: |dR_s/dcos θ₂| ≤ 4 n₂/(n₁ cos θ₁ + n₂ cos θ₂), likewise
/// R_p, and 16 U for the other roundings.
fn reflectance_error(cos_1: f64, n1: f64, n2: f64) -> f64 {
    let cos_2 = squared_cos_refracted(cos_1, n1, n2).max(0.0).sqrt();
    let slope_s = 4.0 * n2 / (n1 * cos_1 + n2 * cos_2);
    let slope_p = 4.0 * n1 / (n1 * cos_2 + n2 * cos_1);
    16.0 * UNIT_ROUNDOFF + slope_s.max(slope_p) * cosine_error(cos_2, n1, n2)
}

fn indices() -> impl Strategy<Value = (f64, f64)> {
    (1.0..3.0, 1.0..3.0)
}

#[test]
fn table_of_reference_values() {
    let rows = reference::fresnel();
    assert_eq!(rows.len(), 254);
    for [n1, n2, cos_1, rs, rp, r] in rows {
        let bound = reflectance_error(cos_1, n1, n2);
        let at = format!("n1 {n1}, n2 {n2}, cos {cos_1}, bound {bound:e}");
        let off = |found: f64, expected: f64| (found - expected).abs();
        assert!(off(reflectance_s(cos_1, n1, n2), rs) <= bound, "Rs: {at}");
        assert!(off(reflectance_p(cos_1, n1, n2), rp) <= bound, "Rp: {at}");
        assert!(off(reflectance(cos_1, n1, n2), r) <= bound, "R: {at}");
    }
}

#[test]
fn equal_indices_reflect_nothing() {
    property(
        "index-matched",
        500,
        &(0.01..=1.0, 1.0..3.0),
        |(cos_1, n)| {
            assert!(reflectance(cos_1, n, n) <= (cosine_error(cos_1, n, n) / cos_1).powi(2));
            // Except at exact grazing incidence, where no light enters and 0/0 must not occur.
            assert!(squared_cos_refracted(0.0, n, n) <= 0.0);
            for of in [reflectance_s, reflectance_p, reflectance] {
                assert_eq!(of(0.0, n, n), 1.0);
            }
        },
    );
}

#[test]
fn refraction_obeys_snell() {
    property(
        "Snell",
        2000,
        &(unit(), unit(), indices()),
        |(d, n, (n1, n2))| {
            let n = if d.dot(n) < 0.0 { n } else { -n };
            let sin_1 = d.cross(n).length();
            // Within 16 U of the critical angle rounding decides.
            let Some(t) = refract(d, n, n1, n2) else {
                assert!(
                    n1 * sin_1 > n2 * (1.0 - 16.0 * UNIT_ROUNDOFF),
                    "refracted light is lost"
                );
                return;
            };
            assert!(
                n1 * sin_1 < n2 * (1.0 + 16.0 * UNIT_ROUNDOFF),
                "past the critical angle"
            );
            assert_abs_diff_eq!(t.length(), 1.0, epsilon = 4.0 * UNIT_ROUNDOFF);
            assert!(t.dot(n) <= 0.0, "on the other side");
            // Snell's law with its plane: n₁ d × n = n₂ t × n. Both d and n are unit to 3 U, which
            // enters the square of cos θ₂ with the factor (1 + ρ²), and the normalisation of t with
            // half of it.
            let ratio = n1 / n2;
            assert!(
                (n1 * d.cross(n) - n2 * t.cross(n)).length()
                    <= 32.0 * UNIT_ROUNDOFF * (1.0 + ratio * ratio) * n1.max(n2)
            );
        },
    );
}
