//! Scenes with the features of a row, in which the incident red radiance is 1 everywhere as far as
//! surfaces conserve energy.

use whitefurnace::light::environment::{Environment, EnvironmentMap};
use whitefurnace::material::ggx::Ggx;
use whitefurnace::material::rough_glass::RoughGlass;
use whitefurnace::scene::COINCIDENCE_TOLERANCE;

use super::table::{Factor, Row};
use crate::prelude::*;

pub const SHAPES: &[&str] = &[
    "sphere",
    "zones",
    "hollow",
    "rectangles",
    "box",
    "mesh",
    "twins",
    "twins reversed",
];
pub const MATERIALS: &[&str] = &[
    "black",
    "lambert",
    "oren-nayar",
    "eon",
    "mirror",
    "glass",
    "rough glass",
    "ggx",
    "absorbing",
];
pub const EMITTERS: &[&str] = &[
    "none",
    "rectangles",
    "triangles",
    "sphere",
    "zones",
    "several",
    "sheets",
    "sheets reversed",
];
pub const EMISSIONS: &[&str] = &["black", "lambert", "mirror", "glass", "ggx"];
pub const BACKGROUNDS: &[&str] = &["dark", "constant", "map", "closed sphere", "closed box"];
pub const CASTERS: &[&str] = &["none", "flat mirror", "mirror ball", "glass ball"];
pub const NESTINGS: &[&str] = &["none", "glass in glass", "air in glass", "lambert in glass"];

/// Factors of a scene.
pub const SCENE: [Factor; 11] = [
    ("a shape", SHAPES),
    ("a material", MATERIALS),
    ("b shape", SHAPES),
    ("b material", MATERIALS),
    ("c material", MATERIALS),
    ("emitter", EMITTERS),
    ("emission", EMISSIONS),
    ("background", BACKGROUNDS),
    ("caster", CASTERS),
    ("nesting", NESTINGS),
    ("eye", &["outside", "in glass"]),
];

const INDEX: f64 = 1.5;
/// Largest coordinate of all scenes: the radius of a closed sphere.
const EXTENT: f64 = 6.0;
/// Distance of twin balls and of sheets back to back: just above that at which they would be
/// refused as coincident.
const GAP: f64 = 1.25 * COINCIDENCE_TOLERANCE * EXTENT;
/// Albedo of the walls of closed scenes.
const WALL: f64 = 0.4;

/// Returns the red radiance at the camera, if it has a closed form: nothing absorbs light or loses
/// it, and all emitters emit the share that they do not reflect.
pub fn exact(row: &Row) -> Option<f64> {
    if row.is("background", "dark") && row.is("emitter", "none") {
        return Some(0.0);
    }
    let conserves = ["lambert", "mirror", "glass", "absorbing"];
    let objects = ["a material", "b material", "c material"]
        .iter()
        .all(|object| conserves.contains(&row.get(object)));
    let emitters =
        row.is("emitter", "none") || ["black", "lambert", "mirror"].contains(&row.get("emission"));
    let within = if row.is("eye", "in glass") {
        INDEX * INDEX
    } else {
        1.0
    };
    (objects && emitters).then_some(within)
}

/// Returns a material that reflects this share of red light and less of the others, as far as it
/// has such a parameter.
fn material(name: &str, red: f64) -> Surface {
    let albedo = DVec3::new(red, 0.6 * red, 0.3 * red);
    Surface::new(match name {
        "black" => Bsdf::Black,
        "oren-nayar" => Bsdf::oren_nayar(albedo, 0.5, OrenNayarForm::Corrected),
        "eon" => Bsdf::Eon {
            albedo,
            roughness: 0.6,
        },
        "mirror" => Bsdf::Mirror {
            reflectance: albedo,
        },
        "glass" => Bsdf::Glass { index: INDEX },
        "rough glass" => Bsdf::RoughGlass(RoughGlass {
            index: INDEX,
            alpha: 0.5,
        }),
        "ggx" => Bsdf::model(Ggx {
            reflectance: albedo,
            alpha: 0.5,
        }),
        _ => Bsdf::Lambert { albedo },
    })
    .absorbing(if name == "absorbing" { 0.3 } else { 0.0 })
}

