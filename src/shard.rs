//! Division of work among several machines.

use std::str::FromStr;

/// One part of all work, as `i/n`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Index of the part, from 1.
    pub index: u32,
    /// Number of parts.
    pub count: u32,
}

impl Shard {
    /// The only part of one.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// Returns whether the item with this index, from 0, belongs to this part: items go to the
    /// parts in turn.
    pub fn contains(self, number: usize) -> bool {
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
            .ok_or_else(|| format!("must be {SHARD_FORMAT}"))
    }
}

/// Description of valid shards, for messages.
pub(crate) const SHARD_FORMAT: &str =
    "i/n, the part i of n, such as 1/4: two whole numbers, 1 ≤ i ≤ n";
