//! Bidirectional path tracing on one path at a time, made by every strategy in turn with chosen random
//! numbers: densities, weights and values against closed forms.

use std::cell::{Cell, RefCell};
use std::f64::consts::{FRAC_1_PI, TAU};
use std::sync::Arc;

use glam::DVec3;
use rand::TryRng;

use super::probes::any_direction;
use super::scenes::{FLOOR, lambert, seen_by, square};
use super::subject::{RIGHT, Table};
use crate::bsdf::Bsdf;
use crate::camera::Camera;
use crate::emitter::EmitterShape;
use crate::equation::{
    COSINE_HEMISPHERE, GEOMETRY, IMPORTANCE, MIS, PATH_DENSITY, REFRACTION, SOLID_ANGLE,
};
use crate::estimator::{Bdpt, Density, weight};
use crate::frame::{Frame, azimuth};
use crate::harness::outcome::Outcome;
use crate::harness::pointwise::{Largest, relative};
use crate::harness::trial::Context;
use crate::rng::{Stream, uniform, uniform2};
use crate::sampler::{LIGHT, Sampler};
use crate::sampling::cosine_hemisphere_inverse;
use crate::scene::{Scene, Surface};
use crate::shape::Sphere;
use crate::splat::Splats;
use crate::zoo::{AnyFamily, Bench, Family, data, mutant};

const EYE: DVec3 = DVec3::new(0.2, -1.8, 1.3);
const TARGET: DVec3 = DVec3::new(0.1, 0.3, 1.0);
const HALF_HEIGHT: f64 = 0.7;
const FRAME: [u32; 2] = [8, 6];
const INDEX: f64 = 1.5;
const EMITTERS: usize = 4;

/// Roulette that says yes to 0 and no to the numbers after the last.
const LIVES: f64 = 0.0;
const LAST: f64 = 0.999_999;

