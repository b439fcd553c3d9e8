//! Tests of random streams: stable, distinct, in range.

use std::collections::HashSet;
use std::convert::Infallible;

use rand::TryRng;

use crate::prelude::*;

/// First numbers of four streams, from an independent implementation of SplitMix64's finaliser and
/// Xoshiro256++: a change of any of them changes every image.
#[test]
fn stored_first_values() {
    const FIRST: [((u64, u32, u32), [u64; 3]); 4] = [
        (
            (0, 0, 0),
            [
                0xE8D0_CA5F_197D_9247,
                0x7F57_92EE_A15C_5F24,
                0xF78C_AC64_A66D_22BF,
            ],
        ),
        (
            (1, 0, 0),
            [
                0x232D_C888_C9EA_96B5,
                0x30D6_7EEC_40FD_4EF3,
                0x9E0C_FEC2_D886_43DF,
            ],
        ),
        (
            (1, 2, 3),
            [
                0x0B45_CE41_07E1_18C6,
                0xAF47_6E53_8287_4995,
                0x0200_02AE_35D5_E1E5,
            ],
        ),
        (
            (u64::MAX, u32::MAX, u32::MAX),
            [
                0x52E8_C119_F73F_D180,
                0xD755_17CD_928E_1968,
                0xE566_25B6_D01C_95B5,
            ],
        ),
    ];
    for ((seed, high, low), expected) in FIRST {
        let mut rng = stream(seed, high, low);
        assert_eq!(
            [0; 3].map(|_| rng.next_u64()),
            expected,
            "({seed}, {high}, {low})"
        );
    }
    assert_eq!(seed_for(1, "trial"), 0xE469_D9F6_9996_BA4F);
    assert_eq!(seed_for(1, ""), 0x5692_161D_100B_05E5);
}

#[test]
fn seeds_depend_on_every_byte() {
    let names = [
        "", "a", "b", "ab", "ba", "aa", "trial", "trial ", "Trial", "trial\0", "lairt",
    ];
    let mut seeds = HashSet::new();
    for seed in [0, 1, 2, u64::MAX] {
        seeds.extend(names.map(|name| seed_for(seed, name)));
    }
    assert_eq!(seeds.len(), 4 * names.len());
}

/// A generator that always returns the same bits, and records the blocks that it is asked for.
#[derive(Default)]
pub struct Constant {
    pub bits: u64,
    pub blocks: Vec<u32>,
}

impl Sampler for Constant {
    fn block(&mut self, block: u32) {
        self.blocks.push(block);
    }
}

impl TryRng for Constant {
    type Error = Infallible;
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(self.bits as u32)
    }
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        Ok(self.bits)
    }
    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        bytes.fill(self.bits as u8);
        Ok(())
    }
}

#[test]
fn uniform_numbers_are_in_the_half_open_interval() {
    // 53 bits.
    for (bits, expected) in [
        (0, 0.0),
        (u64::MAX, 1.0 - UNIT_ROUNDOFF),
        (1 << 63, 0.5),
        (1 << 11, UNIT_ROUNDOFF),
    ] {
        assert_eq!(
            uniform(&mut Constant {
                bits,
                ..Constant::default()
            }),
            expected
        );
    }
    let (mut one, mut two) = (stream(5, 6, 7), stream(5, 6, 7));
    assert_eq!(uniform2(&mut one), [uniform(&mut two), uniform(&mut two)]);
}
