//! Size of every finding about the report: closed forms, quadrature, and counts from the functions
//! that implement the printed text.

mod caustics;
mod geometry;
mod samples;

use std::f64::consts::FRAC_PI_2;

use trials::bsdf::{oren_nayar_albedo, oren_nayar_printed_albedo};
use trials::roulette::variance;
use whitefurnace::image::srgb;
use whitefurnace::material::{fresnel, oren_nayar_angles};

use crate::experiments::prelude::*;

pub(super) const ERRATA: Experiment = Experiment {
    id: "errata",
    title: "what is wrong in the report, and by how much",
    headline: "errors of the report: (4) loses {edge.lost %.1%} of rays at shared edges, (14) is {oren_nayar.back %.0%} off at 75°",
    version: 2,
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
        &equation::SUPERSAMPLING,
        &equation::WHITTED,
        &equation::RENDERING,
    ],
    run: |run| {
        geometry::edges(run);
        geometry::far_spheres(run);
        glass(run);
        oren_nayar(run);
        samples::one_number(run);
        samples::importance(run);
        samples::mixed(run);
        samples::slanted_edges(run);
        path_ends(run);
        noise(run);
        caustics::lost(run)
    },
};

/// σ of the rough surface, radians.
const SIGMA: f64 = 0.5;
/// Refractive index of the report's glass.
const INDEX: f64 = 1.5;

/// (10)-(12): the missing case, and the meaning of 1 − R.
fn glass(run: &mut Run) {
    // cos² of the critical angle: total reflection is below it.
    let border = 1.0 - 1.0 / (INDEX * INDEX);
    size(
        run,
        "total.cosine",
        border,
        "of cosine-distributed directions inside glass are reflected totally",
    );
    size(
        run,
        "total.uniform",
        border.sqrt(),
        "of uniform directions inside glass are reflected totally",
    );
    let factor = fresnel::radiance_factor(INDEX, 1.0);
    size(
        run,
        "radiance.inside",
        factor,
        "times the radiance outside is the radiance inside glass, but for 1 − R",
    );
    // A slab transmits (1 − R)/(1 + R) of each polarisation, all internal reflections summed.
    let passed = |r: f64| (1.0 - r) / (1.0 + r);
    let cos = INDEX.atan().cos();
    let [s, p] = [fresnel::reflectance_s, fresnel::reflectance_p].map(|r| r(cos, 1.0, INDEX));
    size(
        run,
        "polarisation.slab",
        passed((s + p) / 2.0) / ((passed(s) + passed(p)) / 2.0) - 1.0,
        "relative error of a slab's transmittance at Brewster's angle by the average (12)",
    );
}

/// (14): the printed form against the one it cites.
fn oren_nayar(run: &mut Run) {
    let constants = OrenNayar::new(SIGMA);
    for degrees in [60.0, 85.0f64] {
        let t = degrees.to_radians();
        let error = oren_nayar_printed_albedo(constants, t) / oren_nayar_albedo(constants, t) - 1.0;
        let what = "relative error of the directional albedo of the printed (14) at that inclination in degrees";
        size(run, &format!("oren_nayar.albedo.{degrees}"), error, what);
    }
    let t = 75f64.to_radians();
    let at = |form, t: f64| oren_nayar_angles(constants, form, t, t, 0.0);
    let [right, printed] =
        [OrenNayarForm::Corrected, OrenNayarForm::Printed].map(|form| at(form, t));
    let what = "relative error of light sent back where it came from at 75°";
    size(run, "oren_nayar.back", printed / right - 1.0, what);
    // A sphere lit from the eye: radiance is proportional to cos θ f_r.
    let t = 85f64.to_radians();
    for (name, form) in [
        ("corrected", OrenNayarForm::Corrected),
        ("printed", OrenNayarForm::Printed),
    ] {
        let rim = t.cos() * at(form, t) / at(form, 0.0);
        let what = "of its centre's radiance is that of a sphere lit from the eye at 85°";
        size(run, &format!("oren_nayar.rim.{name}"), rim, what);
    }
    size(
        run,
        "oren_nayar.rim.lambert",
        t.cos(),
        "of its centre's radiance for Lambert",
    );
    let what = "of light at normal incidence is lost by the right form";
    size(
        run,
        "oren_nayar.loss",
        1.0 - oren_nayar_albedo(constants, 0.0),
        what,
    );
    // The albedo rises towards grazing, where it is A + B/2: above 1 while 0.45/(σ² + 0.09) is
    // above 1/(σ² + 0.33).
    let grazing = |sigma: f64| oren_nayar_albedo(OrenNayar::new(sigma), FRAC_PI_2 - 1e-6);
    let most = (1..1000).map(|i| grazing(f64::from(i) / 1000.0));
    let what = "more than arrives is reflected by the right form at the worst σ";
    size(
        run,
        "oren_nayar.excess",
        most.fold(0.0, f64::max) - 1.0,
        what,
    );
    let what = "rad is the σ below which the right form reflects more than arrives near grazing";
    size(
        run,
        "oren_nayar.excess.below",
        ((0.45 * 0.33 - 0.09) / (1.0 - 0.45f64)).sqrt(),
        what,
    );
}

