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

/// Two features that must occur in one row.
pub type Pair = [String; 2];

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
        pairs(self.factors, &levels).collect()
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

/// Returns the name of a feature: factors of several objects, "a shape" and "b shape", have the
/// same features.
fn feature(factor: Factor, level: usize) -> String {
    let (name, levels) = factor;
    let name = match name.split_once(' ') {
        Some((object, kind)) if object.len() == 1 => kind,
        _ => name,
    };
    format!("{name} {}", levels[level])
}

/// Lists the pairs of features of some factors at some levels. Shape and material form a pair if
/// one object has both.
fn pairs<'a>(
    factors: &'static [Factor],
    levels: &'a [(usize, usize)],
) -> impl Iterator<Item = Pair> + 'a {
    let object = |factor: usize| {
        factors[factor]
            .0
            .split_once(' ')
            .filter(|(object, _)| object.len() == 1)
    };
    levels.iter().enumerate().flat_map(move |(i, &(f, l))| {
        levels[..i].iter().filter_map(move |&(g, m)| {
            let mut pair = [feature(factors[f], l), feature(factors[g], m)];
            pair.sort();
            match (object(f), object(g)) {
                (Some((a, kind)), Some((b, other))) if kind != other && a != b => None,
                _ => Some(pair),
            }
        })
    })
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
                    let Some(pair) = pairs(factors, &[(f, l), (g, m)]).next() else {
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
        let gain = |level: usize| {
            let name = feature(factors[factor], level);
            if chosen.is_empty() {
                return left.iter().filter(|pair| pair.contains(&name)).count();
            }
            let with: Vec<_> = chosen.iter().copied().chain([(factor, level)]).collect();
            pairs(factors, &with)
                .filter(|pair| left.contains(pair))
                .collect::<BTreeSet<_>>()
                .len()
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
