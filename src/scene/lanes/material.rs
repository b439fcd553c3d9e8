//! Surfaces as rows of numbers, as the rays of all lanes read them.

use crate::material::{Bsdf, OrenNayar, OrenNayarForm};
use crate::scene::Surface;

/// A surface by its numbers and kinds.
pub(crate) struct Material {
    /// The index of glass, A and B of (15), and α of section 2.6.2.
    pub numbers: [f64; 4],
    /// A bit for each of the kinds below.
    pub kinds: u16,
}

/// Light leaves in all directions.
pub(crate) const NON_DELTA: u16 = 1;
/// Light leaves in all directions, which are not sampled by the cosine.
pub(crate) const MODEL: u16 = 2;
pub(crate) const MIRROR: u16 = 4;
pub(crate) const GLASS: u16 = 8;
/// (14) as it is printed.
pub(crate) const PRINTED: u16 = 16;
/// f_r is evaluated lane by lane.
pub(crate) const ONE_BY_ONE: u16 = 32;
/// It emits light, whatever it is made of.
pub(crate) const EMITTER: u16 = 64;
/// It is no triangle.
pub(crate) const SPHERE: u16 = 128;
/// Light goes on behind it in all directions.
pub(crate) const ROUGH_GLASS: u16 = 256;

impl Material {
    pub fn new(
        &Surface {
            bsdf, absorption, ..
        }: &Surface,
    ) -> Self {
        // (14) is (13) with these.
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
            Bsdf::RoughGlass(_) => NON_DELTA | ONE_BY_ONE | ROUGH_GLASS,
            Bsdf::Eon { .. } | Bsdf::Model(_) => NON_DELTA | ONE_BY_ONE,
        };
        let is_model = kinds & NON_DELTA != 0 && !bsdf.is_sampled_by_cosine();
        let kinds = if is_model { kinds | MODEL } else { kinds };
        Self {
            numbers: [index, oren_nayar.a, oren_nayar.b, absorption],
            kinds,
        }
    }
}
