//! The room of the trial, and paths in it from a light to the eye with their densities in closed
//! form.

use whitefurnace::light::emitter::{Emitter, EmitterShape, LightSampling};
use whitefurnace::math::frame::{Frame, azimuth};
use whitefurnace::sampling::warp::cosine_hemisphere_inverse;

use crate::glass::{GLASS, INDEX};
use crate::mean_radiance::any_direction;
use crate::path_weights::{density, probabilities};
use crate::prelude::*;
use crate::scenes::{FLOOR, ball, lambert, mirror, panel, pick_probabilities, seen_by, square};

const EYE: DVec3 = DVec3::new(0.2, -1.8, 1.3);
const TARGET: DVec3 = DVec3::new(0.1, 0.3, 1.0);
const HALF_HEIGHT: f64 = 0.7;
pub(super) const FRAME: [u32; 2] = [8, 6];
pub(super) const EMITTERS: usize = 4;

/// Roulette numbers: `SURVIVE` always survives, `TERMINATE` ends the path. `TERMINATE` also fills
/// in for missing numbers.
pub(super) const SURVIVE: f64 = 0.0;
pub(super) const TERMINATE: f64 = 0.999_999;

/// Builds a room with mirrors, glass, and four lights from a speck to a wall, one of them inside
/// the glass.
pub(super) fn room() -> Arc<Scene> {
    let camera = Camera::new(EYE, TARGET, DVec3::Z, HALF_HEIGHT);
    seen_by(camera, "lights large, small and in glass", |s| {
        let wall = Surface::new(lambert(FLOOR));
        for (height, up) in [(0.0, true), (3.0, false)] {
            square(s, height * DVec3::Z, 2.0, up, wall);
        }
        let high = 3.0 * DVec3::Z;
        for side in [-2.0, 2.0] {
            panel(s, DVec3::new(side, -2.0, 0.0), [4.0 * DVec3::Y, high], wall);
            panel(s, DVec3::new(-2.0, side, 0.0), [4.0 * DVec3::X, high], wall);
        }
        let shining = |radiance: f64, albedo: f64| {
            Surface::new(lambert(albedo)).emitting(DVec3::splat(radiance))
        };
        let black = Surface::new(Bsdf::Black).emitting(DVec3::splat(400.0));
        square(s, DVec3::new(0.5, 0.4, 2.8), 0.02, false, black);
        square(
            s,
            DVec3::new(-0.5, -0.2, 2.9),
            0.5,
            false,
            shining(50.0, 0.3),
        );
        panel(
            s,
            DVec3::new(-1.9, -1.5, 0.3),
            [3.0 * DVec3::Y, 2.0 * DVec3::Z],
            shining(20.0, 0.6),
        );
        let centre = DVec3::new(-0.6, 0.8, 0.9);
        ball(s, Sphere::new(centre, 0.25), shining(30.0, 0.5));
        ball(s, Sphere::new(centre, 0.8), Surface::new(GLASS));
        let mirror = Surface::new(mirror(0.9));
        ball(s, Sphere::new(DVec3::new(0.9, 0.9, 0.6), 0.5), mirror);
        panel(
            s,
            DVec3::new(1.9, 1.5, 0.2),
            [-3.0 * DVec3::Y, 2.5 * DVec3::Z],
            mirror,
        );
    })
}

/// A vertex of a path.
#[derive(Clone, Copy)]
pub(super) struct Vertex {
    pub point: DVec3,
    /// Unit normal of the front side.
    pub normal: DVec3,
    pub emitter: Option<u32>,
    pub kind: Kind,
    /// Refractive index of the medium that the path is in, at a vertex that is not specular.
    pub index: f64,
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Diffuse,
    Mirror,
    /// Glass, with the random number that selects reflection or transmission.
    Glass(f64),
    Black,
}

impl Vertex {
    pub fn is_specular(&self) -> bool {
        matches!(self.kind, Kind::Mirror | Kind::Glass(_))
    }

    fn cosine(&self, to: DVec3) -> f64 {
        (to - self.point).normalize().dot(self.normal).abs()
    }

    /// Returns the random numbers of a cosine-weighted direction to a point.
    pub fn direction(&self, to: DVec3) -> [f64; 2] {
        let w = (to - self.point).normalize();
        let oriented = self.normal * self.normal.dot(w).signum();
        cosine_hemisphere_inverse(Frame::new(oriented).local(w))
    }
}

