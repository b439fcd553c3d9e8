//! Tests that every estimator, through the rendering loop, treats the three channels alike and
//! keeps them apart, exactly.
//!
//! A scene whose colours are all permuted in the same way has the same image with its channels
//! permuted, to the last bit: roulette uses the largest channel only. Cyclic permutations and
//! transpositions together commute with no mix-up of channels. A light of one channel lights that
//! channel only, so none is added to another.

use crate::helpers;
use crate::prelude::*;

const FRAME: [u32; 2] = [8, 6];

/// The library's own Lambertian BRDF.
pub fn lambertian(albedo: DVec3) -> Bsdf {
    Bsdf::Lambert { albedo }
}

/// Map applied to every colour of the scene.
pub type Paint = fn(DVec3) -> DVec3;

/// Returns a small room of many colours with paper, a mirror, glass, a spherical lamp and a light
/// in the ceiling; only diffuse polygons if `plain`. `lamp` maps emitted radiance, then `paint` all
/// colours; diffuse walls use the model `lambert`.
pub fn room(paint: Paint, lamp: Paint, plain: bool, lambert: impl Fn(DVec3) -> Bsdf) -> Scene {
    let mut room = SceneBuilder::new("colours");
    let colour = |r, g, b| paint(DVec3::new(r, g, b));
    let light = |r, g, b| paint(lamp(DVec3::new(r, g, b)));
    let mut wall = |bsdf, corner, edges, emission: DVec3| {
        let surface = Surface::new(bsdf).emitting(emission).absorbing(0.5);
        panel(&mut room, corner, edges, surface);
    };
    let (paper, eon) = if plain {
        (
            lambert(colour(0.2, 0.5, 0.8)),
            lambert(colour(0.6, 0.3, 0.4)),
        )
    } else {
        let paper = Bsdf::oren_nayar(colour(0.2, 0.5, 0.8), 0.4, OrenNayarForm::Corrected);
        (
            paper,
            Bsdf::Eon {
                albedo: colour(0.6, 0.3, 0.4),
                roughness: 0.5,
            },
        )
    };
    let dark = DVec3::ZERO;
    let ([x, y, z], low) = (DVec3::AXES.map(|axis| 2.0 * axis), -DVec3::ONE);
    wall(lambert(colour(0.7, 0.5, 0.3)), low, [x, y], dark);
    wall(lambert(colour(0.5, 0.6, 0.7)), low + z, [y, x], dark);
    wall(paper, low, [y, z], dark);
    wall(eon, low + x, [z, y], light(0.1, 0.02, 0.05));
    wall(lambert(colour(0.4, 0.7, 0.1)), low + y, [x, z], dark);
    wall(lambert(colour(0.3, 0.2, 0.6)), low, [z, x], dark);
    let lamp_at = DVec3::new(-0.4, -0.2, 0.99);
    wall(
        Bsdf::Black,
        lamp_at,
        [0.4 * y, 0.4 * x],
        light(3.0, 5.0, 2.0),
    );
    if !plain {
        let reflectance = colour(0.9, 0.6, 0.8);
        let mirror = Surface::new(Bsdf::Mirror { reflectance }).absorbing(0.1);
        let lamp = Surface::new(Bsdf::Black).emitting(light(1.0, 4.0, 7.0));
        for (centre, radius, surface) in [
            (DVec3::new(-0.5, 0.4, -0.6), 0.35, mirror),
            (DVec3::new(0.45, 0.3, -0.5), 0.4, glass(1.5)),
            (DVec3::new(0.3, 0.6, 0.5), 0.15, lamp),
        ] {
            ball(&mut room, Sphere::new(centre, radius), surface);
        }
    }
    room.build(Camera::new(
        DVec3::new(0.1, -0.9, 0.1),
        DVec3::new(0.0, 0.5, -0.1),
        DVec3::Z,
        0.9,
    ))
    .expect("a scene")
}

/// Mean, standard error and albedo of every pixel.
type Image = Vec<[DVec3; 3]>;

fn image(film: &Film) -> Image {
    let of = |pixel: &Pixel| {
        [
            pixel.mean(),
            pixel.standard_error(),
            pixel.features().albedo,
        ]
    };
    film.pixels().iter().map(of).collect()
}

fn rays(scene: &Scene, estimator: &dyn Estimator) -> Image {
    let sampling = sampling(Jitter(2), SamplerKind::Independent, master());
    image(&rendered(scene, estimator, FRAME, sampling, &[0..3]).expect("legal radiance"))
}

