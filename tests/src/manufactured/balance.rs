//! The balance of light at each wall of a box: what leaves it, less what it reflects, is what it
//! emits.
//!
//! A room of constant radiosities would need walls whose emission varies from point to point. By
//! reciprocity the variable function can stand in the measurement instead, while emission is
//! constant: the light that leaves wall m, less its albedo times the light that leaves any wall
//! towards it, is the emission of m. From a point x the share F(x→m) goes to m, a closed form for
//! rectangles, and so
//!
//! mean of B over m − ρ_m Σ_i (A_i/A_m) (mean of F(x→m) B(x) over wall i) = E_m.
//!
//! Everything on the left is measured by rays to the walls, and an error at one wall breaks the
//! balance of that wall alone.

use glam::Vec3Swizzles;
use whitefurnace::integrator::NextEvent as _;
use whitefurnace::light::emitter::LightSampling;

use crate::cie::{parallel_corner, upright_corner};
use crate::mean_radiance::{path, points};
use crate::prelude::*;
use crate::scenes::{panel, seen_by};
use crate::strategies::path_with;

use super::with_altered_albedo;

/// Lengths of the edges.
const SIZE: [f64; 3] = [1.0, 1.4, 0.8];
/// Number of walls.
const WALLS: usize = 6;

/// Albedo and emitted radiance of the walls, which are below and above in x, y and z. No two have
/// colours in the same proportion.
const ALBEDOS: [DVec3; WALLS] = [
    DVec3::new(0.5, 0.2, 0.35),
    DVec3::new(0.15, 0.45, 0.5),
    DVec3::new(0.35, 0.5, 0.1),
    DVec3::new(0.45, 0.1, 0.3),
    DVec3::new(0.1, 0.35, 0.45),
    DVec3::new(0.3, 0.25, 0.15),
];
const EMISSIONS: [DVec3; WALLS] = [
    DVec3::new(1.0, 0.6, 1.6),
    DVec3::new(0.8, 1.2, 0.9),
    DVec3::new(0.9, 1.4, 0.7),
    DVec3::new(0.7, 0.8, 1.0),
    DVec3::new(1.2, 0.9, 1.1),
    DVec3::new(0.9, 0.7, 1.1),
];

/// Names of the outcomes, a wall each.
const NAMES: [&str; WALLS] = [
    "left wall",
    "right wall",
    "front wall",
    "back wall",
    "floor",
    "ceiling",
];

/// Points on each wall in a replication.
const POINTS: u16 = 8;
/// Replications at scale 1.
const REPLICATIONS: u64 = 26_500;

/// Returns the axis of a wall's normal and those of its edges, which follow it cyclically.
fn axes(wall: usize) -> [usize; 3] {
    let across = wall / 2;
    [across, (across + 1) % 3, (across + 2) % 3]
}

/// Returns the area of a wall.
fn area(wall: usize) -> f64 {
    let [_, u, v] = axes(wall);
    SIZE[u] * SIZE[v]
}

/// Returns the point of a wall at a share of each of its edges.
fn point(wall: usize, shares: [f64; 2]) -> DVec3 {
    let ([across, u, v], mut point) = (axes(wall), DVec3::ZERO);
    point[across] = if wall % 2 == 1 { SIZE[across] } else { 0.0 };
    point[u] = shares[0] * SIZE[u];
    point[v] = shares[1] * SIZE[v];
    point
}

/// Returns the form factor from a point of one wall to another, in closed form.
fn form_factor(x: DVec3, from: usize, to: usize) -> f64 {
    let ([across, u, v], [to_across, ..]) = (axes(from), axes(to));
    // Distances of a coordinate from both ends of an edge.
    let both = |axis: usize| [x[axis], SIZE[axis] - x[axis]];
    if from == to {
        return 0.0;
    }
    if across == to_across {
        let corners = both(u).map(|a| both(v).map(|b| parallel_corner(a, b, SIZE[across])));
        return corners.as_flattened().iter().sum();
    }
    let along = if to_across == u { v } else { u };
    let distance = both(to_across)[to % 2];
    let corners = both(along).map(|width| upright_corner(SIZE[across], width, distance));
    corners.iter().sum()
}

/// Builds the box, seen from its centre.
fn room() -> Arc<Scene> {
    let camera = Camera::new(centre(), DVec3::ZERO, DVec3::Z, 0.3);
    seen_by(camera, "balanced box", |s| {
        for (wall, (albedo, emission)) in ALBEDOS.into_iter().zip(EMISSIONS).enumerate() {
            let corner = point(wall, [0.0, 0.0]);
            let [a, b] = [[1.0, 0.0], [0.0, 1.0]].map(|end| point(wall, end) - corner);
            // Fronts are inside.
            let edges = if wall % 2 == 0 { [a, b] } else { [b, a] };
            let surface = Surface::new(Bsdf::Lambert { albedo }).emitting(emission);
            panel(s, corner, edges, surface);
        }
    })
}

