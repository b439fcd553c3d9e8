//! Bidirectional path tracing on one path at a time. Every strategy makes the same path in turn
//! with chosen random numbers, and its densities, weights and values are compared with closed
//! forms.

mod path;

use std::cell::{Cell, RefCell};

use whitefurnace::film::splat::Splats;
use whitefurnace::harness::pointwise::{LargestError, relative};
use whitefurnace::integrator::{Bdpt, Density, weight};
use whitefurnace::sampling::sampler::FIRST_LIGHT_BLOCK;

use crate::bdpt_densities::path::{
    FRAME, Kind, SURVIVE, TERMINATE, Vertex, area_and_sample, known_densities, middle_of_interval,
    pick_pmf, room, shadow_ray_sample, strategy_pdfs, trace,
};
use crate::prelude::*;
use crate::script::{self, Scripted};

/// Random numbers for each block; after the last of a block, [`TERMINATE`].
struct Script<'a> {
    blocks: &'a [(u32, Vec<f64>)],
    block: u32,
    used: usize,
}

impl script::Script for Script<'_> {
    fn block(&mut self, block: u32) {
        (self.block, self.used) = (block, 0);
    }
    fn number(&mut self) -> f64 {
        let block = self.blocks.iter().find(|(block, _)| *block == self.block);
        let number = block.and_then(|(_, numbers)| numbers.get(self.used).copied());
        self.used += 1;
        number.unwrap_or(TERMINATE)
    }
}

/// Returns the numbers, by block, with which strategy `s` (vertices from the light) makes a path.
fn script(scene: &Scene, path: &[Vertex], at: [f64; 2], s: usize) -> Vec<(u32, Vec<f64>)> {
    let emitter = path[0].emitter.unwrap_or(0);
    let pick = middle_of_interval(&pick_pmf(scene), emitter as usize);
    let shape = &scene.emitters()[emitter as usize].shape;
    let on_light = area_and_sample(shape, path[0].point).1;
    let light = vec![pick, on_light[0], on_light[1]];
    // Numbers at a vertex: the direction to the next vertex with the roulette's, or none if the
    // walk ends.
    let scatter = |x: &Vertex, to: Option<&Vertex>| match (x.kind, to) {
        (Kind::Glass(branch), Some(_)) => vec![branch, SURVIVE],
        (Kind::Mirror, Some(_)) => vec![SURVIVE],
        (_, Some(to)) => [&x.direction(to.point)[..], &[SURVIVE]].concat(),
        (_, None) => Vec::new(),
    };
    let mut blocks = vec![(0, at.map(f64::fract).to_vec()), (FIRST_LIGHT_BLOCK, light)];
    if s > 1 {
        blocks[1].1.extend(path[0].direction(path[1].point));
        for i in 1..s {
            let to = (i + 1 < s).then(|| &path[i + 1]);
            blocks.push((FIRST_LIGHT_BLOCK + i as u32, scatter(&path[i], to)));
        }
    }
    for (number, i) in (1..).zip((s..path.len()).rev()) {
        let to = (i > s).then(|| &path[i - 1]);
        let mut numbers = match (s, i) {
            _ if path[i].is_specular() => Vec::new(),
            (1, 1) => shadow_ray_sample(scene, path).0.to_vec(),
            _ => vec![0.0; 3],
        };
        numbers.extend(scatter(&path[i], to));
        blocks.push((number, numbers));
    }
    blocks
}

thread_local! {
    /// The strategy whose contribution counts: vertices of the path, and how many of them are from
    /// the light. A thread-local, because a component is a function pointer and captures nothing.
    static REQUESTED: Cell<(usize, usize)> = const { Cell::new((0, 0)) };
    /// Densities of the wanted strategy, one entry each time that it made a path.
    static RECORDED: RefCell<Vec<Vec<Density>>> = const { RefCell::new(Vec::new()) };
}

/// Replaces the MIS weight: 1 for the strategy that is wanted, 0 for all others. Records its
/// densities.
fn record(path: &[Density], s: usize) -> f64 {
    let wanted = (path.len(), s) == REQUESTED.get();
    if wanted {
        RECORDED.with_borrow_mut(|found| found.push(path.to_vec()));
    }
    f64::from(wanted)
}

/// Makes a path with strategy `s` alone. Returns the densities from which its MIS weight follows,
/// and its unweighted value in the image; `None` unless it made the path exactly once.
fn densities_by_strategy(
    scene: &Scene,
    parts: PartTable,
    path: &[Vertex],
    at: [f64; 2],
    s: usize,
) -> Option<(Vec<Density>, f64)> {
    REQUESTED.set((path.len(), s));
    RECORDED.with_borrow_mut(Vec::clear);
    let parts = PartTable {
        strategy_weight: record,
        survival_by_throughput: |_, _| 0.5,
        roulette_weight: |_| 1.0,
        ..parts
    };
    let image = Splats::new(FRAME);
    let blocks = script(scene, path, at, s);
    let mut numbers = Scripted(Script {
        blocks: &blocks,
        block: 0,
        used: 0,
    });
    let pixel = at.map(|x| x as u32);
    Bdpt::new(Parts::replaced(&parts))
        .pair(scene, pixel, FRAME, &image, &mut numbers)
        .ok()?;
    let value = image.into_values().iter().map(|value| value.x).sum();
    RECORDED.with_borrow_mut(|found| (found.len() == 1).then(|| (found.remove(0), value)))
}

