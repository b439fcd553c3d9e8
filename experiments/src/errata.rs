//! The size of every finding in the report: closed forms, quadrature, and counts of the very functions
//! that stand for the printed text.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::DVec3;
use whitefurnace::bsdf::{OrenNayar, OrenNayarForm, oren_nayar_angles};
use whitefurnace::equation;
use whitefurnace::fresnel;
use whitefurnace::harness::quadrature::{Rectangle, integrate};
use whitefurnace::image::srgb;
use whitefurnace::rng::{seed_for, stream, uniform, uniform2};
use whitefurnace::sampling::{
    cosine_hemisphere_pdf, hemisphere_printed, sphere_zone, uniform_hemisphere_pdf,
};
use whitefurnace::shape::{Ray, moller_trumbore, sphere_distances, sphere_distances_printed};
use whitefurnace::trials::bsdf::{oren_nayar_albedo, oren_nayar_printed_albedo};
use whitefurnace::trials::roulette::variance;

use crate::lab::{Experiment, Lab};

/// Sizes of the findings.
pub const ERRATA: Experiment = Experiment {
    id: "errata",
    title: "what is wrong in the report, and by how much",
    version: 1,
    equations: &[
        &equation::TRIANGLE_SOLUTION,
        &equation::SPHERE_DISTANCE,
        &equation::FRESNEL_S,
        &equation::FRESNEL,
        &equation::OREN_NAYAR,
        &equation::ESTIMATOR,
        &equation::HEMISPHERE_THETA,
        &equation::HEMISPHERE_PHI,
        &equation::ROULETTE,
        &equation::PATH_LENGTH,
    ],
    run: |lab| {
        edges(lab);
        far_spheres(lab);
        glass(lab);
        oren_nayar(lab);
        one_number(lab);
        importance(lab);
        path_ends(lab);
        noise(lab);
        Ok(())
    },
};

/// σ of the rough surface, radians.
const SIGMA: f64 = 0.5;
/// The index of the report's glass.
const INDEX: f64 = 1.5;

/// (4): rays aimed at the common edge of two triangles.
fn edges(lab: &mut Lab) {
    let rays = lab.count(lab.by_tier(200_000, 5_000_000));
    let mut rng = stream(seed_for(lab.seed(), "errata edges"), 0, 0);
    let mut lost = 0u64;
    for _ in 0..rays {
        let mut point = || {
            let [x, y] = uniform2(&mut rng);
            DVec3::new(x, y, uniform(&mut rng)) * 2.0 - 1.0
        };
        let [a, b, c, d, from] = [point(), point(), point(), point(), point() * 5.0];
        let target = a + uniform(&mut rng) * (b - a);
        let ray = Ray::new(from, (target - from).normalize());
        // The two lie on different sides of the edge as the ray sees it, or the ray may rightly miss.
        let side = |p: DVec3| (b - a).cross(p - a).dot(ray.direction);
        let other = if side(c) * side(d) < 0.0 {
            d
        } else {
            2.0 * target - c
        };
        // Neighbours of a mesh run along their edge in opposite directions, from any corner.
        let mut neighbour = [b, a, other];
        neighbour.rotate_left((3.0 * uniform(&mut rng)) as usize);
        let met = [[a, b, c], neighbour].map(|t| moller_trumbore(&ray, t).is_some());
        lost += u64::from(met == [false, false]);
    }
    size(
        lab,
        "edge.lost",
        lost as f64 / rays as f64,
        "of rays aimed at a shared edge miss both triangles by (4)",
    );
}