/// Returns the direction after a specular vertex, and whether it is transmitted, by Snell's law in
/// vectors.
fn specular_direction(d: DVec3, front: DVec3, glass: bool, through: bool) -> (DVec3, bool) {
    let normal = front * -front.dot(d).signum();
    let along = d - d.dot(normal) * normal;
    let ratio = if front.dot(d) < 0.0 {
        1.0 / INDEX
    } else {
        INDEX
    };
    let tangential = ratio * along;
    if glass && through && tangential.length_squared() < 0.99 {
        (
            tangential - normal * (1.0 - tangential.length_squared()).sqrt(),
            true,
        )
    } else {
        (d - 2.0 * d.dot(normal) * normal, false)
    }
}

/// Least cosines and distances of a path: below these, rounding would show.
const MIN_COSINE: f64 = 0.05;
const MIN_DISTANCE: f64 = 0.1;
const MAX_VERTICES: usize = 6;

/// Traces a random path from the eye to an emitter; its vertices are returned from the emitter on.
pub(super) fn trace(scene: &Scene, rng: &mut Stream, [x, y]: [f64; 2]) -> Option<Vec<Vertex>> {
    let mut ray = scene.camera().ray(FRAME, x, y);
    let (mut path, mut index) = (Vec::new(), 1.0);
    while path.len() < MAX_VERTICES {
        let hit = scene.intersect(&ray)?;
        let cosine = -hit.normal.dot(ray.direction);
        if cosine.abs() < MIN_COSINE || hit.t < MIN_DISTANCE {
            return None;
        }
        let bsdf = &scene.surface(&hit).bsdf;
        let (glass, through) = (matches!(bsdf, Bsdf::Glass { .. }), uniform(rng) < 0.7);
        let (way, transmitted) = specular_direction(ray.direction, hit.normal, glass, through);
        let kind = match bsdf {
            Bsdf::Glass { .. } => Kind::Glass(if transmitted { TERMINATE } else { 0.0 }),
            Bsdf::Mirror { .. } => Kind::Mirror,
            Bsdf::Black => Kind::Black,
            _ => Kind::Diffuse,
        };
        path.push(Vertex {
            point: hit.point,
            normal: hit.normal,
            emitter: hit.emitter.filter(|_| cosine > 0.0),
            kind,
            index,
        });
        if path[path.len() - 1].emitter.is_some() && (kind == Kind::Black || uniform(rng) < 0.5) {
            path.reverse();
            return Some(path);
        }
        let direction = match kind {
            Kind::Black => return None,
            Kind::Mirror | Kind::Glass(_) => {
                if transmitted {
                    index = if cosine > 0.0 { INDEX } else { 1.0 };
                }
                way
            }
            Kind::Diffuse if uniform(rng) < 0.5 => {
                let pick = (uniform(rng) * EMITTERS as f64) as usize;
                let light = scene.emitters()[pick].sample(uniform2(rng));
                (light.point - hit.point).normalize()
            }
            Kind::Diffuse => any_direction(rng),
        };
        let onward = direction.dot(hit.normal);
        let same_side = onward * cosine > 0.0;
        if onward.abs() < MIN_COSINE || (kind == Kind::Diffuse && !same_side) {
            return None;
        }
        ray = scene.spawn_ray(hit.point, hit.normal, direction);
    }
    None
}

/// Returns the area of an emitter, and the random numbers that sample a point on it.
pub(super) fn area_and_sample(shape: &EmitterShape, point: DVec3) -> (f64, [f64; 2]) {
    match *shape {
        EmitterShape::Rectangle { corner, edges } => (
            edges[0].length() * edges[1].length(),
            edges.map(|e| e.dot(point - corner) / e.length_squared()),
        ),
        EmitterShape::Sphere(Sphere { centre, radius, .. }) => {
            let at = (point - centre) / radius;
            (
                2.0 * TAU * radius * radius,
                [0.5 + 0.5 * at.z, azimuth(at) / TAU],
            )
        }
        EmitterShape::Triangle(_) => (f64::NAN, [f64::NAN; 2]),
    }
}

/// Returns the probabilities with which particles start on the emitters, all of which are white.
pub(super) fn pick_pmf(scene: &Scene) -> Vec<f64> {
    let flux =
        |emitter: &Emitter| emitter.radiance.x * area_and_sample(&emitter.shape, DVec3::ZERO).0;
    pick_probabilities(&scene.emitters().iter().map(flux).collect::<Vec<_>>())
}

/// Returns the random number in the middle of the interval that picks an emitter by its
/// probability.
pub(super) fn middle_of_interval(pmf: &[f64], emitter: usize) -> f64 {
    pmf[..emitter].iter().sum::<f64>() + 0.5 * pmf[emitter]
}

