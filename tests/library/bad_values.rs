//! Tests that invalid radiance, wherever it is accumulated, ends in an error that names the place.

use std::sync::atomic::{AtomicU32, Ordering};

use whitefurnace::film::check_radiance;
use whitefurnace::film::splat::Splats;
use whitefurnace::integrator::MAX_PATH_VERTICES;

use crate::helpers;
use crate::prelude::*;

const FRAME: [u32; 2] = [5, 4];

/// Radiance values that every accumulator must refuse.
const BAD: [f64; 5] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    -1e-3,
    2.0 * LARGEST,
];

/// Asserts that a result is a radiance error, in one line that names the place.
fn assert_surfaces<T>(result: Result<T, Error>, place: &str, what: &str) {
    let is_radiance = matches!(result, Err(Error::Radiance { .. }));
    let message = refusal(result, what);
    assert!(is_radiance && message.contains(place), "{what}: {message}");
}

#[test]
fn no_accumulator_takes_what_is_no_radiance() {
    for channel in 0..3 {
        for bad in BAD {
            let mut radiance = DVec3::splat(0.5);
            radiance[channel] = bad;
            let what = format!("{radiance}");
            assert_surfaces(check_radiance(radiance), "", &what);
            assert_surfaces(Pixel::default().push(radiance, 1), "", &what);
            assert_surfaces(
                Splats::new([3, 2]).buffer().add([2, 1], radiance),
                "at pixel (2, 1)",
                &what,
            );
        }
    }
    assert!(check_radiance(DVec3::splat(-0.5 * FIXED_POINT_UNIT)).is_err());
    // Rounding may leave a value slightly below zero, which counts as zero.
    let mut pixel = Pixel::default();
    assert!(pixel.push(DVec3::splat(-0.4 * FIXED_POINT_UNIT), 1).is_ok());
    assert_eq!(pixel.mean(), DVec3::ZERO);
    assert!(pixel.push(DVec3::splat(LARGEST), 1).is_ok());
}

#[test]
fn splats_that_add_up_to_too_much_are_refused() {
    let image = Splats::new([2, 40]);
    let add = |pixel, value| {
        let mut splats = image.buffer();
        splats.add(pixel, value)?;
        splats.flush()
    };
    let half = DVec3::new(0.0, 0.5 * LARGEST, 1.0);
    assert!(add([1, 38], half).is_ok() && add([1, 38], half).is_ok());
    for _ in 0..100 {
        assert_surfaces(add([1, 38], DVec3::Y), "at pixel (1, 38)", "a full pixel");
    }
    let refused = add([1, 38], DVec3::Y);
    assert!(
        matches!(refused, Err(Error::Radiance { value, .. }) if value == LARGEST + 1.0),
        "{refused:?}"
    );
    assert!(add([0, 38], half).is_ok(), "the other pixel is not full");
    let image = Splats::new([1, 1]);
    let mut splats = image.buffer();
    for _ in 0..4 {
        splats
            .add([0, 0], DVec3::splat(0.25 * LARGEST))
            .expect("legal");
    }
    splats.flush().expect("a sum that is just legal");
    assert_eq!(image.into_values(), [DVec3::splat(LARGEST)]);
}

