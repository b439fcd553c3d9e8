//! Tests of Owen-scrambled Sobol' points: strata, blocks, the source of their bits, and the block
//! of each vertex.

use std::collections::BTreeSet;

use whitefurnace::sampling::sampler::{
    BLOCK, FIRST_LIGHT_BLOCK, MAX_POINTS, SampleStream, Sobol, scramble,
};

use crate::prelude::*;
use crate::rng::Constant;

fn sobol(index: u32, scramble: u32) -> Sobol {
    let point = u16::try_from(index).expect("a point of the sequence");
    Sobol::new(point, u64::from(scramble), stream(1, scramble, index))
}

/// Returns the first `n` numbers of a block.
fn numbers(index: u32, scramble: u32, block: u32, n: u32) -> Vec<f64> {
    let mut point = sobol(index, scramble);
    point.block(block);
    (0..n).map(|_| uniform(&mut point)).collect()
}

#[test]
fn every_dimension_is_stratified() {
    for (scramble, block) in [
        (0, 0),
        (7, 1),
        (0xFFFF_FFFF, FIRST_LIGHT_BLOCK),
        (3, FIRST_LIGHT_BLOCK + 2),
    ] {
        let points: Vec<Vec<f64>> = (0..256)
            .map(|i| numbers(i, scramble, block, BLOCK))
            .collect();
        for dimension in 0..BLOCK as usize {
            // One point in each of 256 intervals.
            let strata: BTreeSet<u32> = points
                .iter()
                .map(|point| (256.0 * point[dimension]) as u32)
                .collect();
            assert_eq!(strata.len(), 256, "{scramble} {block} {dimension}");
        }
        // The first two dimensions together: one point in each elementary rectangle of area 1/256.
        for bits in 0..=8 {
            let [columns, rows] = [1_u32 << bits, 256 >> bits].map(f64::from);
            let cells: BTreeSet<[u32; 2]> = points
                .iter()
                .map(|point| [(columns * point[0]) as u32, (rows * point[1]) as u32])
                .collect();
            assert_eq!(cells.len(), 256, "{scramble} {block}: {columns} x {rows}");
        }
    }
}

#[test]
fn low_bits_are_those_of_the_stream() {
    let mut fill = stream(1, 4, 17);
    let mut point = sobol(17, 4);
    for block in [3, FIRST_LIGHT_BLOCK] {
        point.block(block);
        for _ in 0..BLOCK {
            assert_eq!(point.next_u64() & ((1 << 41) - 1), fill.next_u64() >> 23);
        }
    }
}

#[test]
fn asking_for_a_block_begins_it_anew() {
    let [fresh, other] = [numbers(5, 9, 2, BLOCK), numbers(5, 9, 3, BLOCK)];
    let mut point = sobol(5, 9);
    let mut from = |block: u32| -> Vec<f64> {
        point.block(block);
        (0..BLOCK).map(|_| uniform(&mut point)).collect()
    };
    // The low bits come from a stream that is not rewound.
    let close = |a: &[f64], b: &[f64]| {
        let step = 1.0 / f64::from(1 << 23);
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < step)
    };
    assert!(close(&from(2), &fresh) && close(&from(3), &other) && close(&from(2), &fresh));
    assert!(!close(&fresh, &other));
    assert!(!close(&fresh, &numbers(6, 9, 2, BLOCK)));
    assert!(!close(&fresh, &numbers(5, 8, 2, BLOCK)));
}

#[test]
fn halves_and_bytes_are_those_of_the_words() {
    let mut words = sobol(17, 2);
    let [first, second] = [words.next_u64(), words.next_u64()];
    let mut halves = sobol(17, 2);
    assert_eq!(
        [halves.next_u32(), halves.next_u32()],
        [first, second].map(|word| (word >> 32) as u32)
    );
    let mut bytes = [0; 11];
    sobol(17, 2).fill_bytes(&mut bytes);
    assert_eq!(bytes[..8], first.to_be_bytes());
    assert_eq!(bytes[8..], second.to_be_bytes()[..3]);
}

#[test]
fn streams_need_no_blocks() {
    let (mut one, mut other) = (stream(1, 2, 3), stream(1, 2, 3));
    other.block(7);
    assert_eq!(one.next_u64(), other.next_u64());
}

