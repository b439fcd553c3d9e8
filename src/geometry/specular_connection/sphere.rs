//! Connections through a sphere: the roots of an equation of one angle.

use glam::DVec3;

use super::{Caster, SpecularConnection};
use crate::geometry::shape::SurfacePoint;
use crate::math::real::{Mask, MaskOf, Real, Vector};

/// Maximum number of steps to a root. They approach from one side, so that the distance to a double
/// root falls by a factor of four with each; convergence to simple roots becomes quadratic.
const MAX_STEPS: u32 = 48;

/// Step size below which the iteration ends.
const STEP_TOLERANCE: f64 = 1e-7;

/// [`STEP_TOLERANCE`] in single precision.
const SINGLE_STEP_TOLERANCE: f64 = 1e-4;

/// Two points relative to a sphere of radius 1 around the origin.
struct Pair<V: Vector> {
    x: V,
    y: V,
    /// Distances X and Y from the centre.
    x_distance: V::Real,
    y_distance: V::Real,
    /// Unit vector towards x, and the unit vector perpendicular to it in the plane of x, y and the
    /// centre, on the side of y.
    to_x: V,
    across: V,
    /// Cosine and sine of Θ, the angle from x to y.
    cos: V::Real,
    sin: V::Real,
}

/// sin α and cos α, where α is the angle of incidence outside.
#[derive(Clone, Copy)]
struct Angle<R> {
    sin: R,
    cos: R,
}

/// Distances along the ray from its point nearest to the centre to x and to y, √(X² − sin² α) and
/// √(Y² − sin² α); and the cosine inside the sphere.
struct Legs<R> {
    x: R,
    y: R,
    within: R,
}

impl<R: Real> Legs<R> {
    #[inline]
    fn new(sin: R, [x_distance, y_distance]: [R; 2], inverse_ior: R) -> Self {
        let square = sin * sin;
        let leg = |distance: R| (distance * distance - square).sqrt();
        let within = R::splat(1.0) - inverse_ior * inverse_ior * square;
        Self {
            x: leg(x_distance),
            y: leg(y_distance),
            within: within.sqrt(),
        }
    }

    /// Returns df/dα of [`crate::equation::SPECULAR_ANGLE`], as dividend and divisor.
    #[inline]
    fn slope(&self, cos: R, inverse_ior: R) -> [R; 2] {
        let product = self.x * self.y;
        let divisor = product * self.within;
        [
            divisor * 2.0 - cos * (inverse_ior * product * 2.0 + self.within * (self.x + self.y)),
            divisor,
        ]
    }

    /// Returns cos and sin of f(α) − τ, times XY.
    #[inline]
    fn residual(&self, angle: Angle<R>, inverse_ior: R, target: [R; 2]) -> [R; 2] {
        let (sin, refracted) = (angle.sin, angle.sin * inverse_ior);
        let turn = |[a, b]: [R; 2], [c, d]: [R; 2]| [a * c - b * d, b * c + a * d];
        // Rotation by the angle α − β.
        let bent = turn([angle.cos, sin], [self.within, -refracted]);
        let legs = turn([self.x, -sin], [self.y, -sin]);
        turn(turn(turn(bent, bent), legs), [target[0], -target[1]])
    }
}

impl<V: Vector> Pair<V> {
    #[inline]
    fn new(x: V, y: V, centre: V, radius: V::Real) -> Self {
        let unit = radius.recip();
        let (x, y) = ((x - centre) * unit, (y - centre) * unit);
        let [x_distance, y_distance] = [x, y].map(|v| v.length_squared().sqrt());
        let (to_x, to_y) = (x * x_distance.recip(), y * y_distance.recip());
        let cos = to_x.dot(to_y);
        // Orthogonalized twice: the first pass leaves a rounding error along x that matters if x
        // and y are nearly in line.
        let aside = to_y - to_x * cos;
        let aside = aside - to_x * to_x.dot(aside);
        let sin = aside.length_squared().sqrt();
        Self {
            x,
            y,
            x_distance,
            y_distance,
            to_x,
            across: aside * sin.recip(),
            cos,
            sin,
        }
    }

    /// Returns whether both points are outside the sphere and not in line with its centre.
    #[inline]
    fn is_outside(&self) -> MaskOf<V> {
        let one = V::Real::splat(1.0);
        self.x_distance.cmpgt(one)
            & self.y_distance.cmpgt(one)
            & self.sin.cmpgt(V::Real::splat(0.0))
    }

    #[inline]
    fn distances(&self) -> [V::Real; 2] {
        [self.x_distance, self.y_distance]
    }