#[test]
fn full_sums_are_refused_before_they_wrap() {
    // Squares of the largest value: 2^112 units each, of which 128 bits hold 2^15 - 1.
    let mut moments = ExactMoments::default();
    let most = (1 << 15) - 1;
    for _ in 0..most {
        moments.push(LARGEST).expect("room for more");
    }
    let full = moments;
    assert_refused(moments.push(LARGEST), "fewer samples");
    assert!(moments.merge(&full).is_err());
    assert_eq!(moments, full, "as it was");
    assert_eq!((full.mean(most), full.variance(most)), (LARGEST, 0.0));
    // Counts double with every merge with itself: 2^30 is the last power below 2^31.
    let mut pixel = Pixel::default();
    pixel.push(DVec3::ONE, 1).expect("legal");
    pixel
        .push_features(&Features {
            albedo: DVec3::ONE,
            normal: DVec3::Z,
            depth: 1e6,
        })
        .expect("legal");
    for _ in 0..30 {
        let same = pixel;
        pixel.merge(&same).expect("room for more");
    }
    assert_eq!((pixel.replications(), pixel.mean()), (1 << 30, DVec3::ONE));
    assert_eq!(pixel.features().depth, 1e6);
    let same = pixel;
    assert!(pixel.merge(&same).is_err());
    let mut film = Film::new([1, 1], None, 1).expect("a film");
    film.pixels_mut()[0] = same;
    let other = film.clone();
    assert!(film.merge(&other).is_err());
}

#[test]
fn features_that_are_none_are_refused() {
    let good = Features {
        albedo: DVec3::new(0.0, 1.0, 0.5),
        normal: DVec3::new(0.6, 0.0, -0.8),
        depth: 0.0,
    };
    let takes = |features| Pixel::default().push_features(&features).is_ok();
    assert!(takes(good));
    for bad in [f64::NAN, f64::INFINITY, -0.1, 1.5] {
        for axis in 0..3 {
            let (mut albedo, mut normal) = (good.albedo, good.normal);
            albedo[axis] = bad;
            normal[axis] = bad;
            assert!(!takes(Features { albedo, ..good }));
            assert!(!takes(Features { normal, ..good }));
        }
    }
    for depth in [f64::NAN, f64::INFINITY, -1.0, 2.0 * LARGEST] {
        assert!(!takes(Features { depth, ..good }));
    }
}

/// Returns 1, except in one of its calls.
struct OneBadSample {
    calls: AtomicU32,
    at: u32,
    value: f64,
}

impl Estimator for OneBadSample {
    fn radiance(&self, _: &Scene, _: &Ray, _: Option<Hit>, _: &mut dyn Sampler) -> DVec3 {
        let call = self.calls.fetch_add(1, Ordering::Relaxed);
        DVec3::new(1.0, 1.0, if call == self.at { self.value } else { 1.0 })
    }
}

/// One bad sample among many good ones, whose mean might look right, ends a render.
#[test]
fn one_bad_sample_ends_a_render() {
    for value in BAD {
        for (pixel, numbers) in [
            (Centre, SamplerKind::Independent),
            (Random, SamplerKind::Independent),
            (Jitter(3), SamplerKind::Independent),
            (Random, SamplerKind::Sobol(16)),
        ] {
            let sampling = sampling(pixel, numbers, master());
            let samples = sampling.samples_per_replication();
            for at in [0, 7 * samples - 1] {
                let once = OneBadSample {
                    calls: AtomicU32::new(0),
                    at,
                    value,
                };
                let found = rendered(&furnace(0.5), &once, FRAME, sampling, &[0..2]);
                assert_surfaces(found, "at pixel (", &format!("{value} with {sampling:?}"));
            }
        }
    }
}

/// A pass with one bad pixel.
struct BadPixel(f64);

impl ImageEstimator for BadPixel {
    fn image(&self, _: &Scene, frame: [u32; 2], pass: ImagePass) -> Result<Vec<DVec3>, Error> {
        let mut image = vec![DVec3::ONE; (frame[0] * frame[1]) as usize];
        image[(2 * frame[0] + 3) as usize].y = if pass.index == 1 { self.0 } else { 1.0 };
        Ok(image)
    }
}

#[test]
fn one_bad_pixel_ends_the_passes() {
    for value in BAD {
        let found = helpers::passes(&furnace(0.5), &BadPixel(value), FRAME, &[0..3]);
        assert_surfaces(found, "at pixel (3, 2), pass 1", &format!("{value}"));
    }
}