/// Returns a surface that emits the share of red light that it does not reflect, and other amounts
/// of green and blue.
fn emission(name: &str) -> Surface {
    let red = match name {
        "black" => 0.0,
        "glass" => 1.0,
        _ => 0.5,
    };
    let rest = if name == "glass" { 0.5 } else { 1.0 - red };
    material(name, red).emitting(rest * DVec3::new(1.0, 3.0, 2.0))
}

fn add_mesh(s: &mut SceneBuilder, mesh: Mesh, centre: DVec3, size: f64, surface: Surface) {
    let mesh = mesh.map(|v| centre + size * v);
    let surface = s.surface(surface);
    s.mesh(&mesh.vertices, &mesh.triangles, surface);
}

/// Adds a closed body that fits in a ball of this radius.
fn body(s: &mut SceneBuilder, shape: &str, centre: DVec3, radius: f64, surface: Surface) {
    let sphere = Sphere::new(centre, radius);
    match shape {
        "sphere" => ball(s, sphere, surface),
        "twins" | "twins reversed" => {
            let mut radii = [radius, radius - GAP];
            if shape == "twins reversed" {
                radii.reverse();
            }
            radii
                .into_iter()
                .for_each(|radius| ball(s, Sphere { radius, ..sphere }, surface));
        }
        "sheets" | "sheets reversed" => {
            let (half, surface) = (0.55 * radius, s.surface(surface));
            let [x, y] = [2.0 * half * DVec3::X, 2.0 * half * DVec3::Y];
            let corner = centre - 0.5 * (x + y);
            let mut sheets = [(corner + GAP * DVec3::Z, [x, y]), (corner, [y, x])];
            if shape == "sheets reversed" {
                sheets.reverse();
            }
            sheets
                .into_iter()
                .for_each(|(corner, edges)| s.rectangle(corner, edges, surface));
        }
        "hollow" => {
            ball(s, sphere, surface);
            ball(s, inward(Sphere::new(centre, 0.7 * radius)), surface);
        }
        "zones" => {
            let cuts = [-1.0, -0.3, 0.4, 1.0].map(|cut: f64| cut * radius);
            let zone = |low: f64, high: f64| {
                [
                    if low == -radius {
                        f64::NEG_INFINITY
                    } else {
                        low
                    },
                    if high == radius { f64::INFINITY } else { high },
                ]
            };
            for ends in cuts.windows(2) {
                ball(
                    s,
                    Sphere {
                        zone: zone(ends[0], ends[1]),
                        ..sphere
                    },
                    surface,
                );
            }
        }
        "box" => add_mesh(s, Mesh::cube(), centre, 0.55 * radius, surface),
        "triangles" => {
            let vertices = [
                DVec3::new(1.0, 0.0, -0.3),
                DVec3::new(-0.5, 0.8, -0.3),
                DVec3::new(-0.5, -0.8, -0.3),
                DVec3::Z,
            ];
            let triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
            add_mesh(
                s,
                Mesh {
                    vertices: vertices.to_vec(),
                    triangles,
                },
                centre,
                radius,
                surface,
            );
        }
        "mesh" => add_mesh(s, Mesh::globe(6, 8), centre, radius, surface),
        _ => {
            let (half, surface) = (0.55 * radius, s.surface(surface));
            for [x, y, z] in [
                [DVec3::X, DVec3::Y, DVec3::Z],
                [DVec3::Y, DVec3::Z, DVec3::X],
                [DVec3::Z, DVec3::X, DVec3::Y],
            ] {
                let [x, y, z] = [half * x, half * y, half * z];
                s.rectangle(centre - x - y + z, [2.0 * x, 2.0 * y], surface);
                s.rectangle(centre - x - y - z, [2.0 * y, 2.0 * x], surface);
            }
        }
    }
}

