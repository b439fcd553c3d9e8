//! A glossy patch in a cavity of three zones, and what it shows of each: integrals of the formulas
//! of a textbook, written here a second time.

use whitefurnace::material::fresnel::reflectance;
use whitefurnace::material::ggx::Ggx;
use whitefurnace::material::rough_glass::RoughGlass;
use whitefurnace::math::frame::{Frame, from_spherical};

use crate::ggx::{self, lambda};
use crate::prelude::*;
use crate::rough_glass::{self, beta};
use crate::scenes::{panel, seen_by};

use super::add_zone;

/// A patch in a cavity of three zones.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Material of the patch.
    lobe: Lobe,
    /// Inclination and azimuth of the view, radians.
    inclination: f64,
    azimuth: f64,
    /// Ends of the zones in z, from the lowest to the highest.
    cuts: [f64; 4],
    /// Radiance of each zone in its channel.
    radiance: [f64; 3],
}

/// A glossy material.
#[derive(Clone, Copy, Debug)]
enum Lobe {
    /// A rough conductor.
    Metal(Ggx),
    /// A rough dielectric, the medium inside below the patch.
    Glass(RoughGlass),
}

/// A rough metal of which each zone reflects in a visible part of the lobe.
pub const METAL: Patch = Patch {
    lobe: Lobe::Metal(Ggx {
        reflectance: DVec3::new(0.9, 0.6, 0.3),
        alpha: 0.5,
    }),
    inclination: 0.9,
    azimuth: 2.856,
    cuts: [-1.0, 0.05, 0.5, 1.0],
    radiance: [2.0, 1.0, 1.5],
};

/// Rough glass, seen at a slant. Two zones divide the transmitted lobe, the third is reflected.
pub const GLASS: Patch = Patch {
    lobe: Lobe::Glass(RoughGlass {
        index: 1.5,
        alpha: 0.5,
    }),
    inclination: 1.35,
    azimuth: 2.856,
    cuts: [-1.0, -0.86, -0.3, 1.0],
    radiance: [1.0, 0.5, 3.0],
};

/// Tolerance of the mean over a zone; the sum of the zones is within 2·10⁻⁵ of another route's.
const TOLERANCE: f64 = 1e-5;

/// D of GGX in the slope of the facet.
fn facets(alpha: f64, m: DVec3) -> f64 {
    let slope = m.truncate().length() / (alpha * m.z);
    FRAC_1_PI / (alpha * m.z * m.z * (1.0 + slope * slope)).powi(2)
}

/// Radiance along wo per radiance from wi and solid angle there, f |cos θ|, for a metal.
fn by_metal(Ggx { reflectance, alpha }: Ggx, wo: DVec3, wi: DVec3) -> DVec3 {
    if wi.z <= 0.0 {
        return DVec3::ZERO;
    }
    let m = (wo + wi).normalize();
    let fresnel = reflectance + (1.0 - reflectance) * (1.0 - wo.dot(m)).powi(5);
    let seen = 1.0 / (1.0 + lambda(alpha, wo) + lambda(alpha, wi));
    fresnel * (facets(alpha, m) * seen / (4.0 * wo.z))
}

/// Radiance along wo per radiance from wi and solid angle there, for glass seen from outside: the
/// square of the index that refraction divides radiance by is that of the solid angles.
fn by_glass(RoughGlass { index, alpha }: RoughGlass, wo: DVec3, wi: DVec3) -> f64 {
    if wi.z > 0.0 {
        let m = (wo + wi).normalize();
        let seen = 1.0 / (1.0 + lambda(alpha, wo) + lambda(alpha, wi));
        return reflectance(wo.dot(m), 1.0, index) * facets(alpha, m) * seen / (4.0 * wo.z);
    }
    let sum = -(wo + index * wi);
    let m = sum.normalize();
    let [cos_o, cos_i] = [wo.dot(m), -wi.dot(m)];
    if cos_o <= 0.0 || cos_i <= 0.0 || m.z <= 0.0 {
        return 0.0;
    }
    let seen = beta(lambda(alpha, wo), lambda(alpha, wi.with_z(-wi.z)));
    let transmitted = 1.0 - reflectance(cos_o, 1.0, index);
    transmitted * facets(alpha, m) * seen * cos_o * cos_i / (wo.z * sum.length_squared())
}