/// The standard parts, one of which returns an invalid value.
#[derive(Clone, Copy)]
enum BadParts {
    /// The BRDF.
    Brdf(f64),
    /// The flux of photons.
    Flux(f64),
    /// Form factors, the radiance reflected between patches, and the radiance that leaves them.
    FormFactor,
    Exchanged,
    Leaving,
    /// Importance of the camera.
    Importance(f64),
    /// Roulette that no path loses, between walls that absorb nothing: paths never end.
    Endless,
}

default_parts!(BadParts: NextEvent);

impl Scattering for BadParts {
    fn brdf(&self, bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> DVec3 {
        if let Self::Brdf(value) = self {
            DVec3::new(0.1, 0.1, *value)
        } else {
            DefaultParts.brdf(bsdf, wo, wi)
        }
    }
}

impl Roulette for BadParts {
    fn survives(&self, r: f64, survival: f64) -> bool {
        matches!(self, Self::Endless) || DefaultParts.survives(r, survival)
    }
}

impl Photons for BadParts {
    fn photon_flux(&self, flux: DVec3, emitted: u32, stored: usize) -> DVec3 {
        if let Self::Flux(value) = self {
            DVec3::new(0.1, *value, 0.1)
        } else {
            DefaultParts.photon_flux(flux, emitted, stored)
        }
    }
}

impl Bidirectional for BadParts {
    fn importance(&self, camera: &Camera, size: [u32; 2], direction: DVec3) -> f64 {
        if let Self::Importance(value) = self {
            *value
        } else {
            DefaultParts.importance(camera, size, direction)
        }
    }
}

impl FiniteElements for BadParts {
    fn form_factor(&self, normal: DVec3, corners: &[DVec3]) -> f64 {
        if let Self::FormFactor = self {
            f64::NAN
        } else {
            DefaultParts.form_factor(normal, corners)
        }
    }
    fn reflected(&self, leaving: DVec3, emitted: DVec3) -> DVec3 {
        if let Self::Exchanged = self {
            DVec3::new(f64::NAN, 0.1, 0.1)
        } else {
            DefaultParts.reflected(leaving, emitted)
        }
    }
    fn leaving(&self, albedo: DVec3, emitted: DVec3, irradiance: DVec3) -> DVec3 {
        if let Self::Leaving = self {
            DVec3::new(0.1, f64::NAN, 0.1)
        } else {
            DefaultParts.leaving(albedo, emitted, irradiance)
        }
    }
}

/// Number of replications. If a BRDF is -1 in one channel, some path must show it: at least one
/// path in 64 is reflected exactly once, so that all 2000 look right with a probability below
/// 1e-13. A bad value ends a render at once.
const REPLICATIONS: u32 = 100;

fn rays(scene: &Scene, estimator: &dyn Estimator) -> Result<Film, Error> {
    rendered(
        scene,
        estimator,
        FRAME,
        sampling(Random, SamplerKind::Independent, master()),
        &[0..REPLICATIONS],
    )
}

fn passes(scene: &Scene, estimator: &dyn ImageEstimator) -> Result<Film, Error> {
    helpers::passes(scene, estimator, FRAME, &[0..REPLICATIONS])
}

/// Renders with photon mapping, if the map can be built.
fn photons(scene: &Scene, parts: BadParts, lookup: Lookup) -> Result<Film, Error> {
    rays(
        scene,
        &PhotonMapping::new(
            Parts::replaced(&parts),
            scene,
            lookup,
            50,
            0.5,
            ImagePass::independent(master(), 0),
        )?,
    )
}

/// Renders with every estimator that traces random walks.
fn walks(scene: &Scene, parts: BadParts) -> Vec<(&'static str, Result<Film, Error>)> {
    let replaced = Parts::replaced(&parts);
    let path = |strategy| rays(scene, &Path::new(strategy).with_parts(replaced));
    let gather = final_gather(200, 0.5);
    vec![
        ("path by BSDF", path(PathStrategy::Bsdf)),
        ("path by light", path(PathStrategy::Light)),
        ("path by both", path(PathStrategy::Mis)),
        (
            "light tracer",
            passes(scene, &LightTracer { parts: replaced }),
        ),
        ("bdpt", passes(scene, &Bdpt::new(replaced))),
        (
            "photons",
            photons(scene, parts, Lookup::DirectVisualization),
        ),
        ("photons, gathered", photons(scene, parts, gather)),
        ("sppm", passes(scene, &sppm(replaced, 50, 0.5))),
    ]
}

#[test]
fn bad_parts_surface_through_every_estimator() {
    let scene = furnace(0.5);
    for value in [f64::NAN, f64::INFINITY, -1.0] {
        for (name, found) in walks(&scene, BadParts::Brdf(value)) {
            let by_pixel = name.starts_with("path") || ["light tracer", "bdpt"].contains(&name);
            let place = if by_pixel { "at pixel (" } else { "" };
            assert_surfaces(found, place, &format!("{name} with a BRDF of {value}"));
        }
        let parts = BadParts::Flux(value);
        let place = "the flux of a photon of pass 0";
        assert_surfaces(
            photons(&scene, parts, Lookup::DirectVisualization),
            place,
            &format!("flux {value}"),
        );
        assert_surfaces(
            passes(&scene, &sppm(Parts::replaced(&parts), 50, 0.5)),
            place,
            &format!("flux {value} in passes"),
        );
        let parts = BadParts::Importance(value);
        let parts = Parts::replaced(&parts);
        assert_surfaces(
            passes(&scene, &LightTracer { parts }),
            "at pixel (",
            "importance",
        );
        assert_surfaces(
            passes(&scene, &Bdpt::new(parts)),
            "at pixel (",
            "importance",
        );
    }
}

#[test]
fn bad_parts_do_not_pass_for_a_solution() {
    let scene = simple::cornell().expect("a scene");
    let resolution = resolution(40, 0);
    for parts in [BadParts::FormFactor, BadParts::Exchanged, BadParts::Leaving] {
        let solved = Radiosity::new(Parts::replaced(&parts), &scene, resolution, &|_| true);
        assert_surfaces(solved.map(|_| ()), "as the irradiance at", "radiosity");
    }
}

/// A path that never ends is an error after [`MAX_PATH_VERTICES`] vertices, in every estimator that
/// traces random walks.
#[test]
fn paths_without_end_are_errors() {
    for (name, found) in walks(&furnace(0.9), BadParts::Endless) {
        let by_pixel = name.starts_with("path") || name == "bdpt";
        let place = if by_pixel { "at pixel (" } else { "of pass 0" };
        assert_surfaces(found, place, name);
    }
}

/// Counts how often paths survive.
struct Counting(AtomicU32);

default_parts!(Counting: Scattering, NextEvent, Photons, Bidirectional, FiniteElements);

impl Roulette for Counting {
    fn survives(&self, _: f64, _: f64) -> bool {
        self.0.fetch_add(1, Ordering::Relaxed) + 1 < MAX_PATH_VERTICES
    }
}

/// The longest legal path counts to its last vertex; its probability is too small for a number.
#[test]
fn the_longest_path_is_no_error() {
    let scene = furnace(0.5);
    let ray = scene.camera().ray(FRAME, 2.5, 2.0);
    let parts = Counting(AtomicU32::new(0));
    let path = Path::new(PathStrategy::Bsdf).with_parts(Parts::replaced(&parts));
    let radiance = path.radiance(
        &scene,
        &ray,
        scene.intersect(&ray),
        &mut stream(master(), 0, 0),
    );
    assert!(radiance.is_finite(), "{radiance}");
    assert_eq!(parts.0.into_inner(), MAX_PATH_VERTICES);
    let survival =
        f64::from(MAX_PATH_VERTICES - 1) * whitefurnace::sampling::roulette::MAX_SURVIVAL.ln();
    assert!(survival < -180.0 * std::f64::consts::LN_10);
}
