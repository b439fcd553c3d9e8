//! Figure 2 of the report with four diffuse models, and the albedos of the models.

use std::f64::consts::{FRAC_PI_2, PI};

use trials::bsdf::{oren_nayar_albedo, oren_nayar_printed_albedo};
use trials::ggx::reflected;
use trials::rough_glass::shares;
use whitefurnace::camera::Camera;
use whitefurnace::material::Vertex;
use whitefurnace::material::ggx::Ggx;
use whitefurnace::material::rough_glass::RoughGlass;
use whitefurnace::math::frame::from_spherical;

use crate::experiments::prelude::*;

pub(super) const FIG2: Experiment = Experiment {
    id: "fig2",
    title: "a sphere lit from the front with four diffuse models: the flat look of the full moon",
    headline: "the moon is flat: its rim has {corrected.limb %.2f} of the centre's radiance by Oren–Nayar, {printed.limb %.2f} as the report prints it, {lambert.limb %.2f} by Lambert",
    version: 2,
    equations: &[
        &equation::LAMBERT,
        &equation::OREN_NAYAR,
        &equation::EON_SINGLE,
        &equation::EON_MULTIPLE,
    ],
    run: figure,
};

pub(super) const ALBEDO: Experiment = Experiment {
    id: "albedo",
    title: "directional albedos of four diffuse models, of rough metals and rough glass, and lobes",
    headline: "white Oren–Nayar reflects {corrected.85 %.3f} at 85°, as printed {printed.85 %.3f}, EON {eon.85 %.3f}",
    version: 3,
    equations: &[
        &equation::LAMBERT,
        &equation::OREN_NAYAR,
        &equation::OREN_NAYAR_CONSTANTS,
        &equation::EON_ALBEDO,
        &equation::EON_MULTIPLE,
        &equation::GGX_NORMALS,
        &equation::GGX_MASKING,
        &equation::GGX_VISIBLE,
        &equation::ROUGH_GLASS,
        &equation::ROUGH_GLASS_REFRACTION,
        &equation::ROUGH_GLASS_MASKING,
        &equation::ROUGH_GLASS_PDF,
    ],
    run: albedo,
};

/// σ of the rough models, radians.
pub(crate) const SIGMA: f64 = 0.5;
/// Distance of camera and light from the centre of the unit sphere: rays are almost parallel.
pub(crate) const DISTANCE: f64 = 10_000.0;
/// Half the side of the square light.
const HALF: f64 = 5.0;
/// Half the picture's height, in radii of the sphere.
pub(crate) const MARGIN: f64 = 1.08;
/// Magnification of single spheres.
const MAGNIFICATION: u32 = 2;
/// Inclination at which limb and centre are compared, degrees.
const LIMB: f64 = 85.0;

/// Builds a white unit sphere with a small light at the camera, whose irradiance at normal
/// incidence is π, so that white Lambert shows the cosine.
fn lit_sphere(bsdf: Bsdf) -> Result<Scene, Error> {
    let mut scene = SceneBuilder::new("moon");
    let white = scene.surface(Surface::new(bsdf));
    scene.sphere(Sphere::new(DVec3::ZERO, 1.0), white);
    let radiance = PI * (DISTANCE - 1.0).powi(2) / (4.0 * HALF * HALF);
    let light = scene.surface(Surface::new(Bsdf::Black).emitting(DVec3::splat(radiance)));
    scene.rectangle(
        DVec3::new(DISTANCE, -HALF, -HALF),
        // The front faces the sphere.
        [2.0 * HALF * DVec3::Z, 2.0 * HALF * DVec3::Y],
        light,
    );
    // Just in front of the light, which would block the view.
    let eye = DVec3::new(DISTANCE - 1e-3, 0.0, 0.0);
    scene.build(Camera::new(eye, DVec3::ZERO, DVec3::Z, MARGIN / DISTANCE))
}

/// Returns the radiance of the moon at inclination θ: π f_r(θ, θ) cos θ.
fn retroreflected(bsdf: &Bsdf, theta: f64) -> f64 {
    let w = from_spherical(theta, 0.0);
    PI * bsdf.eval(w, w).x * w.z
}

