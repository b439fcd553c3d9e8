//! Tests of degenerate scenes: flat, coincident, nested, tiny, huge, not finite. Each is refused in
//! one line or rendered.

use std::fmt::Write as _;
use std::sync::atomic::{AtomicU32, Ordering};

use whitefurnace::scene::file::Description;

use crate::prelude::*;

const FRAME: [u32; 2] = [4, 3];

/// Materials, by their index in the list.
const MATERIALS: &str = r#"
[materials]
m0 = { model = "black", emission = [4, 2, 1] }
m1 = { model = "lambert", albedo = [1, 0.5, 0], emission = 1 }
m2 = { model = "mirror", reflectance = 1 }
m3 = { model = "glass", index = 1.5 }
m4 = { model = "ggx", reflectance = 0.9, alpha = 0.001 }
m5 = { model = "eon", albedo = 1, roughness = 1 }
m6 = { model = "oren-nayar", albedo = 0.5, sigma = 1.5 }
"#;

/// An object: index of its kind, index of its material, and nine numbers.
type RandomObject = (usize, usize, [f64; 9]);

/// A random scene. The builder alone takes its emission, background and image height; a scene file
/// has values of its own.
#[derive(Clone, Debug)]
struct RandomScene {
    objects: Vec<RandomObject>,
    eye: [f64; 3],
    target: [f64; 3],
    emission: f64,
    background: f64,
    half_height: f64,
    /// Whether numbers differ widely in size.
    far_apart: bool,
}

/// Formats numbers for a scene file, which spells NaN differently from Rust.
fn toml(x: &[f64]) -> String {
    format!("{x:?}").replace("NaN", "nan")
}

/// Writes the scene file of these parts.
fn text(objects: &[RandomObject], eye: &[f64; 3], target: &[f64; 3]) -> String {
    let mut text = format!(
        "background = 0.25\ncamera = {{ eye = {}, target = {}, up = [0.1, 0.2, 1], fov_deg = 60 }}\n{MATERIALS}",
        toml(eye),
        toml(target)
    );
    for (kind, material, x) in objects {
        let [a, b, c] = [&x[..3], &x[3..6], &x[6..]].map(toml);
        let object = match kind {
            0 => format!("shape = 'rectangle'\nmaterial = 'm{material}'\ncorner = {a}\nedges = [{b}, {c}]"),
            1 => format!("shape = 'mesh'\nvertices = [{a}, {b}, {c}]\nfaces = {{ m{material} = [[0, 1, 2]] }}"),
            2 => format!("shape = 'box'\nmaterial = 'm{material}'\ncorners = [{a}, {b}]\ninward = {}", x[6] > 0.0),
            _ => format!(
                "shape = 'sphere'\nmaterial = 'm{material}'\ncentre = {a}\nradius = {:?}\nzone = {}\ninward = {}",
                x[3].abs(),
                if x[4] > 0.0 { "[-inf, inf]".to_owned() } else { toml(&x[5..7]) },
                x[7] > 0.0
            )
            .replace("NaN", "nan"),
        };
        writeln!(text, "[[objects]]\n{object}").expect("text");
    }
    text
}

/// Builds the scene with the builder, which checks numbers by itself.
fn build(random: &RandomScene) -> Result<Scene, Error> {
    let head = text(&[], &[0.0; 3], &[1.0; 3]);
    let mut scene = SceneBuilder::new("built");
    let surfaces: Vec<_> = Description::parse("head", &head)?
        .materials
        .iter()
        .map(|(_, surface)| scene.surface(surface.emitting(random.emission * surface.emission)))
        .collect();
    scene.background(DVec3::splat(random.background));
    for (kind, material, x) in &random.objects {
        let ([a, b, c], surface) = (
            [0, 3, 6].map(|i| DVec3::from_slice(&x[i..])),
            surfaces[*material],
        );
        match kind {
            0 | 2 => scene.rectangle(a, [b, c], surface),
            1 => scene.mesh(&[a, b, c], &[[0, 1, 2]], surface),
            _ => {
                let zone = if x[4] > 0.0 {
                    [f64::NEG_INFINITY, f64::INFINITY]
                } else {
                    [x[5], x[6]]
                };
                scene.sphere(
                    Sphere {
                        zone,
                        inward: x[7] > 0.0,
                        ..Sphere::new(a, x[3])
                    },
                    surface,
                );
            }
        }
    }
    let up = DVec3::new(0.1, 0.2, 1.0);
    scene.build(Camera::new(
        DVec3::from_array(random.eye),
        DVec3::from_array(random.target),
        up,
        random.half_height,
    ))
}

