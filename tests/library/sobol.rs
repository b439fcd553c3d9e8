//! Owen-scrambled Sobol' points: strata, blocks, and where the bits come from.

use std::collections::BTreeSet;

use rand::Rng;
use whitefurnace::rng::{stream, uniform};
use whitefurnace::sampler::{BLOCK, LIGHT, Sampler, Sobol, scramble};

use crate::support::master;

fn sobol(index: u32, scramble: u32) -> Sobol {
    let point = u16::try_from(index).expect("a point of the sequence");
    Sobol::new(point, u64::from(scramble), stream(1, scramble, index))
}

/// The first `n` numbers of a block.
fn numbers(index: u32, scramble: u32, block: u32, n: u32) -> Vec<f64> {
    let mut point = sobol(index, scramble);
    point.block(block);
    (0..n).map(|_| uniform(&mut point)).collect()
}

#[test]
fn every_dimension_is_stratified() {
    for (scramble, block) in [(0, 0), (7, 1), (0xFFFF_FFFF, LIGHT), (3, LIGHT + 2)] {
        let points: Vec<Vec<f64>> = (0..256).map(|i| numbers(i, scramble, block, BLOCK)).collect();
        for dimension in 0..BLOCK as usize {
            // One point in each of 256 intervals.
            let strata: BTreeSet<u32> =
                points.iter().map(|point| (256.0 * point[dimension]) as u32).collect();
            assert_eq!(strata.len(), 256, "{scramble} {block} {dimension}");
        }
        // The first two together: one point in each rectangle of any shape of area 1/256.
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
    for block in [3, LIGHT] {
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
    // The low bits come from a stream that only goes on.
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

/// All pixels of an image of 1024 × 768, and replications of one: with 32 bits some 70 pairs would be alike.
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
    // Not only their names: the leading bits of four numbers of one point, 92 bits, differ as well.
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