fn figure(run: &mut Run) -> Result<(), Error> {
    let side = run.by_tier(160, 256);
    let spp = run.count(run.by_tier(16, 256)).max(2) as u32;
    let (mut films, mut series) = (Vec::new(), Vec::new());
    for (colour, model) in (0..).zip(DiffuseName::ALL) {
        let bsdf = model.bsdf(DVec3::ONE, SIGMA);
        let scene = lit_sphere(bsdf)?;
        let path = Path::default();
        let film = render_samples(&scene, &path, random_points(run.seed()), [side; 2], spp)?;
        let radiance = |x: f64| retroreflected(&bsdf, x.asin().min(FRAC_PI_2 - 1e-6));
        series.push(Series::curve(
            model.title(),
            colour,
            [0.0, 1.0],
            240,
            radiance,
        ));
        series.push(Series::new("", colour, Mark::Points, profile(&film)));
        limb(run, model, &scene, &bsdf);
        films.push(film);
    }
    // EON's centre is a little above 1.
    let display = Display::Srgb { exposure: -0.25 };
    write_row(&run.figure("moons.png"), &films, display, 1)?;
    for (film, model) in films.iter().zip(DiffuseName::ALL) {
        if let DiffuseName::Printed | DiffuseName::Corrected = model {
            write_png(
                &run.figure(&format!("{}.png", name(model))),
                film,
                display,
                MAGNIFICATION,
            )?;
        }
    }
    run.note(
        "moons.png",
        format!(
            "left to right: {}; {side}x{side}, {spp} spp",
            DiffuseName::ALL.map(DiffuseName::title).join(", ")
        ),
    );
    let title = format!("Radiance across the disc, white sphere lit from the front, σ = {SIGMA}");
    let radiance = "radiance (points: pixels of the picture; lines: π f cos θ)";
    let chart = Chart::new(
        title,
        ["distance from the centre (radii)", radiance],
        [[0.0, 1.0], [0.0, 1.1]],
        series,
    );
    let description = "The corrected Oren–Nayar sphere is flat almost to its rim; as printed it darkens like Lambert's.";
    charts(run, "profile.svg", description, 600, &[chart])
}

/// Returns the radiance of every fourth pixel right of the centre, against the distance of its
/// middle from it in radii; pixels on the rim are left out.
fn profile(film: &Film) -> Vec<[f64; 2]> {
    let side = film.size()[0];
    let scale = 2.0 * MARGIN / f64::from(side);
    (side / 2..side)
        .step_by(4)
        .map(|x| {
            let distance = (f64::from(x - side / 2) + 0.5) * scale;
            [distance, film.pixel(x, side / 2).mean().x]
        })
        .filter(|[distance, _]| distance + scale < 1.0)
        .collect()
}

/// Compares the radiance at the limb over that at the centre, by the path tracer, with the closed
/// form.
fn limb(run: &mut Run, model: DiffuseName, scene: &Scene, bsdf: &Bsdf) {
    let samples = run.count(run.by_tier(4_000, 100_000)) as u32;
    let radiance = |degrees: f64| {
        let theta = degrees.to_radians();
        let point = DVec3::new(theta.cos(), theta.sin(), 0.0);
        let eye = scene.camera().eye;
        let ray = Ray::new(eye, (point - eye).normalize());
        let seed = seed_for(run.seed(), &format!("limb {degrees}"));
        radiance_along(scene, &Path::default(), &ray, seed, 0, samples)
    };
    let [centre, edge] = [0.0, LIMB].map(radiance);
    let ratio = edge.mean() / centre.mean();
    let expected = retroreflected(bsdf, LIMB.to_radians()) / retroreflected(bsdf, 0.0);
    run.number(&format!("{}.limb", name(model)), ratio);
    run.number(&format!("{}.limb.closed", name(model)), expected);
    // Light and camera are so far away that the angles are off by 10⁻⁴ at the limb, 0.11 % of cos
    // 85°.
    let what = format!("limb/centre at {LIMB}°, {}", model.title());
    let value = format!("{ratio:.4}, closed form for parallel light {expected:.4}");
    run.claim(&what, value, (ratio - expected).abs() < 0.005 * expected);
}

/// Returns the directional albedo with ρ = 1 in closed form, at inclination θ in radians.
pub(crate) fn closed_form(model: DiffuseName, theta: f64) -> f64 {
    let constants = OrenNayar::new(SIGMA);
    match model {
        DiffuseName::Lambert | DiffuseName::Eon => 1.0,
        DiffuseName::Printed => oren_nayar_printed_albedo(constants, theta),
        DiffuseName::Corrected => oren_nayar_albedo(constants, theta),
        DiffuseName::Ggx => reflected(metal(SIGMA), from_spherical(theta, 0.0)),
    }
}

/// Inclinations at which albedos are sampled, degrees.
const ANGLES: [f64; 10] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 85.0];

