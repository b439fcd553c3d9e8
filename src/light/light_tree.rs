//! Hierarchical light sampler. Many emitters are grouped with their neighbours, groups form larger
//! groups, and a shadow ray descends from the largest groups to an emitter, picking at each step by
//! estimated contribution.

use glam::DVec3;

use super::emitter::Emitter;
use super::light_sampler::{MOST, probabilities, share};

/// Maximum number of choices at a step, if there are several steps.
const CHOICES: usize = MOST / 2;
/// Largest number below 1.
const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

/// Emitters of a scene, in nested groups if there are more than [`MOST`].
#[derive(Clone, Debug)]
pub struct LightTree {
    /// Indices of the emitters, sorted so that neighbours are adjacent.
    order: Vec<u32>,
    /// Position of each emitter in `order`.
    place: Vec<u32>,
    /// Groups by level: level k has a group for each `choices` groups of level k - 1, level 0 for
    /// each `choices` emitters.
    levels: Vec<Vec<Group>>,
    choices: usize,
}

/// A group of emitters, approximated by one isotropic source.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// Area times radiance.
    strength: f64,
    centre: DVec3,
    /// Mean squared distance from the centre.
    spread: f64,
}

impl Group {
    /// Merges smaller groups.
    fn of(parts: impl Iterator<Item = Self> + Clone) -> Self {
        let strength: f64 = parts.clone().map(|part| part.strength).sum();
        let share = |part: &Self| {
            if strength > 0.0 {
                part.strength / strength
            } else {
                0.0
            }
        };
        let centre = parts.clone().map(|part| share(&part) * part.centre).sum();
        let spread = parts
            .map(|part| share(&part) * (part.spread + part.centre.distance_squared(centre)))
            .sum();
        Self {
            strength,
            centre,
            spread,
        }
    }

    fn contribution(&self, from: DVec3) -> f64 {
        0.25 * self.strength / (self.centre.distance_squared(from) + self.spread)
    }
}

impl LightTree {
    /// Builds the groups of any number of emitters.
    pub fn new(emitters: &[Emitter]) -> Self {
        let count = emitters.len();
        let fits = |choices: usize, steps: u32| choices.pow(steps) >= count;
        let (mut steps, mut choices) = (1, MOST);
        if count > MOST {
            steps = (2..)
                .find(|&steps| fits(CHOICES, steps))
                .expect("a sufficient number of steps");
            choices = (2..)
                .find(|&choices| fits(choices, steps))
                .expect("at most CHOICES choices");
        }
        let mut order: Vec<u32> = (0..count as u32).collect();
        sort(&mut order, emitters, choices);
        let mut place = vec![0; count];
        order
            .iter()
            .zip(0..)
            .for_each(|(&emitter, at)| place[emitter as usize] = at);
        let single = |&emitter: &u32| {
            let (strength, centre, spread) = emitters[emitter as usize].as_point();
            Group {
                strength,
                centre,
                spread,
            }
        };
        let mut levels = Vec::new();
        let mut parts: Vec<Group> = order.iter().map(single).collect();
        for _ in 1..steps {
            parts = parts
                .chunks(choices)
                .map(|part| Group::of(part.iter().copied()))
                .collect();
            levels.push(parts.clone());
        }
        Self {
            order,
            place,
            levels,
            choices,
        }
    }

    /// Returns whether picking an emitter takes several steps.
    #[inline]
    pub fn is_nested(&self) -> bool {
        !self.levels.is_empty()
    }

    /// Returns the choices at the step that leads to `place` among the groups of a level or,
    /// without one, among the emitters: the first and the number of them.
    fn choices(&self, level: Option<usize>, place: usize) -> (usize, usize) {
        let first = place / self.choices * self.choices;
        let all = level.map_or(self.order.len(), |level| self.levels[level].len());
        (first, self.choices.min(all - first))
    }

    /// Returns the contribution of a choice.
    fn contribution(
        &self,
        level: Option<usize>,
        place: usize,
        from: DVec3,
        emitter: &impl Fn(usize) -> f64,
    ) -> f64 {
        match level {
            Some(level) => self.levels[level][place].contribution(from),
            None => emitter(self.order[place] as usize),
        }
    }

    /// Iterates over the steps from the largest groups down to the emitters.
    fn steps(&self) -> impl Iterator<Item = Option<usize>> {
        (0..self.levels.len()).rev().map(Some).chain([None])
    }

    /// Returns the index of the emitter that a uniform number in [0, 1) picks from a point, and the
    /// probability, 0 if no emitter of its group contributes. `contribution` evaluates an emitter,
    /// `by_share` picks by selection probabilities.
    #[inline]
    pub fn pick(
        &self,
        mut r: f64,
        from: DVec3,
        contribution: impl Fn(usize) -> f64,
        by_share: impl Fn(f64, &[f64]) -> (usize, f64),
    ) -> (usize, f64) {
        let mut shares = [0.0; MOST];
        let (mut place, mut probability) = (0, 1.0);
        for level in self.steps() {
            let (first, count) = self.choices(level, place);
            let shares = &mut shares[..count];
            probabilities(
                |i| self.contribution(level, first + i, from, &contribution),
                shares,
            );
            let (index, share) = by_share(r, shares);
            probability *= share;
            place = first + index;
            if level.is_some() {
                // The remainder of the number is uniform again, and picks at the next step.
                let below: f64 = shares[..index].iter().sum();
                r = ((r - below) / share).clamp(0.0, LAST);
                place *= self.choices;
            }
        }
        (self.order[place] as usize, probability)
    }

    /// Returns the probability with which [`pick`](Self::pick) picks an emitter.
    #[inline]
    pub fn probability(
        &self,
        index: usize,
        from: DVec3,
        contribution: impl Fn(usize) -> f64,
    ) -> f64 {
        let place = self.place[index] as usize;
        let above = |level: Option<usize>| {
            level.map_or(place, |level| place / self.choices.pow(level as u32 + 1))
        };
        let of_step = |level| {
            let (first, count) = self.choices(level, above(level));
            let contribution = |i| self.contribution(level, first + i, from, &contribution);
            share(contribution, count, (above(level) - first) as f64)
        };
        self.steps().map(of_step).product()
    }
}

/// Sorts emitters so that each run of `choices`, and of higher powers of it, consists of
/// neighbours.
fn sort(order: &mut [u32], emitters: &[Emitter], choices: usize) {
    if order.len() <= choices {
        return;
    }
    let mut unit = choices;
    while unit * choices < order.len() {
        unit *= choices;
    }
    let centre = |emitter: u32| emitters[emitter as usize].as_point().1;
    let low = order
        .iter()
        .fold(DVec3::INFINITY, |low, &emitter| low.min(centre(emitter)));
    let high = order.iter().fold(DVec3::NEG_INFINITY, |high, &emitter| {
        high.max(centre(emitter))
    });
    let axis = (high - low).max_position();
    let middle = order.len().div_ceil(unit) / 2 * unit;
    order.select_nth_unstable_by(middle, |&a, &b| {
        centre(a)[axis].total_cmp(&centre(b)[axis]).then(a.cmp(&b))
    });
    let (left, right) = order.split_at_mut(middle);
    sort(left, emitters, choices);
    sort(right, emitters, choices);
}