fn centre() -> DVec3 {
    0.5 * DVec3::from_array(SIZE)
}

/// Compares the balance of each wall with its emission, in units of that.
struct Balance {
    scene: Arc<Scene>,
    kind: EstimatorKind,
}

impl Balance {
    /// Returns the balance of each wall in one replication, the mean of the channels in units of
    /// what the wall emits.
    fn replication(&self, setup: Configuration<'_>, seed: u64, number: u32) -> [f64; WALLS] {
        let (mut places, mut rays) = (Vec::new(), Vec::new());
        for wall in 0..WALLS {
            for mut numbers in points(seed, wall as u32, number, POINTS) {
                let x = point(wall, [uniform(&mut numbers), uniform(&mut numbers)]);
                places.push((wall, x));
                rays.push((Ray::new(centre(), (x - centre()).normalize()), numbers));
            }
        }
        let radiances = self.kind.radiances(setup, &self.scene, rays.into_iter());
        let mut balance = [DVec3::ZERO; WALLS];
        for ((wall, x), radiance) in places.into_iter().zip(radiances) {
            balance[wall] += radiance;
            for (to, balance) in balance.iter_mut().enumerate() {
                let arriving = area(wall) / area(to) * form_factor(x, wall, to) * radiance;
                *balance -= ALBEDOS[to] * arriving;
            }
        }
        std::array::from_fn(|wall| {
            (balance[wall] / EMISSIONS[wall]).element_sum() / (3.0 * f64::from(POINTS))
        })
    }
}

impl Property for Balance {
    fn run(&self, context: &Context, setup: Configuration<'_>) -> Vec<Outcome> {
        let (seed, mut number) = (context.seed_of("walls"), 0..);
        let about = NAMES.map(|name| (name, 1.0, IMAGE_DELTA));
        means(about, context.n(REPLICATIONS), || {
            let number = number.next().expect("a number below 2³²");
            self.replication(setup, seed, number)
        })
    }
}

/// Trials of the box.
pub(super) fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let kind = path_with(Strategy::Mis, LightSampling::Importance);
    let balance = Balance {
        scene: room(),
        kind,
    };
    vec![trial(
        "manufactured/balance/path",
        "what leaves each wall of a box, less what it reflects of what comes from the others, is its emission",
        "one wall of a room has its neighbour's brightness, hue or lamp, or sees it at a wrong slant",
        &RENDERING,
        path(kind),
        "t",
        with_parts(balance),
    )]
}

/// Evaluates the BRDF of a wall with the albedo that `altered` gives it.
fn altered(bsdf: &Bsdf, wo: DVec3, wi: DVec3, altered: fn(usize) -> DVec3) -> DVec3 {
    let bsdf = with_altered_albedo(bsdf, &ALBEDOS, altered);
    DefaultParts.brdf(&bsdf, wo, wi)
}

/// Faults that the box shows.
pub(super) fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("opposite-walls", RENDERING, "opposite walls of a box have each other's albedo",
            { brdf: |bsdf, wo, wi| altered(bsdf, wo, wi, |wall| ALBEDOS[wall ^ 1]) },
            "manufactured/balance/path: left wall | right wall | front wall | back wall | floor | ceiling"),
        fault!("ceiling-lost", RENDERING, "the ceiling of a box reflects nothing",
            { brdf: |bsdf, wo, wi| altered(bsdf, wo, wi, |wall| {
                if wall == 5 { DVec3::ZERO } else { ALBEDOS[wall] }
            }) },
            "manufactured/balance/path: ceiling"),
        fault!("channels-of-one-wall", RENDERING, "red and blue are exchanged in the albedo of one wall",
            { brdf: |bsdf, wo, wi| altered(bsdf, wo, wi, |wall| {
                let albedo = ALBEDOS[wall];
                if wall == 0 { albedo.zyx() } else { albedo }
            }) },
            "manufactured/balance/path: left wall"),
        fault!("share-of-the-next", LIGHT_PICK, "the pdf has the probability of another emitter than the one picked",
            { pick_by_probability: |r, shares| {
                let (index, _) = DefaultParts.pick_by_probability(r, shares);
                (index, shares[(index + 1) % shares.len()])
            } },
            "manufactured/balance/path: left wall | ceiling"),
    ]
}