    /// Finds the root of f(α) = τ, given cos τ and sin τ, by Newton's steps from a right angle
    /// downwards or from α = 0 upwards; returns it and the lanes among the `active` in which it
    /// exists.
    ///
    /// f is convex and f(0) = 0. From a right angle, where f(α) ≥ τ, and from 0, where f falls and
    /// 0 ≥ τ, no step passes the root, as none is longer than Newton's. Where there is no root, the
    /// steps leave the range of angles or reach a slope of the other sign: from a right angle f(α)
    /// − τ is at most π, and no sum of steps reaches a root of τ − 2π, as f > −π.
    #[inline]
    fn root(
        &self,
        inverse_ior: V::Real,
        target: [V::Real; 2],
        upwards: bool,
        active: MaskOf<V>,
    ) -> (Angle<V::Real>, MaskOf<V>) {
        let all = V::Real::splat;
        let (zero, one) = (all(0.0), all(1.0));
        let scale = self.x_distance * self.y_distance;
        let small = V::Real::by_precision(STEP_TOLERANCE, SINGLE_STEP_TOLERANCE);
        let [sin, cos] = if upwards { [zero, one] } else { [one, zero] };
        let mut angle = Angle { sin, cos };
        let (mut going, mut found) = (active, active);
        for _ in 0..MAX_STEPS {
            let legs = Legs::new(angle.sin, self.distances(), inverse_ior);
            let [slope, divisor] = legs.slope(angle.cos, inverse_ior);
            let [far, off] = legs.residual(angle, inverse_ior, target);
            // 3 sin δ/(2 + cos δ) is a lower bound of the distance δ = f(α) − τ in [0, π].
            let half = off * 1.5 * divisor / ((scale * 2.0 + far) * slope);
            let right_side = if upwards {
                slope.cmplt(zero)
            } else {
                slope.cmpgt(zero)
            };
            let (square, double) = (half * half, half * 2.0);
            let norm = (square + 1.0).recip();
            let [c, s] = [(one - square) * norm, double * norm];
            let next = Angle {
                sin: angle.sin * c - angle.cos * s,
                cos: angle.cos * c + angle.sin * s,
            };
            let within = !next.sin.cmplt(zero) & !next.cos.cmplt(zero);
            let lost = going & !(right_side & within);
            found = found & !lost;
            going = going & !lost;
            let take = |new, old| V::Real::select(going, new, old);
            angle = Angle {
                sin: take(next.sin, angle.sin),
                cos: take(next.cos, angle.cos),
            };
            going = going & half.abs().cmpgt(small);
            if !going.any() {
                break;
            }
        }
        (angle, found & !going)
    }

    /// Returns dω/dA⊥ in units of the radius, and whether it is positive and finite.
    #[inline]
    fn geometry_term(&self, angle: Angle<V::Real>, inverse_ior: V::Real) -> (V::Real, MaskOf<V>) {
        let legs = Legs::new(angle.sin, self.distances(), inverse_ior);
        let [slope, divisor] = legs.slope(angle.cos, inverse_ior);
        let across = self.x_distance * self.y_distance * legs.x * legs.y * self.sin;
        let geometry_term = angle.sin * angle.cos * divisor / (across * slope.abs());
        (
            geometry_term,
            geometry_term.cmpgt(V::Real::splat(0.0))
                & geometry_term.cmplt(V::Real::splat(f64::INFINITY)),
        )
    }
}

/// A root of [`crate::equation::SPECULAR_ANGLE`], where it exists.
#[derive(Clone, Copy)]
pub(crate) struct RootAt<V: Vector> {
    pub exists: MaskOf<V>,
    angle: Angle<V::Real>,
}

impl<V: Vector> RootAt<V> {
    /// Returns this root in the lanes of the mask, and `other` elsewhere.
    #[inline]
    pub fn or(self, mask: MaskOf<V>, other: Self) -> Self {
        let choose = |yes, no| V::Real::select(mask, yes, no);
        let (a, b) = (self.angle, other.angle);
        let angle = Angle {
            sin: choose(a.sin, b.sin),
            cos: choose(a.cos, b.cos),
        };
        Self {
            exists: (mask & self.exists) | (!mask & other.exists),
            angle,
        }
    }
}

/// Connections between two points through spheres.
pub struct SphereConnections<'a, V: Vector> {
    caster: &'a Caster<V>,
    pair: Pair<V>,
    /// Lanes in which light is refracted through the sphere, not reflected.
    refracts: MaskOf<V>,
    /// Lanes in which there can be connections.
    possible: MaskOf<V>,
}

/// Returns α = π/2, grazing incidence.
#[inline]
fn grazing<R: Real>() -> Angle<R> {
    Angle {
        sin: R::splat(1.0),
        cos: R::splat(0.0),
    }
}

impl<'a, V: Vector> SphereConnections<'a, V> {
    /// Prepares connections from x to y in the `active` lanes: refraction in the lanes of
    /// `refracts`, reflection in the others.
    #[inline]
    pub fn new(caster: &'a Caster<V>, x: V, y: V, active: MaskOf<V>, refracts: MaskOf<V>) -> Self {
        let pair = Pair::new(x, y, caster.centre, caster.radius);
        let possible = active & pair.is_outside();
        Self {
            caster,
            pair,
            refracts,
            possible,
        }
    }