fn passes(scene: &Scene, estimator: &dyn ImageEstimator) -> Image {
    image(&helpers::passes(scene, estimator, FRAME, &[0..12]).expect("legal radiance"))
}

/// Renders a scene with every estimator that has physical rules and handles mirrors and glass.
pub fn physical_images(scene: &Scene) -> Vec<(&'static str, Image)> {
    let path = |strategy, lights, heuristic| Path {
        strategy,
        lights,
        heuristic,
        parts: Parts::default(),
        rr_depth: 1,
        specular_nee: false,
        bounces: None,
    };
    let (area, angle) = (LightSampling::Area, LightSampling::SolidAngle);
    let photons = |lookup| {
        PhotonMapping::new(
            Parts::default(),
            scene,
            lookup,
            3000,
            0.3,
            ImagePass::independent(master(), 0),
        )
        .expect("a small map")
    };
    let gather = final_gather(3000, 0.3);
    let report = Report {
        rays: 2,
        segments: 6,
        rules: TransportRules::PHYSICAL,
        ..Report::default()
    };
    let whitted = Whitted::new(TransportRules::PHYSICAL);
    let (balance, power) = (Heuristic::Balance, Heuristic::Power);
    vec![
        (
            "bsdf",
            rays(scene, &path(PathStrategy::Bsdf, area, balance)),
        ),
        (
            "light",
            rays(scene, &path(PathStrategy::Light, area, balance)),
        ),
        ("mis", rays(scene, &path(PathStrategy::Mis, angle, power))),
        ("report", rays(scene, &report)),
        ("whitted", rays(scene, &whitted)),
        ("photon", rays(scene, &photons(Lookup::DirectVisualization))),
        ("gather", rays(scene, &photons(gather))),
        ("light tracer", passes(scene, &LightTracer::default())),
        ("bdpt", passes(scene, &Bdpt::new(Parts::default()))),
        ("sppm", passes(scene, &sppm(Parts::default(), 3000, 0.3))),
    ]
}

/// Renders with every estimator that has physical rules.
fn physical(paint: Paint, lamp: Paint) -> Vec<(&'static str, Image)> {
    let mut images = physical_images(&room(paint, lamp, false, lambertian));
    let plain = &room(paint, lamp, true, lambertian);
    let resolution = resolution(60, 0);
    let solved =
        Radiosity::new(Parts::default(), plain, resolution, &|_| true).expect("it settles");
    images.push(("radiosity", rays(plain, &solved)));
    images
}

/// Renders with all estimators, also under the conventions of the report.
fn images(paint: Paint) -> Vec<(&'static str, Image)> {
    let mut images = physical(paint, |light| light);
    let scene = room(paint, |light| light, false, lambertian);
    images.extend([
        ("report's report", rays(&scene, &Report::default())),
        (
            "report's whitted",
            rays(&scene, &Whitted::new(TransportRules::REPORT)),
        ),
        ("published", rays(&scene, &Published::default())),
    ]);
    images
}

/// Sums the means of the pixels.
fn total(image: &Image) -> DVec3 {
    image.iter().map(|[mean, ..]| mean).sum()
}

#[test]
fn permuted_colours_make_the_permuted_image() {
    let right = images(|colour| colour);
    for (name, image) in &right {
        let [r, g, b] = total(image).to_array();
        let least = 1e-6 * r.max(g).max(b);
        assert!(
            (r - g).abs() > least && (g - b).abs() > least && (b - r).abs() > least,
            "{name}: too grey, {r} {g} {b}"
        );
    }
    let permutations: [Paint; 2] = [|c| DVec3::new(c.y, c.z, c.x), |c| DVec3::new(c.y, c.x, c.z)];
    for permuted in permutations {
        for ((name, image), (_, other)) in right.iter().zip(images(permuted)) {
            let expected: Image = image.iter().map(|values| values.map(permuted)).collect();
            assert!(expected == other, "{name}: channels are mixed up");
        }
    }
}

#[test]
fn light_of_one_channel_lights_that_channel() {
    let lamps: [Paint; 3] = [
        |light| light.with_y(0.0).with_z(0.0),
        |light| light.with_x(0.0).with_z(0.0),
        |light| light.with_x(0.0).with_y(0.0),
    ];
    for (lit, lamp) in lamps.into_iter().enumerate() {
        for (name, image) in physical(|colour| colour, lamp) {
            for (channel, sum) in total(&image).to_array().into_iter().enumerate() {
                assert_eq!(
                    sum > 0.0,
                    channel == lit,
                    "{name}: channel {channel} of light {lit}"
                );
            }
        }
    }
}