impl Patch {
    /// The patch's frame: tilted and turned, so that no plane of symmetry of the lobe is one of the
    /// zones.
    fn frame() -> Frame {
        Frame::new(DVec3::new(0.4, -0.5, 0.8).normalize())
    }

    /// Direction towards the eye, local.
    fn wo(&self) -> DVec3 {
        from_spherical(self.inclination, self.azimuth)
    }

    /// Ray from the eye to the centre of the patch.
    pub(super) fn ray(&self) -> Ray {
        let w = Self::frame().world(self.wo());
        Ray::new(0.5 * w, -w)
    }

    /// Returns what zones of radiance 1 send along the view by way of the patch, in a channel.
    fn shares(&self, channel: usize) -> [f64; 3] {
        let (frame, wo) = (Self::frame(), self.wo());
        let of_zone = |zone: usize| {
            let [low, high] = [self.cuts[zone], self.cuts[zone + 1]];
            let integrand = |p: DVec3| {
                let z = low + (high - low) * p.x;
                let (sin, cos) = (TAU * p.y).sin_cos();
                let across = (1.0 - z * z).sqrt();
                let wi = frame.local(DVec3::new(across * cos, across * sin, z));
                match self.lobe {
                    Lobe::Metal(metal) => by_metal(metal, wo, wi)[channel],
                    Lobe::Glass(glass) => by_glass(glass, wo, wi),
                }
            };
            let mean = Domain::Square.integrate_all(TOLERANCE, &integrand).value;
            TAU * (high - low) * mean
        };
        [0, 1, 2].map(of_zone)
    }

    /// Returns what each zone sends along the view by way of the patch, in its own channel.
    pub(super) fn radiances(&self) -> [f64; 3] {
        [0, 1, 2].map(|zone| self.radiance[zone] * self.shares(zone)[zone])
    }

    /// Returns what an even field of radiance 1 sends along the view, in a channel: as the sum over
    /// the zones, and as an integral over facets.
    pub fn under_an_even_field(&self, channel: usize) -> [f64; 2] {
        let by_facets = match self.lobe {
            Lobe::Metal(metal) => {
                let reflectance = DVec3::splat(metal.reflectance[channel]);
                ggx::reflected(
                    Ggx {
                        reflectance,
                        ..metal
                    },
                    self.wo(),
                )
            }
            Lobe::Glass(glass) => {
                let [reflected, transmitted] = rough_glass::shares(glass, self.wo(), TOLERANCE);
                reflected + transmitted / (glass.index * glass.index)
            }
        };
        [self.shares(channel).iter().sum(), by_facets]
    }

    /// Builds the scene. The eye sees nothing but the centre of the patch, where the zones' ends
    /// are.
    pub(super) fn scene(&self) -> Arc<Scene> {
        let camera = Camera::new(self.ray().origin, DVec3::ZERO, DVec3::Z, 0.002);
        seen_by(camera, "glossy patch", |s| {
            for (channel, (ends, radiance)) in self.cuts.windows(2).zip(self.radiance).enumerate() {
                let mut emission = DVec3::ZERO;
                emission[channel] = radiance;
                let surface = Surface::new(Bsdf::Black).emitting(emission);
                add_zone(s, [ends[0], ends[1]], surface);
            }
            let bsdf = match self.lobe {
                Lobe::Metal(metal) => Bsdf::model(metal),
                Lobe::Glass(glass) => Bsdf::RoughGlass(glass),
            };
            let Frame { x, y, .. } = Self::frame();
            let edges = [0.2 * x, 0.2 * y];
            panel(
                s,
                -0.5 * (edges[0] + edges[1]),
                edges,
                Surface::new(bsdf).absorbing(0.25),
            );
        })
    }
}
