//! Work that several machines share.

use std::str::FromStr;

/// Which part of all, as `i/n`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which, from 1 on.
    pub index: u32,
    /// Of how many.
    pub count: u32,
}

impl Shard {
    /// The only part.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// Whether the thing with this number, from 0 on, is of this part: things go to the parts in
    /// turn.
    pub fn has(self, number: usize) -> bool {
        number % self.count as usize == self.index as usize - 1
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text
            .split_once('/')
            .and_then(|(index, count)| Some((index.parse().ok()?, count.parse().ok()?)));
        let legal = numbers.filter(|&(index, count)| (1..=count).contains(&index));
        legal
            .map(|(index, count)| Self { index, count })
            .ok_or_else(|| format!("must be {EXPECTED}"))
    }
}

/// What is a part.
pub(crate) const EXPECTED: &str = "i/n, the part i of n, such as 1/4: two whole numbers, 1 ≤ i ≤ n";
