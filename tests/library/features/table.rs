//! Covering arrays: tables of factors in which every pair of levels occurs in at least one row,
//! found by a greedy search.

use std::collections::BTreeSet;

use rand::seq::SliceRandom;
use whitefurnace::sampling::rng::{Stream, stream};

/// A property of a scene or an estimator, and its possible levels.
pub type Factor = (&'static str, &'static [&'static str]);

/// One scene with its settings: the level of each factor.
#[derive(Clone, Debug)]
pub struct Row {
    factors: &'static [Factor],
    levels: Vec<usize>,
}

/// A level of a factor. Factors of several objects, "a shape" and "b shape", have the same
/// features.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Feature {
    pub kind: &'static str,
    pub level: &'static str,
}

/// Two features that must occur in one row, in their order.
pub type Pair = [Feature; 2];

impl Row {
    /// Returns the level of a factor; empty if the table has no such factor.
    pub fn get(&self, factor: &str) -> &'static str {
        let at = self.factors.iter().position(|(name, _)| *name == factor);
        at.map_or("", |at| self.factors[at].1[self.levels[at]])
    }

    /// Returns the row with another level of a factor.
    pub fn with(&self, factor: &str, level: &str) -> Self {
        let mut row = self.clone();
        for ((name, levels), at) in self.factors.iter().zip(&mut row.levels) {
            if *name == factor {
                *at = levels
                    .iter()
                    .position(|other| *other == level)
                    .expect("a level");
            }
        }
        row
    }

    /// Returns whether a factor has this level.
    pub fn is(&self, factor: &str, level: &str) -> bool {
        self.get(factor) == level
    }

    /// Returns whether any factor has this level.
    pub fn has(&self, level: &str) -> bool {
        self.factors
            .iter()
            .zip(&self.levels)
            .any(|((_, levels), &at)| levels[at] == level)
    }

    /// Returns whether a factor has no effect, such as a heuristic where nothing is weighted.
    fn is_idle(&self, factor: usize) -> bool {
        match self.factors[factor].0 {
            "emission" => self.is("emitter", "none"),
            "heuristic" | "bodies" => !self.is("finds", "mis"),
            "lights" => self.is("finds", "bsdf"),
            _ => false,
        }
    }

    fn pairs(&self) -> BTreeSet<Pair> {
        let levels = self.levels.iter().copied().enumerate();
        let levels: Vec<(usize, usize)> = levels
            .filter(|&(factor, _)| !self.is_idle(factor))
            .collect();
        pairs(self.factors, &levels)
    }
}

impl std::fmt::Display for Row {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let words: Vec<String> = self
            .factors
            .iter()
            .zip(&self.levels)
            .map(|((name, levels), &at)| format!("{name} {}", levels[at]))
            .collect();
        f.write_str(&words.join(", "))
    }
}

/// Splits the name of a factor into the object that has it, if it is one of several, and its kind.
fn object_and_kind(name: &str) -> (Option<&str>, &str) {
    match name.split_once(' ') {
        Some((object, kind)) if object.len() == 1 => (Some(object), kind),
        _ => (None, name),
    }
}

fn feature(factor: Factor, level: usize) -> Feature {
    let (name, levels) = factor;
    Feature {
        kind: object_and_kind(name).1,
        level: levels[level],
    }
}

/// Returns the pair of two factors at these levels. Shape and material form one if one object has
/// both.
fn pair(factors: &[Factor], first: (usize, usize), second: (usize, usize)) -> Option<Pair> {
    let [of_first, of_second] =
        [first, second].map(|(factor, _)| object_and_kind(factors[factor].0));
    if let ((Some(a), kind), (Some(b), other)) = (of_first, of_second)
        && kind != other
        && a != b
    {
        return None;
    }
    let mut pair = [first, second].map(|(factor, level)| feature(factors[factor], level));
    pair.sort();
    Some(pair)
}

/// Returns the pairs of some factors at their levels.
fn pairs(factors: &[Factor], levels: &[(usize, usize)]) -> BTreeSet<Pair> {
    let earlier = |(i, &later)| {
        let earlier = levels[..i].iter();
        earlier.filter_map(move |&earlier| pair(factors, later, earlier))
    };
    levels.iter().enumerate().flat_map(earlier).collect()
}

