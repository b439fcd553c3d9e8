//! Search of many triangles whose bounding boxes overlap, as those of a fan of thin needles do.
//!
//! Boxes tell nothing of needles around one point, but planes do: the triangles are halved again
//! and again, and no pair is tried between two parts that a plane separates. A plane along an edge
//! of a triangle that lies next to the other part separates those of a fan, a ring, or a row of
//! slats.

use glam::DVec3;

use super::{Overlap, Triangle};
use crate::scene::solids::Shapes;

/// Largest product of the sizes of two parts whose triangles are tried pair by pair.
const MAX_PAIRS: usize = 64;

/// A triangle of a crowd.
pub(super) struct Member {
    primitive: u32,
    triangle: Triangle,
    /// Distance from its edges over which another triangle must reach to overlap it.
    margin: f64,
}

impl Member {
    pub fn new(primitive: u32, triangle: Triangle, tolerance: f64) -> Self {
        Self {
            primitive,
            margin: triangle.margin(tolerance),
            triangle,
        }
    }

    /// Returns three times the centroid.
    fn centre(&self) -> DVec3 {
        self.triangle.corners.iter().sum()
    }
}

impl Shapes<'_> {
    /// Adds all pairs among the members that coincide, in any order.
    pub(super) fn overlaps_within(&self, members: &mut [Member], found: &mut Vec<Overlap>) {
        if members.len() * members.len() <= MAX_PAIRS {
            for (i, a) in members.iter().enumerate() {
                found.extend(
                    members[i + 1..]
                        .iter()
                        .filter_map(|b| self.of_members(a, b)),
                );
            }
            return;
        }
        let (a, b) = halves(members);
        self.overlaps_between(a, b, found);
        self.overlaps_within(a, found);
        self.overlaps_within(b, found);
    }

    /// Adds all pairs of a member of `a` and one of `b` that coincide, in any order.
    fn overlaps_between(&self, a: &mut [Member], b: &mut [Member], found: &mut Vec<Overlap>) {
        if self.are_separate(a, b) {
            return;
        }
        if a.len() * b.len() <= MAX_PAIRS {
            for a in a {
                found.extend(b.iter().filter_map(|b| self.of_members(a, b)));
            }
            return;
        }
        let (larger, smaller) = if a.len() > b.len() { (a, b) } else { (b, a) };
        let (c, d) = halves(larger);
        self.overlaps_between(c, smaller, found);
        self.overlaps_between(d, smaller, found);
    }

    fn of_members(&self, a: &Member, b: &Member) -> Option<Overlap> {
        let (a, b) = if a.primitive < b.primitive {
            (a, b)
        } else {
            (b, a)
        };
        self.overlap([a.primitive, b.primitive], Some(&a.triangle))
    }

    /// Returns whether a plane shows that no pair coincides: one at right angles to an axis or to a
    /// normal of either part, or to an edge of the triangle in each part that is nearest to the
    /// other part.
    fn are_separate(&self, a: &[Member], b: &[Member]) -> bool {
        let mean =
            |part: &[Member]| part.iter().map(Member::centre).sum::<DVec3>() / part.len() as f64;
        let across = mean(b) - mean(a);
        let farthest = |part: &'_ [Member], direction: DVec3| {
            let along = |member: &Member| member.centre().dot(direction);
            let of = part.iter().max_by(|x, y| along(x).total_cmp(&along(y)));
            of.map(|member| (member.triangle.corners, member.triangle.normal))
        };
        let next = [farthest(a, across), farthest(b, -across)];
        let directions = next.into_iter().flatten().flat_map(|([p, q, r], normal)| {
            let across_edge = |edge: DVec3| normal.cross(edge).normalize_or_zero();
            [
                normal,
                across_edge(q - p),
                across_edge(r - q),
                across_edge(p - r),
            ]
        });
        DVec3::AXES
            .into_iter()
            .chain(directions)
            .any(|direction| self.separates(direction, a, b) || self.separates(-direction, a, b))
    }

    /// Returns whether a plane at right angles to a direction shows that no pair coincides, `a`
    /// being behind it and `b` before it.
    ///
    /// The smaller triangle of a pair that coincides reaches its margin beyond some point p in all
    /// directions of its plane, and the larger one has a point that is at most the tolerance above
    /// or below p. So the parts reach into each other by the least such sum.
    fn separates(&self, direction: DVec3, a: &[Member], b: &[Member]) -> bool {
        let reach = |part: &[Member], direction: DVec3| {
            let corners = part.iter().flat_map(|member| member.triangle.corners);
            corners
                .map(|p| p.dot(direction))
                .fold(f64::NEG_INFINITY, f64::max)
        };
        let common = |member: &Member| {
            let above = direction.dot(member.triangle.normal).abs().min(1.0);
            member.margin * (1.0 - above * above).sqrt() - self.tolerance * above
        };
        let least = a.iter().chain(b).map(common).fold(f64::INFINITY, f64::min);
        // A quarter of the tolerance for rounding.
        reach(a, direction) + reach(b, -direction) < least - 0.25 * self.tolerance
    }
}

/// Divides the members into halves along the axis on which they extend farthest.
fn halves(members: &mut [Member]) -> (&mut [Member], &mut [Member]) {
    let centres = members.iter().map(Member::centre);
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = centres.fold(none, |(low, high), p| (low.min(p), high.max(p)));
    let axis = (high - low).max_position();
    let middle = members.len() / 2;
    members.select_nth_unstable_by(middle, |x, y| x.centre()[axis].total_cmp(&y.centre()[axis]));
    members.split_at_mut(middle)
}