fn albedo(run: &mut Run) -> Result<(), Error> {
    let samples = run.count(run.by_tier(20_000, 1_000_000));
    let (mut series, mut lobes) = (Vec::new(), Vec::new());
    for (colour, model) in (0..).zip(DiffuseName::ALL) {
        let bsdf = model.bsdf(DVec3::ONE, SIGMA);
        let known = |degrees: f64| closed_form(model, degrees.to_radians());
        let reflected =
            |wo, rng: &mut Stream| PI * bsdf.eval(wo, cosine_hemisphere(uniform2(rng))).x;
        let found = sampled(seed_for(run.seed(), &name(model)), samples, reflected)?;
        for (degrees, moments) in ANGLES.into_iter().zip(&found) {
            if [0.0, 60.0, 85.0].contains(&degrees) {
                let key = format!("{}.{degrees:.0}", name(model));
                run.number(&key, moments.mean());
                run.number(&format!("{key}.closed"), known(degrees));
            }
        }
        let what = format!("albedo of {} against its closed form", model.title());
        let points = compared(run, &what, &found, known, DiffuseName::ALL.len())?;
        series.push(closed_curve(
            model.title(),
            colour,
            89.0,
            run.by_tier(22, 89),
            known,
        )?);
        series.push(Series::measured("", colour, points));
        lobes.push(Series::new(model.title(), colour, Mark::Line, lobe(&bsdf)));
    }
    let title = format!(
        "Directional albedo, ρ = 1, σ = {SIGMA}: closed forms, and means of {samples} samples"
    );
    let axes = ["inclination (degrees)", "directional albedo"];
    let chart = Chart::new(title, axes, [[0.0, 90.0], [0.75, 1.05]], series);
    let description = "Lambert and EON lie on one. Corrected Oren–Nayar rises towards grazing, the printed form hardly.";
    charts(run, "albedo.svg", description, 560, &[chart])?;
    let arrow = from_spherical(INCIDENT.to_radians(), 0.0);
    let arrow = [[0.0, 0.0], [2.0 * arrow.x, 2.0 * arrow.z]];
    lobes.push(Series::new("direction of the light", 6, Mark::Line, arrow));
    let title = format!("π f in the plane of incidence, light at {INCIDENT}°, ρ = 1, σ = {SIGMA}");
    let axes = ["π f sin θ (towards the light →)", "π f cos θ"];
    let chart = Chart::new(title, axes, [[-1.2, 2.0], [0.0, 1.45]], lobes);
    let description =
        "Lambert's lobe is a half circle. Corrected Oren–Nayar and EON bulge towards the light.";
    charts(run, "lobes.svg", description, 460, &[chart])?;
    metals(run, samples)
}

/// Roughness α of the rough metals.
const ALPHA: [f64; 3] = [0.25, 0.5, 1.0];

fn metal(alpha: f64) -> Ggx {
    Ggx {
        reflectance: DVec3::ONE,
        alpha,
    }
}

/// Compares the albedos of white GGX metals: means of their own samples against quadrature over
/// microfacets.
fn metals(run: &mut Run, samples: u64) -> Result<(), Error> {
    let mut series = Vec::new();
    for (colour, alpha) in (0..).zip(ALPHA) {
        let bsdf = Bsdf::model(metal(alpha));
        let known =
            |degrees: f64| reflected(metal(alpha), from_spherical(degrees.to_radians(), 0.0));
        let weight = |wo, rng: &mut Stream| {
            bsdf.sample(&Vertex::local(wo, true), rng)
                .map_or(0.0, |sample| sample.weight.x)
        };
        let found = sampled(
            seed_for(run.seed(), &format!("metal {alpha}")),
            samples,
            weight,
        )?;
        for (_, moments) in ANGLES
            .into_iter()
            .zip(&found)
            .filter(|(degrees, _)| *degrees == 60.0)
        {
            run.number(&format!("ggx.{alpha}.60"), moments.mean());
        }
        let what = format!("albedo of GGX with α = {alpha} against quadrature over facets");
        let points = compared(run, &what, &found, known, ALPHA.len())?;
        series.push(closed_curve(
            &format!("α = {alpha}"),
            colour,
            88.0,
            run.by_tier(22, 44),
            known,
        )?);
        series.push(Series::measured("", colour, points));
    }
    let title =
        format!("Directional albedo of GGX, F₀ = 1: quadrature, and means of {samples} samples");
    let axes = ["inclination (degrees)", "directional albedo"];
    let chart = Chart::new(title, axes, [[0.0, 90.0], [0.3, 1.05]], series);
    let description = "The rougher the metal, the more of the light is lost on a second facet.";
    charts(run, "metals.svg", description, 560, &[chart])?;
    rough_glass(run, samples)
}