/// All pixels of an image of 1024 × 768, and replications of one pixel: with 32 bits some 70 pairs
/// would collide.
#[test]
fn scrambles_are_distinct() {
    const PIXELS: u32 = 1024 * 768;
    let pixels = (0..PIXELS).map(|pixel| scramble(master(), pixel, 3));
    let replications = (0..PIXELS).map(|replication| scramble(master(), 7, replication));
    let mut all: Vec<u64> = pixels.chain(replications).collect();
    all.sort_unstable();
    all.dedup();
    // Pixel 7 in replication 3 is in both.
    assert_eq!(all.len(), 2 * PIXELS as usize - 1);
    // The points differ as well as their seeds: the leading bits of four numbers of one point, 92
    // bits.
    let mut points: Vec<[u32; 4]> = (0..PIXELS)
        .map(|pixel| {
            let mut point = Sobol::new(5, scramble(master(), pixel, 3), stream(1, 2, 3));
            point.block(2);
            [0; 4].map(|_| (point.next_u64() >> 41) as u32)
        })
        .collect();
    points.sort_unstable();
    points.dedup();
    assert_eq!(points.len(), PIXELS as usize);
}

fn leading(points: &mut impl Rng, count: u32) -> Vec<u64> {
    (0..count).map(|_| points.next_u64() >> 41).collect()
}

/// A vertex that asks for more numbers than a block has does not get those of the next vertex.
#[test]
fn a_used_up_block_does_not_run_into_the_next() {
    let mut points = Sobol::new(3, 77, stream(1, 2, 3));
    let mut seen = BTreeSet::new();
    let mut asked = 0;
    for block in [0, 1, 2, 3, FIRST_LIGHT_BLOCK, FIRST_LIGHT_BLOCK + 1] {
        points.block(block);
        seen.extend(leading(&mut points, 3 * BLOCK));
        asked += 3 * BLOCK as usize;
    }
    assert_eq!(seen.len(), asked);
}

/// Blocks deep in a path, of the camera's and of the light's walk, have numbers of their own: they
/// neither wrap nor repeat after any power of two.
#[test]
fn deep_blocks_have_numbers_of_their_own() {
    const DEEP: u32 = 3000;
    let mut points = Sobol::new(5, 99, stream(1, 2, 3));
    let mut seen = BTreeSet::new();
    let powers = (0..16).flat_map(|k| [(1 << k) - 1, 1 << k, (1 << k) + 1]);
    let depths: BTreeSet<u32> = (0..DEEP).chain(powers).collect();
    for &block in depths.iter().filter(|&&block| block < FIRST_LIGHT_BLOCK) {
        for block in [block, FIRST_LIGHT_BLOCK + block] {
            points.block(block);
            // Four numbers of 23 bits: no two equal by chance.
            assert!(
                seen.insert(leading(&mut points, 4)),
                "block {block} repeats another"
            );
        }
    }
}

/// Blocks shuffle the points of a sequence independently: the position in one says nothing about
/// the position in another. In the same order there would be 16 pairs.
#[test]
fn blocks_are_shuffled() {
    let cell = |index, block| (16.0 * numbers(index, 7, block, 1)[0]) as u32;
    let pairs: BTreeSet<[u32; 2]> = (0..256)
        .map(|index| [cell(index, 1), cell(index, 2)])
        .collect();
    assert!(pairs.len() > 100, "{}", pairs.len());
}

/// Counts the 256 equal intervals that contain a first number of the light's path.
fn strata(sources: impl Iterator<Item = SampleStream>) -> usize {
    let interval = |mut source: SampleStream| {
        source.block(FIRST_LIGHT_BLOCK);
        (256.0 * uniform(&mut source)) as u32
    };
    sources.map(interval).collect::<BTreeSet<_>>().len()
}

/// A pixel uses one sequence through the passes of a replication, all particles of an image
/// together use another, and the next replication uses new ones.
#[test]
fn replications_of_passes_are_whole_sequences() {
    let pass = |points, index| ImagePass {
        sampler: SamplerKind::Sobol(points),
        seed: master(),
        index,
    };
    let pixel =
        |passes: std::ops::Range<u32>| strata(passes.map(|index| pass(256, index).pixel_stream(7)));
    let particles = |passes: std::ops::Range<u32>| {
        strata(passes.flat_map(|index| {
            (0..64).map(move |number| pass(4, index).particle_stream(number, 64))
        }))
    };
    assert_eq!(
        [
            pixel(0..256),
            pixel(256..512),
            particles(0..4),
            particles(4..8)
        ],
        [256; 4]
    );
    assert!(pixel(128..384) < 256 && particles(2..6) < 256);
    // Particle 0 of the second pass continues where the first pass ended.
    let first = |index| leading(&mut pass(2, index).particle_stream(0, MAX_POINTS), 4);
    assert_ne!(first(0), first(1));
}

