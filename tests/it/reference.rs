//! Reference values, computed with 50 digits by closed forms and quadrature outside this project.

/// Correctly rounded numbers of a table in `data`, row by row; lines with # are remarks.
pub fn rows<const N: usize>(table: &str) -> Vec<[f64; N]> {
    table
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| {
            let numbers: Vec<f64> = line
                .split_whitespace()
                .map(|x| x.parse().expect("a number"))
                .collect();
            numbers.try_into().expect("a full row")
        })
        .collect()
}

/// n₁, n₂, cos θ₁, R_s, R_p, R.
pub fn fresnel() -> Vec<[f64; 6]> {
    rows(include_str!("data/fresnel.txt"))
}

/// n, average of R over the hemisphere from outside, from inside.
pub fn fresnel_average() -> Vec<[f64; 3]> {
    rows(include_str!("data/fresnel_average.txt"))
}

/// σ, θ in degrees, directional albedo of the corrected and of the printed form.
pub fn oren_nayar() -> Vec<[f64; 4]> {
    rows(include_str!("data/oren_nayar.txt"))
}

/// r, ρ, θ in degrees, directional albedo of EON: single scattering, both lobes.
pub fn eon() -> Vec<[f64; 5]> {
    rows(include_str!("data/eon.txt"))
}

/// σ, A, B, average albedo of the corrected and of the printed form.
pub fn oren_nayar_average() -> Vec<[f64; 5]> {
    rows(include_str!("data/oren_nayar_average.txt"))
}