/// Compares the light scattered by rough glass, from outside and from inside: means of its own
/// samples against quadrature over microfacets.
fn rough_glass(run: &mut Run, samples: u64) -> Result<(), Error> {
    let glass = RoughGlass {
        index: 1.5,
        alpha: 0.4,
    };
    let bsdf = Bsdf::RoughGlass(glass);
    let mut series = Vec::new();
    for (colour, (side, outside)) in (0..).zip([("from outside", true), ("from within", false)]) {
        let known = |degrees: f64| {
            shares(
                glass.oriented(outside),
                from_spherical(degrees.to_radians(), 0.0),
                1e-6,
            )
            .iter()
            .sum::<f64>()
        };
        let weight = |wo, rng: &mut Stream| {
            bsdf.sample(&Vertex::local(wo, outside), rng)
                .map_or(0.0, |sample| sample.weight.x)
        };
        let found = sampled(
            seed_for(run.seed(), &format!("rough glass {side}")),
            samples,
            weight,
        )?;
        let points = compared(
            run,
            &format!("rough glass {side} against quadrature over facets"),
            &found,
            known,
            2,
        )?;
        series.push(closed_curve(
            side,
            colour,
            88.0,
            run.by_tier(22, 44),
            known,
        )?);
        series.push(Series::measured("", colour, points));
    }
    let title = format!(
        "Flux that rough glass scatters, n = 1.5, α = 0.4: quadrature, and means of {samples} samples"
    );
    let axes = ["inclination (degrees)", "share of flux"];
    let chart = Chart::new(title, axes, [[0.0, 90.0], [0.3, 1.05]], series);
    let description = "What is missing to 1 meets a second facet.";
    charts(run, "frosted.svg", description, 560, &[chart])
}

/// Inclination of the incident light of the lobes, degrees.
const INCIDENT: f64 = 60.0;

/// Returns means of a random `value` at each of [`ANGLES`].
fn sampled(
    seed: u64,
    samples: u64,
    value: impl Fn(DVec3, &mut Stream) -> f64 + Sync,
) -> Result<Vec<Moments>, Error> {
    let at = |(k, degrees): (u32, f64)| -> Moments {
        let (mut rng, wo) = (
            stream(seed, k, 0),
            from_spherical(degrees.to_radians(), 0.3),
        );
        (0..samples).map(|_| value(wo, &mut rng)).collect()
    };
    let angles: Vec<(u32, f64)> = (0..).zip(ANGLES).collect();
    parallel_map(angles, at)
}

/// Plots a closed form from 0° to `end` in this number of steps, on all cores: quadrature is slow.
fn closed_curve(
    label: &str,
    colour: usize,
    end: f64,
    steps: u32,
    known: impl Fn(f64) -> f64 + Sync,
) -> Result<Series, Error> {
    let points = parallel_map(0..steps + 1, |step| {
        let degrees = end * f64::from(step) / f64::from(steps);
        [degrees, known(degrees)]
    })?;
    Ok(Series::new(label, colour, Mark::Line, points))
}

/// Claims that the means at [`ANGLES`] equal `known`, at the level of one of `curves` curves;
/// returns them with the half widths of their intervals.
fn compared(
    run: &mut Run,
    what: &str,
    found: &[Moments],
    known: impl Fn(f64) -> f64 + Sync,
    curves: usize,
) -> Result<Vec<[f64; 3]>, Error> {
    let critical = normal_upper(FAMILYWISE_LEVEL / 2.0 / (curves * ANGLES.len()) as f64);
    // Lambert has no variance at all: the rest is rounding.
    let known = parallel_map(ANGLES, known)?;
    let off =
        |(known, m): (f64, &Moments)| (m.mean() - known).abs() / m.standard_error().max(1e-12);
    let worst = known.into_iter().zip(found).map(off).fold(0.0, f64::max);
    run.claim(
        what,
        format!(
            "worst of {} angles {worst:.2} standard errors",
            ANGLES.len()
        ),
        worst < critical,
    );
    let points = ANGLES.into_iter().zip(found);
    Ok(points
        .map(|(degrees, m)| [degrees, m.mean(), critical * m.standard_error()])
        .collect())
}

/// Returns π f around the half circle as a polar curve.
fn lobe(bsdf: &Bsdf) -> Vec<[f64; 2]> {
    let wi = from_spherical(INCIDENT.to_radians(), 0.0);
    (-899..=899)
        .map(|tenth| {
            let theta = (f64::from(tenth) / 10.0).to_radians();
            let wo = DVec3::new(theta.sin(), 0.0, theta.cos());
            let value = PI * bsdf.eval(wo, wi).x;
            [value * wo.x, value * wo.z]
        })
        .collect()
}