/// Ordinary numbers, half of them from a short list, and, if `wild`, now and then an extreme one.
fn number(wild: bool) -> impl Strategy<Value = f64> {
    let ordinary = prop_oneof![2 => prop::sample::select(vec![-1.0, -0.5, 0.0, 0.5, 1.0, 2.0]), 2 => -2.0..2.0];
    let extreme = vec![
        0.0, 1e-9, -1e-16, 1e-30, -1e-30, 1e-100, 1e-300, 5e-324, 1e7, -1e9, 1e12, 1e30, -1e30,
        1e100, 1e300, -1e300, 1.7e308,
    ];
    let none = vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let weight = if wild { 3 } else { 0 };
    prop_oneof![
        20 => ordinary,
        weight => prop::sample::select(extreme),
        u32::from(wild) => prop::sample::select(none),
    ]
}

/// Generates parts, some of them twice, with eye and target, all multiplied by a factor that is
/// usually 1.
fn random_scenes() -> impl Strategy<Value = RandomScene> {
    let scene = |wild: bool| {
        let object = (0..4_usize, 0..7_usize, prop::array::uniform9(number(wild)));
        let again = (
            prop::collection::vec(object, 1..4),
            prop::bool::weighted(0.25),
            0..7_usize,
            0..3_usize,
        );
        (
            again,
            prop::array::uniform3(number(wild)),
            prop::array::uniform3(number(false)),
            prop::array::uniform3(number(wild)),
            (0..18_usize, Just(wild)),
        )
    };
    let scales = [
        1e-300, 1e-100, 1e-40, 1e-30, 1e-29, 1e-15, 1e-9, 1e7, 1e9, 1e29, 1e30, 1e100, 1e300,
    ];
    prop_oneof![3 => scene(false), 2 => scene(true)].prop_map(
        move |((mut objects, twice, material, kind), eye, target, others, (scale, wild))| {
            if twice {
                let (old, _, x) = objects[0];
                // Repeated as it is, with another material, or at the camera's position.
                objects.push((
                    if kind == 2 { 3 } else { old },
                    if kind == 0 { objects[0].1 } else { material },
                    x,
                ));
            }
            let scale = scales.get(scale).copied().unwrap_or(1.0);
            let scaled = |x: [f64; 9]| x.map(|x| x * scale);
            let objects = objects
                .into_iter()
                .map(|(kind, material, x)| (kind, material, scaled(x)))
                .collect();
            let [emission, background, half_height] = others.map(f64::abs);
            RandomScene {
                objects,
                eye: eye.map(|x| x * scale),
                target: target.map(|x| x * scale),
                emission,
                background,
                half_height,
                far_apart: wild,
            }
        },
    )
}

/// Returns a film, or `None` if its refusal says in one line that a light is too bright or a thing
/// too far away.
fn film_unless_refused(film: Result<Film, Error>, what: &str, scene: &str) -> Option<Film> {
    match film {
        Ok(film) => Some(film),
        Err(Error::Radiance { value, .. }) if value > LARGEST && value.is_finite() => None,
        Err(Error::Option(message)) if message.contains("distances at most") => None,
        Err(error) => panic!("{what}: {error}\n{scene}"),
    }
}