/// A room with mirrors, glass, and lights from a speck to a wall; one is inside of the glass.
fn room() -> Arc<Scene> {
    let camera = Camera::new(EYE, TARGET, DVec3::Z, HALF_HEIGHT);
    seen_by(camera, "lights large, small and in glass", |s| {
        let wall = Surface::new(lambert(FLOOR));
        for (height, up) in [(0.0, true), (3.0, false)] {
            square(s, height * DVec3::Z, 2.0, up, wall);
        }
        let walls = s.surface(wall);
        for side in [-2.0, 2.0] {
            let high = 3.0 * DVec3::Z;
            s.rectangle(DVec3::new(side, -2.0, 0.0), [4.0 * DVec3::Y, high], walls);
            s.rectangle(DVec3::new(-2.0, side, 0.0), [4.0 * DVec3::X, high], walls);
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
        let panel = s.surface(shining(20.0, 0.6));
        let corner = DVec3::new(-1.9, -1.5, 0.3);
        s.rectangle(corner, [3.0 * DVec3::Y, 2.0 * DVec3::Z], panel);
        let core = s.surface(shining(30.0, 0.5));
        let centre = DVec3::new(-0.6, 0.8, 0.9);
        s.sphere(Sphere::new(centre, 0.25), core);
        let glass = s.surface(Surface::new(Bsdf::Glass { index: INDEX }));
        s.sphere(Sphere::new(centre, 0.8), glass);
        let reflectance = DVec3::splat(0.9);
        let mirror = s.surface(Surface::new(Bsdf::Mirror { reflectance }));
        s.sphere(Sphere::new(DVec3::new(0.9, 0.9, 0.6), 0.5), mirror);
        let corner = DVec3::new(1.9, 1.5, 0.2);
        s.rectangle(corner, [-3.0 * DVec3::Y, 2.5 * DVec3::Z], mirror);
    })
}

/// A vertex of a path.
#[derive(Clone, Copy)]
struct Vertex {
    point: DVec3,
    /// Of its front.
    normal: DVec3,
    emitter: Option<u32>,
    kind: Kind,
    /// Of the medium that the path is in at a vertex that is not specular.
    index: f64,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Diffuse,
    Mirror,
    /// With the number that picks its branch.
    Glass(f64),
    Black,
}

impl Vertex {
    fn specular(&self) -> bool {
        matches!(self.kind, Kind::Mirror | Kind::Glass(_))
    }

    fn cosine(&self, to: DVec3) -> f64 {
        (to - self.point).normalize().dot(self.normal).abs()
    }

    /// The numbers of a cosine-weighted direction to a point.
    fn direction(&self, to: DVec3) -> [f64; 2] {
        let w = (to - self.point).normalize();
        let facing = self.normal * self.normal.dot(w).signum();
        cosine_hemisphere_inverse(Frame::new(facing).local(w))
    }
}

/// The way on from a specular vertex, and whether it went through; by Snell's law in vectors.
fn specular(d: DVec3, front: DVec3, glass: bool, through: bool) -> (DVec3, bool) {
    let normal = front * -front.dot(d).signum();
    let along = d - d.dot(normal) * normal;
    let ratio = if front.dot(d) < 0.0 {
        1.0 / INDEX
    } else {
        INDEX
    };
    let bent = ratio * along;
    if glass && through && bent.length_squared() < 0.99 {
        (bent - normal * (1.0 - bent.length_squared()).sqrt(), true)
    } else {
        (d - 2.0 * d.dot(normal) * normal, false)
    }
}

/// Directions and distances below which rounding would show.
const LEAST_COSINE: f64 = 0.05;
const LEAST_DISTANCE: f64 = 0.1;
const LONGEST: usize = 6;

/// A path from an emitter to the eye, in that order, traced from the eye.
fn trace(scene: &Scene, rng: &mut Stream, [x, y]: [f64; 2]) -> Option<Vec<Vertex>> {
    let mut ray = scene.camera().ray(FRAME, x, y);
    let (mut path, mut index) = (Vec::new(), 1.0);
    while path.len() < LONGEST {
        let hit = scene.intersect(&ray)?;
        let cosine = -hit.normal.dot(ray.direction);
        if cosine.abs() < LEAST_COSINE || hit.t < LEAST_DISTANCE {
            return None;
        }
        let bsdf = &scene.surface(&hit).bsdf;
        let (glass, through) = (matches!(bsdf, Bsdf::Glass { .. }), uniform(rng) < 0.7);
        let (way, went) = specular(ray.direction, hit.normal, glass, through);
        let kind = match bsdf {
            Bsdf::Glass { .. } => Kind::Glass(if went { LAST } else { 0.0 }),
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
                if went {
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
        if onward.abs() < LEAST_COSINE || (kind == Kind::Diffuse && !same_side) {
            return None;
        }
        ray = scene.leave(hit.point, hit.normal, direction);
    }
    None
}

/// The area of an emitter, and the numbers of a point on it.
fn on_emitter(shape: &EmitterShape, point: DVec3) -> (f64, [f64; 2]) {
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

/// The densities in closed form by the light's walk and the eye's, for vertices that the walk reaches in
/// no specular way: cos θ cos θ′/(π d²), 1/(N A) on an emitter, and for the eye its share of the image's
/// area at distance 1.
fn closed_form(scene: &Scene, path: &[Vertex]) -> Vec<[Option<f64>; 2]> {
    let walk = |from: &Vertex, to: &Vertex| {
        let distance_squared = from.point.distance_squared(to.point);
        let density = from.cosine(to.point) * to.cosine(from.point) * FRAC_1_PI / distance_squared;
        (!from.specular()).then_some(density)
    };
    let start = |x: &Vertex| {
        let emitter = &scene.emitters()[x.emitter? as usize];
        Some(1.0 / (EMITTERS as f64 * on_emitter(&emitter.shape, x.point).0))
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

/// The density of a path by each strategy, up to a common factor; `None` where there is none.
///
/// Across mirrors and glass n² cos θ dω dA is conserved, so the two walks' densities from one end of a
/// specular chain to the other have the ratio of the two n².
fn by_strategy(path: &[Vertex], known: &[[Option<f64>; 2]]) -> Vec<Option<f64>> {
    let factors = path.iter().zip(known).enumerate().map(|(i, (x, density))| {
        if x.specular() {
            return [1.0, 1.0];
        }
        let end = path[..i].iter().rev().find(|end| !end.specular());
        let chain = end.map_or(f64::NAN, |end| (x.index / end.index).powi(2));
        [density[0].unwrap_or(chain), density[1].unwrap_or(1.0)]
    });
    let factors: Vec<[f64; 2]> = factors.collect();
    let open = |i: usize| path.get(i).is_none_or(|x| !x.specular());
    (0..=path.len())
        .map(|s| {
            let light: f64 = factors[..s].iter().map(|f| f[0]).product();
            let eye: f64 = factors[s..].iter().map(|f| f[1]).product();
            (s == 0 || (open(s - 1) && open(s))).then_some(light * eye)
        })
        .collect()
}

/// The numbers of each block; after the last, [`LAST`].
struct Script<'a> {
    blocks: &'a [(u32, Vec<f64>)],
    block: u32,
    used: usize,
}

impl Sampler for Script<'_> {
    fn block(&mut self, block: u32) {
        (self.block, self.used) = (block, 0);
    }
}

impl TryRng for Script<'_> {
    type Error = std::convert::Infallible;
    fn try_next_u32(&mut self) -> Result<u32, Self::Error> {
        Ok((self.try_next_u64()? >> 32) as u32)
    }
    fn try_next_u64(&mut self) -> Result<u64, Self::Error> {
        let block = self.blocks.iter().find(|(block, _)| *block == self.block);
        let number = block.and_then(|(_, numbers)| numbers.get(self.used).copied());
        self.used += 1;
        let bits = (number.unwrap_or(LAST) * (1u64 << 53) as f64) as u64;
        Ok(bits.min((1 << 53) - 1) << 11)
    }
    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Self::Error> {
        for byte in bytes {
            *byte = (self.try_next_u64()? >> 56) as u8;
        }
        Ok(())
    }
}

/// The numbers with which strategy `s` makes a path.
fn script(scene: &Scene, path: &[Vertex], at: [f64; 2], s: usize) -> Vec<(u32, Vec<f64>)> {
    let emitter = path[0].emitter.unwrap_or(0);
    let pick = (f64::from(emitter) + 0.5) / EMITTERS as f64;
    let shape = &scene.emitters()[emitter as usize].shape;
    let on_light = on_emitter(shape, path[0].point).1;
    let light = vec![pick, on_light[0], on_light[1]];
    // A vertex from which the walk goes on to a point, or ends.
    let scatter = |x: &Vertex, to: Option<&Vertex>| match (x.kind, to) {
        (Kind::Glass(branch), Some(_)) => vec![branch, LIVES],
        (Kind::Mirror, Some(_)) => vec![LIVES],
        (_, Some(to)) => [&x.direction(to.point)[..], &[LIVES]].concat(),
        (_, None) => Vec::new(),
    };
    let mut blocks = vec![(0, at.map(f64::fract).to_vec()), (LIGHT, light.clone())];
    if s > 1 {
        blocks[1].1.extend(path[0].direction(path[1].point));
        for i in 1..s {
            let to = (i + 1 < s).then(|| &path[i + 1]);
            blocks.push((LIGHT + i as u32, scatter(&path[i], to)));
        }
    }
    for (number, i) in (1..).zip((s..path.len()).rev()) {
        let to = (i > s).then(|| &path[i - 1]);
        let mut numbers = if path[i].specular() {
            Vec::new()
        } else {
            light.clone()
        };
        numbers.extend(scatter(&path[i], to));
        blocks.push((number, numbers));
    }
    blocks
}

thread_local! {
    /// The strategy that counts: how many vertices, how many of them from the light.
    static WANTED: Cell<(usize, usize)> = const { Cell::new((0, 0)) };
    /// Its densities, each time that it was found.
    static FOUND: RefCell<Vec<Vec<Density>>> = const { RefCell::new(Vec::new()) };
}

/// In place of a weight: 1 for the strategy that is wanted, 0 for all others.
fn record(path: &[Density], s: usize) -> f64 {
    let wanted = (path.len(), s) == WANTED.get();
    if wanted {
        FOUND.with_borrow_mut(|found| found.push(path.to_vec()));
    }
    f64::from(wanted)
}

/// The densities by which strategy `s` would weigh a path, and what it adds to the image before it does;
/// `None` unless it makes the path once.
fn made(
    scene: &Scene,
    parts: Table,
    path: &[Vertex],
    at: [f64; 2],
    s: usize,
) -> Option<(Vec<Density>, f64)> {
    WANTED.set((path.len(), s));
    FOUND.with_borrow_mut(Vec::clear);
    let parts = Table {
        strategy_weight: record,
        survival_by_throughput: |_| 0.5,
        roulette_weight: |_| 1.0,
        ..parts
    };
    let image = Splats::new(FRAME);
    let blocks = script(scene, path, at, s);
    let mut numbers = Script {
        blocks: &blocks,
        block: 0,
        used: 0,
    };
    let pixel = at.map(|x| x as u32);
    Bdpt { parts }
        .pair(scene, pixel, FRAME, &image, &mut numbers)
        .ok()?;
    let value = image.into_values().iter().map(|value| value.x).sum();
    FOUND.with_borrow_mut(|found| (found.len() == 1).then(|| (found.remove(0), value)))
}

const TRIES: u64 = 20_000;
/// Roundings of a direction, after up to four curved surfaces and at cosines of [`LEAST_COSINE`].
const TOLERANCE: f64 = 1e-6;
/// Below this an image's values lose digits of [`TOLERANCE`].
const LEAST_VALUE: f64 = 1e-3;

fn whole_paths(context: &Context, scene: &Scene, parts: Table) -> Vec<Outcome> {
    let mut rng = context.rng("whole paths");
    let mut worst: [Largest; 4] = Default::default();
    let [densities, weights, sums, values] = &mut worst;
    let (mut least, mut most, mut chains, mut inside) = (f64::INFINITY, 0.0_f64, 0, 0);
    for _ in 0..TRIES {
        let [u, v] = uniform2(&mut rng);
        let at = [u * f64::from(FRAME[0]), v * f64::from(FRAME[1])];
        let Some(path) = trace(scene, &mut rng, at) else {
            continue;
        };
        let known = closed_form(scene, &path);
        let by_strategy = by_strategy(&path, &known);
        let total: f64 = by_strategy.iter().flatten().sum();
        let (mut sum, mut first) = (0.0, None);
        for (s, density) in by_strategy.iter().enumerate() {
            let Some(density) = density else { continue };
            let place = || format!("strategy {s} of {} vertices", path.len());
            let Some((found, value)) = made(scene, parts, &path, at, s) else {
                sums.see(1.0, || format!("{} does not make its path", place()));
                continue;
            };
            for (found, known) in found.iter().zip(&known) {
                for (found, known) in [found.light, found.eye].into_iter().zip(known) {
                    densities.see(known.map_or(0.0, |known| relative(found, known)), place);
                }
            }
            let weight = (parts.strategy_weight)(&found, s);
            sum += weight;
            weights.see((weight - density / total).abs(), place);
            if value > LEAST_VALUE {
                let product = value * density;
                values.see(relative(product, *first.get_or_insert(product)), place);
            }
            let ratio = density / (total - density);
            if ratio.is_finite() {
                (least, most) = (least.min(ratio), most.max(ratio));
            }
        }
        sums.see((sum - 1.0).abs(), || format!("{} vertices", path.len()));
        chains += u32::from(path.iter().any(Vertex::specular));
        inside += u32::from(path[0].index != 1.0);
    }
    // Weights that are alike, or of one kind of path, would prove nothing.
    if least > 1e-3 || most < 1e3 || chains < 200 || inside < 50 {
        sums.see(1.0, || {
            format!(
                "ratios {least:.1e} to {most:.1e}, {chains} specular paths, {inside} from glass"
            )
        });
    }
    let names = [
        "densities",
        "weights",
        "sum of weights",
        "value times density",
    ];
    let exact = |(name, largest): (&str, Largest)| {
        Outcome::exact(name, TRIES, largest.error, TOLERANCE, largest.place)
    };
    names.into_iter().zip(worst).map(exact).collect()
}

macro_rules! by {
    ($($outcome:literal),*) => {
        &[$(concat!("bidirectional/whole-paths: ", $outcome)),*]
    };
}

/// The trial.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let scene = room();
    let trial = data(
        "bidirectional/whole-paths",
        "every strategy makes the same path with the densities in closed form, and the weights sum to one",
        &PATH_DENSITY,
        "estimator::Bdpt",
        "exact",
        (TRIES, TOLERANCE, 0),
    );
    let on = move |context: &Context, parts: Table| whole_paths(context, &scene, parts);
    vec![Box::new(Family {
        whole_estimator: true,
        benches: vec![Bench::new(trial, on)],
        faults: vec![
            mutant(
                "number-of-lights-forgotten",
                &MIS,
                "the density of a light's point does not know that one of four lights was picked",
                Table {
                    emitter_pdf_area: |emitter| EMITTERS as f64 * emitter.pdf_area(),
                    ..RIGHT
                },
                by!("densities", "weights"),
            ),
            mutant(
                "importance-off-by-three-per-cent",
                &IMPORTANCE,
                "the camera's importance is 1.03 times too large",
                Table {
                    importance: |camera, size, w| 1.03 * camera.importance(size, w),
                    ..RIGHT
                },
                by!("densities", "weights"),
            ),
            mutant(
                "density-without-cosine-of-arrival",
                &SOLID_ANGLE,
                "densities by area lack the cosine at the vertex that is reached",
                Table {
                    solid_angle_per_area: |_, distance_squared| 1.0 / distance_squared,
                    ..RIGHT
                },
                by!("densities", "weights"),
            ),
            mutant(
                "density-without-distance",
                &GEOMETRY,
                "densities by area lack the squared distance",
                Table {
                    solid_angle_per_area: |cosine, _| cosine,
                    ..RIGHT
                },
                by!("densities", "weights"),
            ),
            mutant(
                "density-of-another-direction",
                &COSINE_HEMISPHERE,
                "directions are weighted by the uniform density, not the cosine's",
                Table {
                    cosine_hemisphere_pdf: |_| 0.5 * FRAC_1_PI,
                    ..RIGHT
                },
                by!("densities", "weights"),
            ),
            mutant(
                "mirrors-not-skipped",
                &PATH_DENSITY,
                "the sum counts connections at mirrors and glass, which nobody makes",
                Table {
                    strategy_weight: |path, s| {
                        let mut path = path.to_vec();
                        path.iter_mut().for_each(|vertex| vertex.specular = false);
                        weight(&path, s)
                    },
                    ..RIGHT
                },
                by!("weights", "sum of weights"),
            ),
            mutant(
                "flux-scaled-as-radiance",
                &REFRACTION,
                "refraction scales the flux of particles",
                Table {
                    flux_factor: |factor| factor,
                    ..RIGHT
                },
                by!("value times density"),
            ),
        ],
        ..Family::new("whole paths", RIGHT)
    })]
}