/// Returns a map whose red is 1 everywhere and whose other colours, which affect its sampling,
/// vary.
fn map() -> Environment {
    let pixel = |i: usize| DVec3::new(1.0, (i % 3) as f64, (i * i % 5) as f64);
    let map = EnvironmentMap::new(
        [6, 3],
        (0..18).map(pixel).collect(),
        DVec3::new(0.2, 0.1, 1.0),
        DVec3::Y,
    );
    Environment::Map(map.expect("a map"))
}

/// Builds the scene of a row.
pub fn scene_of(row: &Row) -> Scene {
    let eye = DVec3::new(0.0, -4.0, 0.4);
    let camera = Camera::new(eye, DVec3::new(0.0, 0.0, 0.1), DVec3::Z, 0.55);
    scene_from(camera, |s| {
        let wall = material("lambert", WALL).emitting((1.0 - WALL) * DVec3::new(1.0, 0.5, 2.0));
        match row.get("background") {
            "constant" => s.background(DVec3::new(1.0, 2.0, 0.5)),
            "map" => s.environment(map()),
            "closed sphere" => ball(s, inward(Sphere::new(DVec3::ZERO, EXTENT)), wall),
            "closed box" => {
                let wall = s.surface(wall);
                simple::closed_cube(s, 5.0, true, wall);
            }
            _ => {}
        }
        for (object, x) in [("a", -0.75), ("b", 0.75)] {
            let [shape, of] =
                ["shape", "material"].map(|what| row.get(&format!("{object} {what}")));
            body(s, shape, DVec3::new(x, 0.0, 0.0), 0.6, material(of, 1.0));
        }
        let floor = Mesh::cube().map(|v| v * DVec3::new(1.8, 1.2, 0.1) - 0.9 * DVec3::Z);
        add_mesh(
            s,
            floor,
            DVec3::ZERO,
            1.0,
            material(row.get("c material"), 1.0),
        );
        let light = emission(row.get("emission"));
        match row.get("emitter") {
            "none" => {}
            "several" => {
                for (i, shape) in ["sphere", "rectangles", "mesh", "zones"]
                    .into_iter()
                    .enumerate()
                {
                    let at = DVec3::new(0.7 * i as f64 - 1.05, 0.1 * i as f64, 1.0);
                    let light = if i == 1 { emission("black") } else { light };
                    body(s, shape, at, 0.25, light);
                }
            }
            shape => body(s, shape, DVec3::new(0.0, -0.2, 1.0), 0.5, light),
        }
        match row.get("caster") {
            "flat mirror" => {
                // A thin box, as a mirror must have a back.
                let plate = Mesh::cube()
                    .map(|v| v * DVec3::new(3.0, 0.02, 2.0) + DVec3::new(0.0, 1.4, 0.2));
                add_mesh(s, plate, DVec3::ZERO, 1.0, material("mirror", 1.0));
            }
            "mirror ball" => ball(
                s,
                Sphere::new(DVec3::new(0.0, -0.7, -0.4), 0.38),
                material("mirror", 1.0),
            ),
            "glass ball" => ball(
                s,
                Sphere::new(DVec3::new(0.0, -0.7, -0.4), 0.38),
                material("glass", 1.0),
            ),
            _ => {}
        }
        let centre = DVec3::new(0.0, 0.7, -0.2);
        if !row.is("nesting", "none") {
            ball(s, Sphere::new(centre, 0.35), glass(INDEX));
        }
        match row.get("nesting") {
            "glass in glass" => ball(s, Sphere::new(centre, 0.2), glass(1.2)),
            "air in glass" => ball(s, Sphere::new(centre, 0.2), glass(INDEX.recip())),
            "lambert in glass" => ball(s, Sphere::new(centre, 0.2), material("lambert", 1.0)),
            _ => {}
        }
        if row.is("eye", "in glass") {
            ball(s, Sphere::new(eye, 0.1), glass(INDEX));
        }
    })
}