    /// Finds all roots: first that of reflection or of refraction across the axis, f(α) = Θ or π −
    /// Θ; then the two of weaker refraction, f(α) = Θ − π, of which the larger exists only if the
    /// other does.
    #[inline]
    pub(crate) fn roots(&self) -> [RootAt<V>; 3] {
        let Self {
            pair,
            caster,
            refracts,
            possible,
        } = self;
        let (zero, one) = (V::Real::splat(0.0), V::Real::splat(1.0));
        let root = |target, upwards, among: MaskOf<V>| {
            if !among.any() {
                return RootAt {
                    exists: among,
                    angle: grazing(),
                };
            }
            let (angle, exists) = pair.root(caster.inverse_ior, target, upwards, among);
            RootAt { exists, angle }
        };
        let first = root(
            [V::Real::select(*refracts, -pair.cos, pair.cos), pair.sin],
            false,
            *possible,
        );
        let [x, y] = pair.distances();
        let slope_at_0 = x * y * (one - caster.inverse_ior) * 2.0 - (x + y);
        let target = [-pair.cos, -pair.sin];
        let smaller = root(target, true, *possible & *refracts & slope_at_0.cmplt(zero));
        let larger = root(target, false, smaller.exists);
        [first, larger, smaller]
    }

    /// Returns the connection that belongs to a root, which is the first of [`roots`](Self::roots)
    /// in the lanes of `is_first`.
    #[inline]
    pub(crate) fn connection(
        &self,
        RootAt { exists, angle }: RootAt<V>,
        is_first: MaskOf<V>,
    ) -> SpecularConnection<V> {
        let one = V::Real::splat(1.0);
        let Self {
            pair,
            caster,
            refracts,
            ..
        } = self;
        let (geometry_term, finite) = pair.geometry_term(angle, caster.inverse_ior);
        let legs = Legs::new(angle.sin, pair.distances(), caster.inverse_ior);
        // Light refracted across the axis turns the other way.
        let around = V::Real::select(*refracts & is_first, -one, one);
        // Unit normal where the sphere is met on the way from one of the points, given the unit
        // vector towards that point and the perpendicular one towards the other point.
        let met = |to: V, across: V, leg: V::Real, distance: V::Real| {
            let scale = distance.recip();
            let across = across * (around * angle.sin * (leg - angle.cos) * scale);
            to * ((angle.cos * leg + angle.sin * angle.sin) * scale) + across
        };
        let turned = |a: V::Real, b: V::Real| pair.to_x * a + pair.across * b;
        let first = met(pair.to_x, pair.across, legs.x, pair.x_distance);
        let (to_y, across) = (turned(pair.cos, pair.sin), turned(pair.sin, -pair.cos));
        let last = V::select(*refracts, met(to_y, across, legs.y, pair.y_distance), first);
        let point = |normal: V| SurfacePoint::new(caster.centre + normal * caster.radius, normal);
        SpecularConnection {
            exists: exists & finite,
            direction: (first - pair.x).normalize(),
            arriving: (pair.y - last).normalize(),
            first: point(first),
            last: point(last),
            cosine: angle.cos,
            geometry_term: geometry_term / (caster.radius * caster.radius),
        }
    }
}

impl<'a> SphereConnections<'a, DVec3> {
    /// Iterates over the connections, with the index of their root.
    #[inline]
    pub fn connections(self) -> impl Iterator<Item = (usize, SpecularConnection<DVec3>)> + use<'a> {
        let found = (0..).zip(self.roots()).filter(|(_, root)| root.exists);
        found
            .map(move |(number, root)| (number, self.connection(root, number == 0)))
            .filter(|(_, connection)| connection.exists)
    }
}

/// Returns [`geometry_term`](super::geometry_term) for a sphere.
#[inline]
pub(super) fn geometry_term_of_sphere<V: Vector>(
    caster: &Caster<V>,
    x: V,
    direction: V,
    y: V,
) -> (V::Real, V::Real) {
    let (zero, one) = (V::Real::splat(0.0), V::Real::splat(1.0));
    let pair = Pair::new(x, y, caster.centre, caster.radius);
    let aside = pair.x - direction * pair.x.dot(direction);
    let sin = aside.length_squared().sqrt();
    let angle = Angle {
        sin,
        cos: (one - sin * sin).maximum(zero).sqrt(),
    };
    let (geometry_term, finite) = pair.geometry_term(angle, caster.inverse_ior);
    (
        V::Real::select(
            finite & pair.is_outside(),
            geometry_term / (caster.radius * caster.radius),
            zero,
        ),
        angle.cos,
    )
}