/// Renders with every estimator.
fn renders(scene: &Scene, text: &str, far_apart: bool) {
    let sampling = Sampling {
        silhouettes: true,
        ..sampling(Random, SamplerKind::Sobol(2), 1)
    };
    for (strategy, specular_nee) in [
        (PathStrategy::Mis, false),
        (PathStrategy::Mis, true),
        (PathStrategy::Bsdf, false),
    ] {
        let path = Path {
            specular_nee,
            ..Path::new(strategy)
        };
        let alone = path.with_parts(Parts::replaced(&ScalarParts));
        let film = rendered(scene, &alone, FRAME, sampling, &[0..1]);
        let one_by_one = film_unless_refused(film, "path", text);
        let lanes = lanes(LaneEstimator::Path(path), sampling, Precision::Double);
        let eight = film_unless_refused(filled(&lanes, scene, FRAME, 0..1), "lanes", text);
        // Where rounding is as large as the objects, the engines may disagree on hits.
        assert!(
            far_apart || one_by_one == eight,
            "the widths differ\n{text}"
        );
    }
    let by_angle = Path {
        lights: LightSampling::SolidAngle,
        ..Path::new(PathStrategy::Mis)
    };
    let plain = Sampling {
        silhouettes: false,
        ..sampling
    };
    let whitted = Whitted::new(TransportRules::PHYSICAL);
    let lookup = Lookup::DirectVisualization;
    let photons = PhotonMapping::new(
        Parts::default(),
        scene,
        lookup,
        20,
        0.1,
        ImagePass::independent(1, 0),
    );
    let rays =
        |estimator: &dyn Estimator, sampling| rendered(scene, estimator, FRAME, sampling, &[0..1]);
    let images = |estimator: &dyn ImageEstimator| passes(scene, estimator, FRAME, &[0..1]);
    for (what, film) in [
        ("solid angles", rays(&by_angle, sampling)),
        ("whitted", rays(&whitted, sampling)),
        ("report", rays(&Report::default(), plain)),
        ("photons", photons.and_then(|map| rays(&map, sampling))),
        ("bdpt", images(&Bdpt::new(Parts::default()))),
        ("light tracer", images(&LightTracer::default())),
        ("sppm", images(&sppm(Parts::default(), 20, 0.1))),
    ] {
        film_unless_refused(film, what, text);
    }
}

/// Asserts that a refusal is one line.
fn refused(error: &Error, text: &str) {
    let message = error.to_string();
    assert!(
        matches!(error, Error::Scene { .. }) && !message.contains('\n') && message.len() < 1000,
        "{message}\n{text}"
    );
}

#[test]
fn degenerate_scenes_are_refused_or_rendered() {
    let counts = [0; 4].map(AtomicU32::new);
    let count = |i: usize| counts[i].fetch_add(1, Ordering::Relaxed);
    let cases = context("").arguments(4000) as u32;
    property("degenerate", cases, &random_scenes(), |random| {
        let text = text(&random.objects, &random.eye, &random.target);
        let begun = std::time::Instant::now();
        match Description::parse("drawn", &text).and_then(|scene| scene.build()) {
            Ok(scene) => {
                count(0);
                renders(&scene, &text, random.far_apart);
            }
            Err(error) => {
                count(1);
                refused(&error, &text);
            }
        }
        match build(&random) {
            Ok(scene) => {
                count(2);
                renders(&scene, &format!("{text}\n{random:?}"), random.far_apart);
            }
            Err(error) => {
                count(3);
                refused(&error, &text);
            }
        }
        assert!(
            begun.elapsed().as_secs() < 30,
            "it takes {:?}\n{text}",
            begun.elapsed()
        );
    });
    // Both acceptance and refusal happen often, by either route.
    let counts = counts.map(AtomicU32::into_inner);
    println!("{counts:?}");
    assert!(counts.iter().all(|count| *count > cases / 10), "{counts:?}");
}

/// Rays that start within a light meet it.
#[test]
fn an_eye_within_a_light_sees_it_by_every_estimator() {
    let vertices = [
        5e-16,
        -5e-16,
        1e-15,
        -1e-15,
        1.0602016381694621e-15,
        1e-15,
        -1e-15,
        -1e-15,
        1e-15,
    ];
    let random = RandomScene {
        objects: vec![(1, 0, vertices)],
        eye: [-5e-16, -5e-16, 1e-15],
        target: [1e-15, -5e-16, -1.2511715515027689e-15],
        emission: 0.5,
        background: 1.0,
        half_height: 1.0,
        far_apart: false,
    };
    renders(
        &build(&random).expect("a scene"),
        "an eye within a light",
        false,
    );
}