/// 2.6.2 and 3.1: truncation after seven bounces, roulette without its weight, infinite variance, N
/// rays.
fn path_ends(run: &mut Run) {
    for albedo in [0.5, 0.75, 0.9f64] {
        let what = "relative bias of seven bounces in a furnace of that albedo";
        size(run, &format!("seven.{albedo}"), -albedo.powi(8), what);
    }
    let a = 0.75f64;
    size(
        run,
        "seven.segments.0.75",
        -a.powi(7),
        "the same if seven are the segments",
    );
    let what = "relative bias of emission and direct light alone in a furnace of albedo 0.75";
    size(run, "whitted.0.75", -a * a, what);
    // Paths that survive with probability a and are not weighted: Σ a^2k for Σ a^k.
    let what = "relative bias without the weight, albedo and survival 0.75";
    size(run, "unweighted", (1.0 - a) / (1.0 - a * a) - 1.0, what);
    let what =
        "relative bias if what was counted before the survival is divided as well, survival 0.75";
    size(run, "divided", 1.0 / a - 1.0, what);
    let what = "is the variance of a furnace of albedo 0.75 at survival 0.75";
    size(run, "variance.0.75.0.75", variance(0.75, 0.75), what);
    size(
        run,
        "variance.0.9.0.9",
        variance(0.9, 0.9),
        "is the variance of a furnace of albedo 0.9 at survival 0.9",
    );
    size(
        run,
        "survival.limit.0.9",
        0.9 * 0.9,
        "is the survival below which the variance is infinite at albedo 0.9",
    );
    for rays in [2u64, 4, 10] {
        let tree: u64 = (1..=7).map(|level| rays.pow(level)).sum();
        size(
            run,
            &format!("tree.{rays}"),
            tree as f64,
            "rays at most per camera ray if every hit sends that many",
        );
    }
}

/// 2.7 and 3.2: noise and encoding.
fn noise(run: &mut Run) {
    size(
        run,
        "noise.64",
        (512f64 / 64.0).sqrt(),
        "times the noise of 512 samples has an image of 64",
    );
    size(
        run,
        "encoded.half",
        srgb(0.5),
        "is the encoded value of a pixel half white, half black",
    );
    size(
        run,
        "encoded.mean",
        0.5,
        "is the mean of the encoded values",
    );
    let decoded = ((0.5 + 0.055) / 1.055f64).powf(2.4);
    size(
        run,
        "encoded.shown",
        decoded,
        "is the radiance that this mean shows, for 0.5",
    );
}

/// Records a number and its description.
fn size(run: &mut Run, key: &str, value: f64, what: &str) {
    run.number(key, value);
    run.note(key, format!("{value:.6} {what}"));
}
