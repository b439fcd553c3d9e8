//! Picks among the emitters of a scene. If they are many, neighbours are in groups, these in larger
//! ones, and a shadow ray picks its way from the largest groups down to an emitter, at each step by
//! what the choices may contribute.

use glam::DVec3;

use super::emitter::Emitter;
use super::light_sampler::{MOST, share, share_all};

/// So many choices at most are there at a step, if there are several steps.
const CHOICES: usize = MOST / 2;
/// The last number below 1.
const LAST: f64 = 1.0 - f64::EPSILON / 2.0;

/// The emitters of a scene, in groups of groups if they are more than [`MOST`].
#[derive(Clone, Debug)]
pub struct Groups {
    /// The numbers of the emitters, neighbours next to each other.
    order: Vec<u32>,
    /// Where each emitter is in that order.
    place: Vec<u32>,
    /// Level k has a group for each `choices` of level k - 1; those of level 0 are of so many
    /// emitters.
    levels: Vec<Vec<Group>>,
    choices: usize,
}

/// Emitters as one that shines alike in all directions.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// Area times radiance.
    strength: f64,
    centre: DVec3,
    /// The mean squared distance from the centre.
    spread: f64,
}

impl Group {
    /// Of smaller ones.
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

impl Groups {
    /// Of any number of emitters.
    pub fn new(emitters: &[Emitter]) -> Self {
        let count = emitters.len();
        let fits = |choices: usize, steps: u32| choices.pow(steps) >= count;
        let (mut steps, mut choices) = (1, MOST);
        if count > MOST {
            steps = (2..)
                .find(|&steps| fits(CHOICES, steps))
                .expect("a power that is large enough");
            choices = (2..)
                .find(|&choices| fits(choices, steps))
                .expect("no more than at most");
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

    /// Whether there are several steps to an emitter, not one.
    #[inline]
    pub fn is_nested(&self) -> bool {
        !self.levels.is_empty()
    }

    /// The choices at a step that leads to `place` among groups of this level or, without one,
    /// among emitters: where they begin, and how many.
    fn choices(&self, level: Option<usize>, place: usize) -> (usize, usize) {
        let first = place / self.choices * self.choices;
        let all = level.map_or(self.order.len(), |level| self.levels[level].len());
        (first, self.choices.min(all - first))
    }

    /// What a choice may contribute.
    fn contribution(
        &self,
        level: Option<usize>,
        place: usize,
        (from, emitter): (DVec3, &impl Fn(usize) -> f64),
    ) -> f64 {
        match level {
            Some(level) => self.levels[level][place].contribution(from),
            None => emitter(self.order[place] as usize),
        }
    }

    /// All steps from the largest groups down to emitters.
    fn steps(&self) -> impl Iterator<Item = Option<usize>> {
        (0..self.levels.len()).rev().map(Some).chain([None])
    }

    /// The number of the emitter that a uniform number in [0, 1) picks from a point, and the
    /// probability of that, 0 if no emitter of its group contributes. `contribution` is an
    /// emitter's, `by_share` picks by shares.
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
            share_all(
                |i| self.contribution(level, first + i, (from, &contribution)),
                shares,
            );
            let (index, share) = by_share(r, shares);
            probability *= share;
            place = first + index;
            if level.is_some() {
                // What is left of the number is as uniform, and picks the next.
                let below: f64 = shares[..index].iter().sum();
                r = ((r - below) / share).clamp(0.0, LAST);
                place *= self.choices;
            }
        }
        (self.order[place] as usize, probability)
    }

    /// The probability with which [`pick`](Self::pick) picks the emitter of this number.
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
            let contribution = |i| self.contribution(level, first + i, (from, &contribution));
            share(contribution, count, (above(level) - first) as f64)
        };
        self.steps().map(of_step).product()
    }
}

/// Sorts emitters so that the groups of `choices`, of so many groups and so on are of neighbours.
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