/// (7): the printed root against the stable one, for a unit sphere at growing distance.
fn far_spheres(lab: &mut Lab) {
    let rays = lab.count(100_000);
    for exponent in [2, 4, 6] {
        let distance = 10f64.powi(exponent);
        let mut rng = stream(seed_for(lab.seed(), "errata sphere"), 0, exponent as u32);
        let mut worst = 0f64;
        for _ in 0..rays {
            let target = sphere_zone(uniform2(&mut rng), 0.9, [-0.9, 0.9]);
            let from = distance * sphere_zone(uniform2(&mut rng), 1.0, [-1.0, 1.0]);
            let ray = Ray::new(from, (target - from).normalize());
            let printed = sphere_distances_printed(&ray, DVec3::ZERO, 1.0);
            let stable = sphere_distances(&ray, DVec3::ZERO, 1.0);
            if let (Some(printed), Some(stable)) = (printed, stable) {
                worst = worst.max((printed[0] - stable[0]).abs());
            }
        }
        size(
            lab,
            &format!("sphere.error.1e{exponent}"),
            worst,
            "radii: the largest error of the printed (7) at that many radii, in double precision",
        );
    }
}

/// (10)-(12): the missing case, and what 1 − R is not.
fn glass(lab: &mut Lab) {
    // cos² of the critical angle: total reflection is below it.
    let border = 1.0 - 1.0 / (INDEX * INDEX);
    size(
        lab,
        "total.cosine",
        border,
        "of cosine-distributed directions inside glass are reflected totally",
    );
    size(
        lab,
        "total.uniform",
        border.sqrt(),
        "of uniform directions inside glass are reflected totally",
    );
    let factor = fresnel::radiance_factor(INDEX, 1.0);
    size(
        lab,
        "radiance.inside",
        factor,
        "times the radiance outside is the radiance inside glass, but for 1 − R",
    );
}

/// (14): the printed form against the one it cites.
fn oren_nayar(lab: &mut Lab) {
    let constants = OrenNayar::new(SIGMA);
    for degrees in [60.0, 85.0f64] {
        let t = degrees.to_radians();
        let error = oren_nayar_printed_albedo(constants, t) / oren_nayar_albedo(constants, t) - 1.0;
        size(
            lab,
            &format!("oren_nayar.albedo.{degrees}"),
            error,
            "relative error of the directional albedo of the printed (14) at that inclination in degrees",
        );
    }
    let t = 75f64.to_radians();
    let at = |form, t: f64| oren_nayar_angles(constants, form, t, t, 0.0);
    let [right, printed] =
        [OrenNayarForm::Corrected, OrenNayarForm::Printed].map(|form| at(form, t));
    size(
        lab,
        "oren_nayar.back",
        printed / right - 1.0,
        "relative error of light sent back where it came from at 75°",
    );
    // A sphere lit from the eye: radiance goes with cos θ f_r.
    let t = 85f64.to_radians();
    for (name, form) in [
        ("corrected", OrenNayarForm::Corrected),
        ("printed", OrenNayarForm::Printed),
    ] {
        let rim = t.cos() * at(form, t) / at(form, 0.0);
        size(
            lab,
            &format!("oren_nayar.rim.{name}"),
            rim,
            "of its centre's radiance is that of a sphere lit from the eye at 85°",
        );
    }
    size(
        lab,
        "oren_nayar.rim.lambert",
        t.cos(),
        "of its centre's radiance for Lambert",
    );
}

/// (18) and (19) with one r: the mean of x and y, which should be 0.
fn one_number(lab: &mut Lab) {
    for (axis, name) in ["x", "y"].into_iter().enumerate() {
        let mean = along(|r| hemisphere_printed(r)[axis]);
        size(
            lab,
            &format!("one_number.{name}"),
            mean,
            "is the mean of that coordinate of directions by one r",
        );
    }
}