/// Returns every pair of features that some row can have. `allowed` refuses rows; it is called for
/// each pair with random levels of all other factors, and a pair for which none of many rows is
/// allowed is impossible.
pub fn required(factors: &'static [Factor], allowed: impl Fn(&Row) -> bool) -> BTreeSet<Pair> {
    let mut found = BTreeSet::new();
    let mut rng = stream(1, 0, 0);
    for f in 0..factors.len() {
        for g in 0..f {
            for l in 0..factors[f].1.len() {
                for m in 0..factors[g].1.len() {
                    let Some(pair) = pair(factors, (f, l), (g, m)) else {
                        continue;
                    };
                    let mut tries = (0..1000).map(|_| fixed(factors, &[(f, l), (g, m)], &mut rng));
                    if tries.any(|row| allowed(&row) && row.pairs().contains(&pair)) {
                        found.insert(pair);
                    }
                }
            }
        }
    }
    found
}

/// Draws a row with some levels given and the others at random.
fn fixed(factors: &'static [Factor], given: &[(usize, usize)], rng: &mut Stream) -> Row {
    let mut levels: Vec<usize> = factors
        .iter()
        .map(|(_, levels)| draw(rng, levels.len()))
        .collect();
    given
        .iter()
        .for_each(|&(factor, level)| levels[factor] = level);
    Row { factors, levels }
}

fn draw(rng: &mut Stream, count: usize) -> usize {
    (whitefurnace::sampling::rng::uniform(rng) * count as f64) as usize
}

/// Returns the pairs that occur in none of these rows.
pub fn missing<'a>(
    mut required: BTreeSet<Pair>,
    rows: impl IntoIterator<Item = &'a Row>,
) -> BTreeSet<Pair> {
    for row in rows {
        for pair in row.pairs() {
            required.remove(&pair);
        }
    }
    required
}

/// Returns rows that contain all required pairs: each is the best of several, which begin with a
/// missing pair and add further factors in random order, at the level that covers most pairs.
pub fn table(factors: &'static [Factor], allowed: impl Fn(&Row) -> bool) -> Vec<Row> {
    const CANDIDATES: u32 = 40;
    let mut left = required(factors, &allowed);
    let (mut rows, mut tries) = (Vec::new(), 0);
    while !left.is_empty() {
        let mut best: Option<(usize, Row)> = None;
        for candidate in 0..CANDIDATES {
            let mut rng = stream(2, tries, candidate);
            let row = candidate_row(factors, &left, &mut rng);
            let added = row.pairs().intersection(&left).count();
            if allowed(&row) && best.as_ref().is_none_or(|(most, _)| added > *most) {
                best = Some((added, row));
            }
        }
        tries += 1;
        assert!(tries < 10_000, "no row has {left:?}");
        if let Some((1.., row)) = best {
            left = missing(left, [&row]);
            rows.push(row);
        }
    }
    rows
}

fn candidate_row(factors: &'static [Factor], left: &BTreeSet<Pair>, rng: &mut Stream) -> Row {
    let mut order: Vec<usize> = (0..factors.len()).collect();
    order.shuffle(rng);
    let mut chosen: Vec<(usize, usize)> = Vec::new();
    for factor in order {
        let count = factors[factor].1.len();
        let first = draw(rng, count);
        let covered = pairs(factors, &chosen);
        let gain = |level: usize| {
            if chosen.is_empty() {
                let feature = feature(factors[factor], level);
                return left.iter().filter(|pair| pair.contains(&feature)).count();
            }
            let with = chosen.iter();
            let added = with.filter_map(|&other| pair(factors, (factor, level), other));
            let is_new = |pair: &Pair| left.contains(pair) && !covered.contains(pair);
            added.filter(is_new).collect::<BTreeSet<_>>().len()
        };
        let best = (0..count)
            .map(|i| (first + i) % count)
            .max_by_key(|&level| gain(level))
            .unwrap_or(first);
        chosen.push((factor, best));
    }
    chosen.sort_unstable();
    Row {
        factors,
        levels: chosen.into_iter().map(|(_, level)| level).collect(),
    }
}
