//! Hierarchical light sampler. Many emitters are grouped with their neighbours, groups form larger
//! groups, and a shadow ray descends from the largest groups to an emitter, picking at each step by
//! estimated importance.

use glam::DVec3;

use super::emitter::Emitter;
use super::light_sampler::{MAX_EXACT_LIGHTS, probabilities, probability};

/// Maximum number of children at a step, if there are several steps.
const MAX_CHILDREN: usize = MAX_EXACT_LIGHTS / 2;
/// Largest number below 1.
const ONE_MINUS_EPSILON: f64 = 1.0 - f64::EPSILON / 2.0;

/// Emitters of a scene, in nested groups if there are more than [`MAX_EXACT_LIGHTS`].
#[derive(Clone, Debug)]
pub struct LightTree {
    /// Indices of the emitters, sorted so that neighbours are adjacent.
    order: Vec<u32>,
    /// Position of each emitter in `order`.
    position: Vec<u32>,
    /// Groups by level: level k has a group for each `children` groups of level k - 1, level 0 for
    /// each `children` emitters.
    levels: Vec<Vec<Group>>,
    children: usize,
}

/// A group of emitters, approximated by one isotropic source.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// Area times radiance.
    power: f64,
    centre: DVec3,
    /// Mean squared distance from the centre.
    variance: f64,
}

impl Group {
    /// Merges smaller groups.
    fn of(parts: impl Iterator<Item = Self> + Clone) -> Self {
        let power: f64 = parts.clone().map(|part| part.power).sum();
        let share = |part: &Self| {
            if power > 0.0 { part.power / power } else { 0.0 }
        };
        let centre = parts.clone().map(|part| share(&part) * part.centre).sum();
        let variance = parts
            .map(|part| share(&part) * (part.variance + part.centre.distance_squared(centre)))
            .sum();
        Self {
            power,
            centre,
            variance,
        }
    }

    fn importance(&self, from: DVec3) -> f64 {
        0.25 * self.power / (self.centre.distance_squared(from) + self.variance)
    }
}

impl LightTree {
    /// Builds the groups of any number of emitters.
    pub fn new(emitters: &[Emitter]) -> Self {
        let count = emitters.len();
        let fits = |children: usize, steps: u32| children.pow(steps) >= count;
        let (mut steps, mut children) = (1, MAX_EXACT_LIGHTS);
        if count > MAX_EXACT_LIGHTS {
            steps = (2..)
                .find(|&steps| fits(MAX_CHILDREN, steps))
                .expect("a sufficient number of steps");
            children = (2..)
                .find(|&children| fits(children, steps))
                .expect("at most CHOICES choices");
        }
        let mut order: Vec<u32> = (0..count as u32).collect();
        sort(&mut order, emitters, children);
        let mut position = vec![0; count];
        order
            .iter()
            .zip(0..)
            .for_each(|(&emitter, at)| position[emitter as usize] = at);
        let single = |&emitter: &u32| {
            let (power, centre, variance) = emitters[emitter as usize].tree_leaf();
            Group {
                power,
                centre,
                variance,
            }
        };
        let mut levels = Vec::new();
        let mut parts: Vec<Group> = order.iter().map(single).collect();
        for _ in 1..steps {
            parts = parts
                .chunks(children)
                .map(|part| Group::of(part.iter().copied()))
                .collect();
            levels.push(parts.clone());
        }
        Self {
            order,
            position,
            levels,
            children,
        }
    }

    /// Returns whether picking an emitter takes several steps.
    #[inline]
    pub fn is_nested(&self) -> bool {
        !self.levels.is_empty()
    }

    /// Returns the children at the step that leads to `position` among the groups of a level or,
    /// without one, among the emitters: the first and the number of them.
    fn children(&self, level: Option<usize>, position: usize) -> (usize, usize) {
        let first = position / self.children * self.children;
        let all = level.map_or(self.order.len(), |level| self.levels[level].len());
        (first, self.children.min(all - first))
    }

    /// Returns the importance of a child.
    fn importance(
        &self,
        level: Option<usize>,
        position: usize,
        from: DVec3,
        emitter: &impl Fn(usize) -> f64,
    ) -> f64 {
        match level {
            Some(level) => self.levels[level][position].importance(from),
            None => emitter(self.order[position] as usize),
        }
    }

    /// Iterates over the steps from the largest groups down to the emitters.
    fn steps(&self) -> impl Iterator<Item = Option<usize>> {
        (0..self.levels.len()).rev().map(Some).chain([None])
    }

    /// Returns the index of the emitter that a uniform number in [0, 1) picks from a point, and the
    /// probability, 0 if no emitter of its group contributes. `importance` evaluates an emitter,
    /// `by_probability` picks by selection probabilities.
    #[inline]
    pub fn pick(
        &self,
        mut r: f64,
        from: DVec3,
        importance: impl Fn(usize) -> f64,
        by_probability: impl Fn(f64, &[f64]) -> (usize, f64),
    ) -> (usize, f64) {
        let mut buffer = [0.0; MAX_EXACT_LIGHTS];
        let (mut position, mut probability) = (0, 1.0);
        for level in self.steps() {
            let (first, count) = self.children(level, position);
            let children = &mut buffer[..count];
            probabilities(
                |i| self.importance(level, first + i, from, &importance),
                children,
            );
            let (index, child_probability) = by_probability(r, children);
            probability *= child_probability;
            position = first + index;
            if level.is_some() {
                // The remainder of the number is uniform again, and picks at the next step.
                let below: f64 = children[..index].iter().sum();
                r = ((r - below) / child_probability).clamp(0.0, ONE_MINUS_EPSILON);
                position *= self.children;
            }
        }
        (self.order[position] as usize, probability)
    }

    /// Returns the probability with which [`pick`](Self::pick) picks an emitter.
    #[inline]
    pub fn probability(&self, index: usize, from: DVec3, importance: impl Fn(usize) -> f64) -> f64 {
        let position = self.position[index] as usize;
        let above = |level: Option<usize>| {
            level.map_or(position, |level| {
                position / self.children.pow(level as u32 + 1)
            })
        };
        let step_probability = |level| {
            let (first, count) = self.children(level, above(level));
            let importance = |i| self.importance(level, first + i, from, &importance);
            probability(importance, count, (above(level) - first) as f64)
        };
        self.steps().map(step_probability).product()
    }
}

/// Sorts emitters so that each run of `children`, and of higher powers of it, consists of
/// neighbours.
fn sort(order: &mut [u32], emitters: &[Emitter], children: usize) {
    if order.len() <= children {
        return;
    }
    let mut unit = children;
    while unit * children < order.len() {
        unit *= children;
    }
    let centre = |emitter: u32| emitters[emitter as usize].tree_leaf().1;
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
    sort(left, emitters, children);
    sort(right, emitters, children);
}
