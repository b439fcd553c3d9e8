//! Scenes that no one would draw: flat, coincident, nested, tiny, huge, not finite. Each is refused
//! in one line or rendered.

use std::fmt::Write as _;
use std::sync::atomic::{AtomicU32, Ordering};

use whitefurnace::integrator::{Path, Strategy as Finds};
use whitefurnace::render::{LaneEstimator, render_lanes};
use whitefurnace::scene::file::Description;

use crate::prelude::*;

const FRAME: [u32; 2] = [4, 3];

/// Materials by their place in the list.
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

/// An object by its kind, its material and nine numbers.
type Part = (usize, usize, [f64; 9]);

/// Parts, eye and target; and what the builder alone takes beyond a scene file: emission,
/// background, image height. Last, whether numbers are far apart in size.
type Drawn = (Vec<Part>, [f64; 3], [f64; 3], [f64; 3], bool);

/// What cannot be printed in a scene file is printed otherwise in Rust.
fn toml(x: &[f64]) -> String {
    format!("{x:?}").replace("NaN", "nan")
}

/// The scene file of these parts.
fn text(parts: &[Part], eye: &[f64; 3], target: &[f64; 3]) -> String {
    let mut text = format!(
        "background = 0.25\ncamera = {{ eye = {}, target = {}, up = [0.1, 0.2, 1], fov_deg = 60 }}\n{MATERIALS}",
        toml(eye),
        toml(target)
    );
    for (kind, material, x) in parts {
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

/// The same scene by the builder, which has its own say about numbers.
fn built(
    (parts, eye, target, [emission, background, half_height], _): &Drawn,
) -> Result<Scene, Error> {
    let head = text(&[], &[0.0; 3], &[1.0; 3]);
    let mut scene = SceneBuilder::new("built");
    let surfaces: Vec<_> = Description::parse("head", &head)?
        .materials
        .iter()
        .map(|(_, surface)| scene.surface(surface.emitting(*emission * surface.emission)))
        .collect();
    scene.background(DVec3::splat(*background));
    for (kind, material, x) in parts {
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
        DVec3::from_array(*eye),
        DVec3::from_array(*target),
        up,
        *half_height,
    ))
}

/// Ordinary numbers, of which half are of a few, and now and then one that is not.
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

/// Parts, of which some are there twice, with eye and target; all multiplied by a number that is 1
/// more often than not.
fn parts() -> impl Strategy<Value = Drawn> {
    let scene = |wild: bool| {
        let part = (0..4_usize, 0..7_usize, prop::array::uniform9(number(wild)));
        let again = (
            prop::collection::vec(part, 1..4),
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
        move |((mut parts, twice, material, kind), eye, target, others, (scale, wild))| {
            if twice {
                let (old, _, x) = parts[0];
                // As it is, of another material, or as the camera's own place.
                parts.push((
                    if kind == 2 { 3 } else { old },
                    if kind == 0 { parts[0].1 } else { material },
                    x,
                ));
            }
            let scale = scales.get(scale).copied().unwrap_or(1.0);
            let scaled = |x: [f64; 9]| x.map(|x| x * scale);
            let parts = parts
                .into_iter()
                .map(|(kind, material, x)| (kind, material, scaled(x)))
                .collect();
            (
                parts,
                eye.map(|x| x * scale),
                target.map(|x| x * scale),
                others.map(f64::abs),
                wild,
            )
        },
    )
}

/// Whether a film is of radiances; a light too bright or a thing too far away for any film is said
/// in one line.
fn fits(film: Result<Film, Error>, what: &str, scene: &str) -> Option<Film> {
    match film {
        Ok(film) => Some(film),
        Err(Error::Radiance { value, .. }) if value > LARGEST && value.is_finite() => None,
        Err(Error::Option(message)) if message.contains("distances at most") => None,
        Err(error) => panic!("{what}: {error}\n{scene}"),
    }
}

/// Renders by every way there is.
fn renders(scene: &Scene, text: &str, far_apart: bool) {
    let sampling = Sampling {
        pixel: Random,
        numbers: Numbers::Sobol(2),
        seed: 1,
        outlines: true,
    };
    for (strategy, by_bodies) in [
        (Finds::Mis, false),
        (Finds::Mis, true),
        (Finds::Bsdf, false),
    ] {
        let path = Path {
            by_bodies,
            ..Path::<Standard>::new(Standard, strategy)
        };
        let alone = Path {
            by_bodies,
            ..Path::new(OneByOne, strategy)
        };
        let one_by_one = fits(
            rendered(scene, &alone, FRAME, sampling, &[0..1]),
            "path",
            text,
        );
        let mut film = Film::new(FRAME, None, 2).expect("a film");
        let lanes = render_lanes(
            scene,
            LaneEstimator::Path(path),
            sampling,
            &mut film,
            &(0..1),
            &|_| true,
        );
        let eight = fits(lanes.map(|_| film), "lanes", text);
        // Where rounding is as large as what is met, each may meet it or not.
        assert!(
            far_apart || one_by_one == eight,
            "the widths differ\n{text}"
        );
    }
    let area = Path {
        lights: LightSampling::SolidAngle,
        ..Path::<Standard>::new(Standard, Finds::Mis)
    };
    fits(
        rendered(scene, &area, FRAME, sampling, &[0..1]),
        "solid angles",
        text,
    );
    fits(
        rendered(
            scene,
            &Whitted::new(LightRules::PHYSICAL),
            FRAME,
            sampling,
            &[0..1],
        ),
        "whitted",
        text,
    );
    let plain = Sampling {
        outlines: false,
        ..sampling
    };
    fits(
        rendered(scene, &Report::default(), FRAME, plain, &[0..1]),
        "report",
        text,
    );
    let photons = PhotonMapping::new(Standard, scene, Lookup::Direct, 20, 0.1, (1, 0));
    fits(
        photons.and_then(|photons| rendered(scene, &photons, FRAME, sampling, &[0..1])),
        "photons",
        text,
    );
    fits(
        passes(scene, &Bdpt::new(Standard), FRAME, &[0..1]),
        "bdpt",
        text,
    );
    fits(
        passes(scene, &LightTracer::<Standard>::default(), FRAME, &[0..1]),
        "light tracer",
        text,
    );
    fits(
        passes(
            scene,
            &Sppm {
                parts: Standard,
                particles: 20,
                radius: 0.1,
            },
            FRAME,
            &[0..1],
        ),
        "sppm",
        text,
    );
}

/// Whether a refusal is one line.
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
    property("degenerate", cases, &parts(), |drawn| {
        let text = text(&drawn.0, &drawn.1, &drawn.2);
        let begun = std::time::Instant::now();
        match Description::parse("drawn", &text).and_then(|scene| scene.build()) {
            Ok(scene) => {
                count(0);
                renders(&scene, &text, drawn.4);
            }
            Err(error) => {
                count(1);
                refused(&error, &text);
            }
        }
        match built(&drawn) {
            Ok(scene) => {
                count(2);
                renders(&scene, &format!("{text}\n{:?}", drawn.3), drawn.4);
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
    // Both happen often, by either way.
    let counts = counts.map(AtomicU32::into_inner);
    println!("{counts:?}");
    assert!(counts.iter().all(|count| *count > cases / 10), "{counts:?}");
}

/// Rays from within a light that meet it where they start.
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
    let (eye, target) = (
        [-5e-16, -5e-16, 1e-15],
        [1e-15, -5e-16, -1.2511715515027689e-15],
    );
    let drawn = (vec![(1, 0, vertices)], eye, target, [0.5, 1.0, 1.0], false);
    renders(
        &built(&drawn).expect("a scene"),
        "an eye within a light",
        false,
    );
}
