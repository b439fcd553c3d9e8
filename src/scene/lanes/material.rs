//! Surfaces as rows of numbers, as the rays of all lanes read them.

use crate::material::{Bsdf, OrenNayar, OrenNayarForm};
use crate::scene::Surface;

/// Material parameters of a surface and the bits of its kinds.
pub(crate) struct Material {
    /// Refractive index of glass, A and B of (15), and α of section 2.6.2.
    pub numbers: [f64; 4],
    /// Bitwise or of the kinds below.
    pub kinds: u16,
}

/// The BSDF is not a Dirac distribution.
pub(crate) const NON_DELTA: u16 = 1;
/// The BSDF is not a Dirac distribution and not cosine-sampled.
pub(crate) const NOT_COSINE_SAMPLED: u16 = 2;
pub(crate) const MIRROR: u16 = 4;
pub(crate) const GLASS: u16 = 8;
/// Oren-Nayar by (14) as printed.
pub(crate) const PRINTED: u16 = 16;
/// f_r is evaluated lane by lane.
pub(crate) const PER_LANE: u16 = 32;
/// The surface emits light, whatever its BSDF.
pub(crate) const EMITTER: u16 = 64;
/// The primitive is a sphere, not a triangle.
pub(crate) const SPHERE: u16 = 128;
/// Rough glass, which also scatters light to its far side.
pub(crate) const ROUGH_GLASS: u16 = 256;

impl Material {
    pub fn new(
        &Surface {
            bsdf, absorption, ..
        }: &Surface,
    ) -> Self {
        // (14) is (13) with these constants.
        let (mut index, mut oren_nayar) = (1.0, OrenNayar { a: 1.0, b: 0.0 });
        let kinds = match bsdf {
            Bsdf::Black => 0,
            Bsdf::Lambert { .. } => NON_DELTA,
            Bsdf::OrenNayar {
                constants, form, ..
            } => {
                oren_nayar = constants;
                if form == OrenNayarForm::Printed {
                    NON_DELTA | PRINTED
                } else {
                    NON_DELTA
                }
            }
            Bsdf::Mirror { .. } => MIRROR,
            Bsdf::Glass { index: of_glass } => {
                index = of_glass;
                GLASS
            }
            Bsdf::RoughGlass(_) => NON_DELTA | PER_LANE | ROUGH_GLASS,
            Bsdf::Eon { .. } | Bsdf::Model(_) => NON_DELTA | PER_LANE,
        };
        let is_not_cosine_sampled = kinds & NON_DELTA != 0 && !bsdf.is_sampled_by_cosine();
        let kinds = if is_not_cosine_sampled {
            kinds | NOT_COSINE_SAMPLED
        } else {
            kinds
        };
        Self {
            numbers: [index, oren_nayar.a, oren_nayar.b, absorption],
            kinds,
        }
    }
}
