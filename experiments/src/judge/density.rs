//! The named densities.

use std::f64::consts::{PI, TAU};
use std::str::FromStr;

use glam::DVec3;
use whitefurnace::harness::directions::Density;
use whitefurnace::harness::domain::Domain;
use whitefurnace::material::Model as _;
use whitefurnace::material::ggx::{Ggx, ndf};
use whitefurnace::math::frame::from_spherical;
use whitefurnace::sampling::warp::{cosine_hemisphere_pdf, uniform_hemisphere_pdf};

/// A density by name, with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NamedDensity {
    UniformSphere,
    UniformHemisphere,
    Cosine,
    CosinePower(f64),
    HenyeyGreenstein(f64),
    GgxNormals(f64),
    Ggx(f64, f64),
}

const NAMES: &str = "uniform-sphere, uniform-hemisphere, cosine, cosine-power:N, henyey-greenstein:G, ggx-normals:ALPHA and \
                     ggx:ALPHA,DEGREES";

impl FromStr for NamedDensity {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let (name, numbers) = text.split_once(':').unwrap_or((text, ""));
        let parsed: Result<Vec<f64>, _> = numbers
            .split(',')
            .filter(|n| !n.is_empty())
            .map(str::parse)
            .collect();
        let numbers = parsed.map_err(|_| {
            format!("what follows {name}: must be numbers with commas between them")
        })?;
        let limits = |good: bool, named: Self, limits: &str| {
            if good {
                Ok(named)
            } else {
                Err(limits.to_owned())
            }
        };
        match (name, numbers.as_slice()) {
            ("uniform-sphere", []) => Ok(Self::UniformSphere),
            ("uniform-hemisphere", []) => Ok(Self::UniformHemisphere),
            ("cosine", []) => Ok(Self::Cosine),
            ("cosine-power", &[n]) => limits(
                (0.0..=1e4).contains(&n),
                Self::CosinePower(n),
                "N must be from 0 to 10000",
            ),
            ("henyey-greenstein", &[g]) => limits(
                g.abs() <= 0.99,
                Self::HenyeyGreenstein(g),
                "G must be from -0.99 to 0.99",
            ),
            ("ggx-normals", &[alpha]) => limits(
                (0.01..=1.0).contains(&alpha),
                Self::GgxNormals(alpha),
                "ALPHA must be from 0.01 to 1",
            ),
            ("ggx", &[alpha, degrees]) => limits(
                (0.01..=1.0).contains(&alpha) && (0.0..=89.0).contains(&degrees),
                Self::Ggx(alpha, degrees),
                "ALPHA must be from 0.01 to 1, DEGREES from 0 to 89",
            ),
            _ => Err(format!(
                "unknown density, or wrong number of parameters; there are {NAMES}"
            )),
        }
    }
}

impl NamedDensity {
    pub(super) fn density(&self) -> Density {
        match *self {
            Self::UniformSphere => Density::new(Domain::Sphere, |_| 0.5 / TAU),
            Self::UniformHemisphere => {
                Density::new(Domain::Hemisphere, |w| uniform_hemisphere_pdf(w.z))
            }
            Self::Cosine => Density::new(Domain::CosineHemisphere, |w| cosine_hemisphere_pdf(w.z)),
            Self::CosinePower(n) => Density::new(Domain::CosineHemisphere, move |w| {
                (n + 1.0) / TAU * w.z.max(0.0).powf(n)
            }),
            Self::HenyeyGreenstein(g) => Density::new(Domain::Sphere, move |w| {
                (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * w.z).powf(1.5))
            }),
            Self::GgxNormals(alpha) => {
                Density::new(Domain::CosineHemisphere, move |m| ndf(alpha, m) * m.z)
            }
            Self::Ggx(alpha, degrees) => {
                let (ggx, wo) = (
                    Ggx {
                        reflectance: DVec3::ONE,
                        alpha,
                    },
                    from_spherical(degrees.to_radians(), 0.0),
                );
                Density::new(Domain::Hemisphere, move |wi| {
                    if wi.z > 0.0 { ggx.pdf(wo, wi) } else { 0.0 }
                })
            }
        }
    }
}