/// Returns the random numbers with which a shadow ray from a path's second vertex, which is not
/// specular, samples its first, and the density of that with respect to area.
pub(super) fn shadow_ray_sample(scene: &Scene, path: &[Vertex]) -> ([f64; 3], f64) {
    const LIGHTS: LightSampling = LightSampling::Importance;
    let (light, from) = (&path[0], path[1].point);
    let index = light.emitter.map_or(0, |index| index as usize);
    let (emitter, probabilities) = (
        &scene.emitters()[index],
        probabilities(scene.emitters(), LIGHTS, from),
    );
    let mut on_light = area_and_sample(&emitter.shape, light.point).1;
    if let EmitterShape::Sphere(sphere) = emitter.shape {
        // The cone around the sphere is sampled by 1 − cos and by the azimuth around its axis.
        let to_centre = sphere.centre - from;
        let [towards, axis] = [light.point - from, to_centre].map(DVec3::normalize);
        let cosine = (1.0 - (sphere.radius / to_centre.length()).powi(2)).sqrt();
        let around = Frame::new(-axis).local(light.point - sphere.centre);
        on_light = [
            0.5 * (towards - axis).length_squared() / (1.0 - cosine),
            azimuth(around) / TAU,
        ];
    }
    let by_angle = density(
        emitter,
        LIGHTS,
        from,
        (light.point, light.normal),
        probabilities[index],
    );
    let per_area = light.cosine(from) / from.distance_squared(light.point);
    (
        [
            middle_of_interval(&probabilities, index),
            on_light[0],
            on_light[1],
        ],
        by_angle * per_area,
    )
}

/// Densities in closed form of the light's walk and the eye's at each vertex; `None` where the walk
/// arrives from a specular vertex: cos θ cos θ′/(π d²), pick/A on an emitter, and for the eye its
/// share of the image's area at distance 1.
pub(super) fn known_densities(scene: &Scene, path: &[Vertex]) -> Vec<[Option<f64>; 2]> {
    let walk = |from: &Vertex, to: &Vertex| {
        let distance_squared = from.point.distance_squared(to.point);
        let density = from.cosine(to.point) * to.cosine(from.point) * FRAC_1_PI / distance_squared;
        (!from.is_specular()).then_some(density)
    };
    let start = |x: &Vertex| {
        let index = x.emitter? as usize;
        Some(pick_pmf(scene)[index] / area_and_sample(&scene.emitters()[index].shape, x.point).0)
    };
    let seen = |x: &Vertex| {
        let away = x.point - EYE;
        let depth = away.normalize().dot((TARGET - EYE).normalize());
        let [width, height] = FRAME.map(f64::from);
        let image = (2.0 * HALF_HEIGHT).powi(2) * width / height;
        Some(x.cosine(EYE) / (away.length_squared() * image * depth.powi(3)))
    };
    (0..path.len())
        .map(|i| {
            let x = &path[i];
            let before = i.checked_sub(1).map(|i| &path[i]);
            let after = path.get(i + 1);
            [
                before.map_or_else(|| start(x), |from| walk(from, x)),
                after.map_or_else(|| seen(x), |from| walk(from, x)),
            ]
        })
        .collect()
}

/// Density of a path by each strategy, up to a common factor; `None` if the strategy cannot make
/// it.
///
/// Across mirrors and glass n² cos θ dω dA is conserved, so the two walks' densities from one end
/// of a specular chain to the other have the ratio of the two n². A shadow ray picks its light by
/// its importance.
pub(super) fn strategy_pdfs(
    scene: &Scene,
    path: &[Vertex],
    known: &[[Option<f64>; 2]],
) -> Vec<Option<f64>> {
    let factors = path.iter().zip(known).enumerate().map(|(i, (x, density))| {
        if x.is_specular() {
            return [1.0, 1.0];
        }
        let end = path[..i].iter().rev().find(|end| !end.is_specular());
        let chain = end.map_or(f64::NAN, |end| (x.index / end.index).powi(2));
        [density[0].unwrap_or(chain), density[1].unwrap_or(1.0)]
    });
    let factors: Vec<[f64; 2]> = factors.collect();
    let open = |i: usize| path.get(i).is_none_or(|x| !x.is_specular());
    (0..=path.len())
        .map(|s| {
            let exists = s == 0 || (open(s - 1) && open(s));
            let light: f64 = if exists && s == 1 && path.len() > 1 {
                shadow_ray_sample(scene, path).1
            } else {
                factors[..s].iter().map(|f| f[0]).product()
            };
            let eye: f64 = factors[s..].iter().map(|f| f[1]).product();
            exists.then_some(light * eye)
        })
        .collect()
}