/// Passes with independent numbers draw from the streams of pixels and particles.
#[test]
fn independent_passes_draw_from_streams() {
    let pass = ImagePass::independent(5, 3);
    for mut source in [pass.pixel_stream(7), pass.particle_stream(7, 9)] {
        source.block(FIRST_LIGHT_BLOCK);
        assert_eq!(
            [source.next_u64(), source.next_u64()],
            [(); 2].map({
                let mut stream = stream(5, 7, 3);
                move |()| stream.next_u64()
            })
        );
    }
}

/// Roulette that ends paths only when they are faint, never by chance.
#[derive(Clone, Copy)]
struct EndOnlyIfFaint;

default_parts!(EndOnlyIfFaint: Scattering, NextEvent, Photons, Bidirectional, FiniteElements);

impl Roulette for EndOnlyIfFaint {
    fn survival_by_throughput(&self, throughput: DVec3, _: bool) -> f64 {
        throughput.max_element()
    }
    fn survives(&self, _: f64, throughput: f64) -> bool {
        throughput > 1e-13
    }
    fn roulette_weight(&self, _: f64) -> f64 {
        1.0
    }
}

/// Returns a cavity of mirrors that emit 1, and a ray in it.
fn mirrors(reflectance: f64) -> (Scene, Ray) {
    (
        within_sphere(reflecting(reflectance).emitting(DVec3::ONE)),
        Ray::new(DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.6, 0.0, 0.8)),
    )
}

/// Each vertex of a path of 1500 takes the next block; no block is used twice.
#[test]
fn every_vertex_has_a_block_of_its_own() {
    let (scene, ray) = mirrors(0.98);
    let blocks = |radiance: &dyn Fn(&mut Constant) -> DVec3| {
        let mut recorder = Constant::default();
        let seen = radiance(&mut recorder);
        assert!((seen.x / 50.0 - 1.0).abs() < 1e-11, "{seen}");
        recorder.blocks
    };
    let hit = scene.intersect(&ray);
    let path = Path::new(PathStrategy::Bsdf).with_parts(Parts::replaced(&EndOnlyIfFaint));
    let by_path = blocks(&|rng| path.radiance(&scene, &ray, hit, rng));
    let photons = PhotonMapping::new(
        Parts::replaced(&EndOnlyIfFaint),
        &scene,
        Lookup::DirectVisualization,
        1,
        0.1,
        ImagePass::independent(1, 0),
    );
    let photons = photons.expect("a map");
    let by_photons = blocks(&|rng| photons.radiance(&scene, &ray, hit, rng));
    assert!(by_path.len() > 1400);
    for found in [by_path, by_photons] {
        let all: Vec<u32> = (1..=found.len() as u32).collect();
        assert_eq!(found, all);
    }
}

/// The wall that a final-gathering ray hits is the second vertex.
#[test]
fn final_gathering_takes_the_next_block() {
    let scene = furnace(0.5);
    let lookup = final_gather(1, 0.1);
    let photons = PhotonMapping::new(
        Parts::replaced(&EndOnlyIfFaint),
        &scene,
        lookup,
        1,
        0.1,
        ImagePass::independent(1, 0),
    )
    .expect("a map");
    let mut recorder = Constant::default();
    let ray = Ray::new(DVec3::ZERO, DVec3::X);
    photons.radiance(&scene, &ray, scene.intersect(&ray), &mut recorder);
    assert_eq!(recorder.blocks, [1, 2]);
}

/// Seven segments between mirrors, as in the hypothesis about figure 6: a light that is seen shows
/// 1.
#[test]
fn published_ends_after_seven_segments() {
    let (scene, ray) = mirrors(0.5);
    let seen =
        Published::default().radiance(&scene, &ray, scene.intersect(&ray), &mut stream(3, 4, 5));
    // 1 + 1/2 + ... + 1/64.
    assert_eq!(seen, DVec3::splat(1.984_375));
}
