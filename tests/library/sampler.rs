//! Sobol' points: numbers of different blocks, and more numbers than a block has.

use std::collections::BTreeSet;
use std::convert::Infallible;

use glam::DVec3;
use rand::{Rng, TryRng};
use whitefurnace::bsdf::{Bsdf, Scattering};
use whitefurnace::estimator::{
    Estimator, Lookup, NextEvent, Path, PhotonMapping, Photons, Published, Strategy,
};
use whitefurnace::rng::{Stream, stream};
use whitefurnace::roulette::Roulette;
use whitefurnace::sampler::{BLOCK, LIGHT, Sampler, Sobol};
use whitefurnace::scene::{Scene, SceneBuilder, Surface, simple};
use whitefurnace::shape::{Ray, Sphere};

use crate::helpers::any_camera;

fn leading(points: &mut Sobol, count: u32) -> Vec<u64> {
    (0..count).map(|_| points.next_u64() >> 41).collect()
}

/// A vertex that asks for more numbers than a block has must not get those of the next vertex.
#[test]
fn a_used_up_block_does_not_run_into_the_next() {
    let mut points = Sobol::new(3, 77, stream(1, 2, 3));
    let mut seen = BTreeSet::new();
    let mut asked = 0;
    for block in [0, 1, 2, 3, LIGHT, LIGHT + 1] {
        points.block(block);
        seen.extend(leading(&mut points, 3 * BLOCK));
        asked += 3 * BLOCK as usize;
    }
    assert_eq!(seen.len(), asked);
}

#[test]
fn the_fill_leaves_the_leading_bits_alone() {
    let [mut a, mut b] = [1, 2].map(|k| Sobol::new(9, 5, stream(k, 0, 0)));
    let [whole_a, whole_b] = [&mut a, &mut b].map(|p| p.next_u64());
    assert_eq!(whole_a >> 41, whole_b >> 41);
    assert_ne!(whole_a, whole_b);
}

/// Blocks far down a path, of the eye's and of the light's, have numbers of their own: they neither wrap
/// nor repeat after any power of two.
#[test]
fn deep_blocks_have_numbers_of_their_own() {
    const DEEP: u32 = 3000;
    let mut points = Sobol::new(5, 99, stream(1, 2, 3));
    let mut seen = BTreeSet::new();
    let powers = (0..16).flat_map(|k| [(1 << k) - 1, 1 << k, (1 << k) + 1]);
    let depths: BTreeSet<u32> = (0..DEEP).chain(powers).collect();
    for &block in depths.iter().filter(|&&block| block < LIGHT) {
        for block in [block, LIGHT + block] {
            points.block(block);
            // Four numbers of 23 bits: none alike by chance.
            let numbers = leading(&mut points, 4);
            assert!(seen.insert(numbers), "block {block} repeats another");
        }
    }
}

/// Writes down which blocks are asked for.
struct Recorder {
    numbers: Stream,
    blocks: Vec<u32>,
}

impl TryRng for Recorder {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        self.numbers.try_next_u32()
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        self.numbers.try_next_u64()
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        self.numbers.try_fill_bytes(bytes)
    }
}

impl Sampler for Recorder {
    fn block(&mut self, block: u32) {
        self.blocks.push(block);
    }
}

/// Paths that never end by chance, but only when faint.
#[derive(Clone, Copy)]
struct Endless;

impl Roulette for Endless {
    fn survival_by_throughput(&self, throughput: DVec3) -> f64 {
        throughput.max_element()
    }
    fn survives(&self, _: f64, throughput: f64) -> bool {
        throughput > 1e-13
    }
    fn roulette_weight(&self, _: f64) -> f64 {
        1.0
    }
}

impl Scattering for Endless {}

impl NextEvent for Endless {}

impl Photons for Endless {}

/// A cavity of mirrors that emits 1, and a ray in it.
fn mirrors(reflectance: f64) -> (Scene, Ray) {
    let mut builder = SceneBuilder::new("mirrors");
    let reflectance = DVec3::splat(reflectance);
    let mirror = builder.surface(Surface::new(Bsdf::Mirror { reflectance }).emitting(DVec3::ONE));
    let cavity = Sphere { inward: true, ..Sphere::new(DVec3::ZERO, 1.0) };
    builder.sphere(cavity, mirror);
    let scene = builder.build(any_camera()).expect("a scene");
    (scene, Ray::new(DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.6, 0.0, 0.8)))
}

/// Each vertex of a path of 1500 takes the next block, and no block serves two.
#[test]
fn every_vertex_has_a_block_of_its_own() {
    let (scene, ray) = mirrors(0.98);
    let blocks = |radiance: &dyn Fn(&mut Recorder) -> DVec3| {
        let mut recorder = Recorder { numbers: stream(3, 4, 5), blocks: Vec::new() };
        let seen = radiance(&mut recorder);
        assert!((seen.x / 50.0 - 1.0).abs() < 1e-11, "{seen}");
        recorder.blocks
    };
    let hit = scene.intersect(&ray);
    let path = Path::new(Endless, Strategy::Bsdf);
    let by_path = blocks(&|rng| path.radiance(&scene, &ray, hit, rng));
    let photons = PhotonMapping::new(Endless, &scene, Lookup::Direct, (1, 0.1), (1, 0));
    let photons = photons.expect("a map");
    let by_photons = blocks(&|rng| photons.radiance(&scene, &ray, hit, rng));
    assert!(by_path.len() > 1400);
    for found in [by_path, by_photons] {
        let all: Vec<u32> = (1..=found.len() as u32).collect();
        assert_eq!(found, all);
    }
}

/// The wall that final gathering looks at is the second vertex.
#[test]
fn final_gathering_takes_the_next_block() {
    let scene = simple::furnace_box(0.5).expect("a scene");
    let lookup = Lookup::Gather { caustic_particles: 1, caustic_radius: 0.1 };
    let photons = PhotonMapping::new(Endless, &scene, lookup, (1, 0.1), (1, 0)).expect("a map");
    let mut recorder = Recorder { numbers: stream(3, 4, 5), blocks: Vec::new() };
    let ray = Ray::new(DVec3::ZERO, DVec3::X);
    photons.radiance(&scene, &ray, scene.intersect(&ray), &mut recorder);
    assert_eq!(recorder.blocks, [1, 2]);
}

/// Seven segments between mirrors, as the hypothesis about figure 6 has it: light that is seen shows 1.
#[test]
fn published_ends_after_seven_segments() {
    let (scene, ray) = mirrors(0.5);
    let hit = scene.intersect(&ray);
    let seen = Published::default().radiance(&scene, &ray, hit, &mut stream(3, 4, 5));
    // 1 + 1/2 + ... + 1/64.
    assert_eq!(seen, DVec3::splat(1.984_375));
}