/// 2.6.1: variance of one sample of ∫ L cos θ dω, uniform against cosine-weighted directions.
fn importance(lab: &mut Lab) {
    type Profile = (&'static str, fn(f64) -> f64);
    let profiles: [Profile; 4] = [
        ("constant", |_| 1.0),
        ("cosine", |c| c),
        ("horizon", |c| 1.0 - c),
        ("band", |c| f64::from(u8::from(c < 0.1))),
    ];
    for (name, radiance) in profiles {
        let variance = |pdf: fn(f64) -> f64| {
            // dω = 2π d(cos θ). Split at the band's border, where the profile jumps.
            let over = |power: i32| {
                let part = |from: f64, to: f64| {
                    along(|r| {
                        let c = from + r * (to - from);
                        TAU * (to - from)
                            * pdf(c)
                            * (radiance(c) * c * FRAC_1_PI / pdf(c)).powi(power)
                    })
                };
                part(0.0, 0.1) + part(0.1, 1.0)
            };
            over(2) - over(1).powi(2)
        };
        let [uniform, cosine] = [
            variance(uniform_hemisphere_pdf),
            variance(cosine_hemisphere_pdf),
        ];
        size(
            lab,
            &format!("importance.{name}.uniform"),
            uniform,
            "is the variance by uniform directions",
        );
        size(
            lab,
            &format!("importance.{name}.cosine"),
            cosine.max(0.0),
            "is the variance by cosine-weighted directions",
        );
    }
}

/// 2.6.2 and 3.1: the cut after seven bounces, roulette without its weight, infinite variance, N rays.
fn path_ends(lab: &mut Lab) {
    for albedo in [0.5, 0.75, 0.9f64] {
        size(
            lab,
            &format!("seven.{albedo}"),
            -albedo.powi(8),
            "relative bias of seven bounces in a furnace of that albedo",
        );
    }
    // Paths that survive with probability a and are not weighted: Σ a^2k for Σ a^k.
    let a = 0.75f64;
    size(
        lab,
        "unweighted",
        (1.0 - a) / (1.0 - a * a) - 1.0,
        "relative bias without the weight, albedo and survival 0.75",
    );
    size(
        lab,
        "variance.0.75.0.75",
        variance(0.75, 0.75),
        "is the variance of a furnace of albedo 0.75 at survival 0.75",
    );
    size(
        lab,
        "variance.0.9.0.9",
        variance(0.9, 0.9),
        "is the variance of a furnace of albedo 0.9 at survival 0.9",
    );
    size(
        lab,
        "survival.limit.0.9",
        0.9 * 0.9,
        "is the survival below which the variance is infinite at albedo 0.9",
    );
    for rays in [2u64, 4, 10] {
        let tree: u64 = (1..=7).map(|level| rays.pow(level)).sum();
        size(
            lab,
            &format!("tree.{rays}"),
            tree as f64,
            "rays at most per camera ray if every hit sends that many",
        );
    }
}

/// 2.7 and 3.2: noise and encoding.
fn noise(lab: &mut Lab) {
    size(
        lab,
        "noise.64",
        (512f64 / 64.0).sqrt(),
        "times the noise of 512 samples has an image of 64",
    );
    size(
        lab,
        "encoded.half",
        srgb(0.5),
        "is the encoded value of a pixel half white, half black",
    );
    size(
        lab,
        "encoded.mean",
        0.5,
        "is the mean of the encoded values",
    );
    let decoded = ((0.5 + 0.055) / 1.055f64).powf(2.4);
    size(
        lab,
        "encoded.shown",
        decoded,
        "is the radiance that this mean shows, for 0.5",
    );
}

/// ∫ f(r) dr over [0, 1].
fn along(f: impl Fn(f64) -> f64) -> f64 {
    let unit = Rectangle {
        x: [0.0, 1.0],
        y: [0.0, 1.0],
    };
    integrate(unit, 1e-12, &mut |x, _| f(x)).value
}

fn size(lab: &mut Lab, key: &str, value: f64, what: &str) {
    lab.number(key, value);
    let digits = match value.abs() {
        0.0 => "0".to_owned(),
        small if small < 1e-3 => format!("{value:.2e}"),
        large if large >= 1e4 || value.fract() == 0.0 => format!("{value:.0}"),
        _ => format!("{value:.4}"),
    };
    lab.note(key, format!("{digits} {what}"));
}