const PATHS: u64 = 20_000;
/// Covers the rounding of a direction after up to four curved surfaces and at cosines of
/// [`MIN_COSINE`].
const TOLERANCE: f64 = 1e-6;
/// Smaller values have fewer digits in the image than [`TOLERANCE`] asks for.
const MIN_VALUE: f64 = 1e-3;

fn compare_densities(context: &Context, scene: &Scene, parts: PartTable) -> Vec<Outcome> {
    let mut rng = context.rng("whole paths");
    let mut worst: [LargestError; 4] = Default::default();
    let [densities, weights, sums, values] = &mut worst;
    let (mut least, mut most, mut chains, mut inside) = (f64::INFINITY, 0.0_f64, 0, 0);
    for _ in 0..PATHS {
        let [u, v] = uniform2(&mut rng);
        let at = [u * f64::from(FRAME[0]), v * f64::from(FRAME[1])];
        let Some(path) = trace(scene, &mut rng, at) else {
            continue;
        };
        let known = known_densities(scene, &path);
        let strategy_pdfs = strategy_pdfs(scene, &path, &known);
        let total: f64 = strategy_pdfs.iter().flatten().sum();
        let (mut sum, mut first) = (0.0, None);
        for (s, density) in strategy_pdfs.iter().enumerate() {
            let Some(density) = density else { continue };
            let place = || format!("strategy {s} of {} vertices", path.len());
            let Some((found, value)) = densities_by_strategy(scene, parts, &path, at, s) else {
                sums.update(1.0, || format!("{} does not make its path", place()));
                continue;
            };
            for (found, known) in found.iter().zip(&known) {
                for (found, known) in [found.light, found.eye].into_iter().zip(known) {
                    densities.update(known.map_or(0.0, |known| relative(found, known)), place);
                }
            }
            let weight = (parts.strategy_weight)(&found, s);
            sum += weight;
            weights.update((weight - density / total).abs(), place);
            if value > MIN_VALUE {
                let product = value * density;
                values.update(relative(product, *first.get_or_insert(product)), place);
            }
            let ratio = density / (total - density);
            if ratio.is_finite() {
                (least, most) = (least.min(ratio), most.max(ratio));
            }
        }
        sums.update((sum - 1.0).abs(), || format!("{} vertices", path.len()));
        chains += u32::from(path.iter().any(Vertex::is_specular));
        inside += u32::from(path[0].index != 1.0);
    }
    // Weights that are alike, or of one kind of path only, would prove nothing.
    if least > 1e-3 || most < 1e3 || chains < 200 || inside < 50 {
        sums.update(1.0, || {
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
    let exact = |(name, largest): (&str, LargestError)| {
        Outcome::identity(name, PATHS, largest.error, TOLERANCE, largest.place)
    };
    names.into_iter().zip(worst).map(exact).collect()
}

pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let scene = room();
    const BY_DENSITY: &str = "bidirectional/whole-paths: densities | weights";
    let on = move |context: &Context, parts: PartTable| compare_densities(context, &scene, parts);
    vec![Box::new(Family {
        trials: vec![trial(
            "bidirectional/whole-paths",
            "every strategy makes the same path with its closed-form densities, and the MIS weights sum to one",
            "bidirectional images have fireflies, or count light by mirrors, glass and lamps twice",
            &PATH_DENSITY,
            "integrator::Bdpt",
            "exact",
            on,
        )],
        faults: vec![
            fault!("number-of-lights-forgotten", MIS,
                "the density of a light's point ignores that one of four lights was picked",
                PartTable: { pdf_of_pick: |pdf, _| pdf }, BY_DENSITY),
            fault!("importance-off-by-three-per-cent", IMPORTANCE, "the camera's importance is 1.03 times too large",
                PartTable: { importance: |camera, size, w| 1.03 * camera.importance(size, w) }, BY_DENSITY),
            fault!("density-without-cosine-of-arrival", SOLID_ANGLE,
                "densities by area lack the cosine at the vertex that is reached",
                PartTable: { solid_angle_per_area: |_, distance_squared| 1.0 / distance_squared }, BY_DENSITY),
            fault!("density-without-distance", GEOMETRY, "densities by area lack the squared distance",
                PartTable: { solid_angle_per_area: |cosine, _| cosine }, BY_DENSITY),
            fault!("density-of-another-direction", COSINE_HEMISPHERE,
                "directions are weighted by the uniform density, not the cosine's",
                PartTable: { cosine_hemisphere_pdf: |_| 0.5 * FRAC_1_PI }, BY_DENSITY),
            fault!("mirrors-not-skipped", PATH_DENSITY,
                "the sum counts connections at mirrors and glass, which no strategy makes",
                PartTable: { strategy_weight: |path, s| {
                    let mut path = path.to_vec();
                    path.iter_mut().for_each(|vertex| vertex.connectible = 1.0);
                    weight(&path, s)
                } },
                "bidirectional/whole-paths: weights | sum of weights"),
            fault!("picked-as-particles-start", LIGHT_PICK,
                "shadow rays are weighed as if they picked lights as particles do: the sum stays one, not the balance",
                PartTable: { strategy_weight: |path, s| {
                    let mut path = path.to_vec();
                    path[0].connectible = f64::from(path[0].connectible > 0.0);
                    weight(&path, s)
                } },
                "bidirectional/whole-paths: weights"),
            fault!("flux-scaled-as-radiance", REFRACTION, "refraction scales the flux of particles",
                PartTable: { flux_factor: |factor| factor }, "bidirectional/whole-paths: value times density"),
        ],
        ..Family::whole("whole paths", CORRECT)
    })]
}
