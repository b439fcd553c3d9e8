//! Sobol' points: numbers of different blocks, and more numbers than a block has.

use std::collections::BTreeSet;

use rand::Rng;
use whitefurnace::rng::stream;
use whitefurnace::sampler::{BLOCK, LIGHT, Sampler, Sobol};

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
