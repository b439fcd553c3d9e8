//! Models that are not of the library are rendered like its own, by every estimator, to the last bit.

use whitefurnace::bsdf::Model;

use crate::channels::{lambertian, physical_images, room};
use crate::prelude::*;

/// Lambert, as an outsider would write it: albedo, and a number that multiplies the pdf and should be 1.
#[derive(Debug)]
struct Paper(DVec3, f64);

impl Model for Paper {
    fn eval(&self, _: DVec3, _: DVec3) -> DVec3 {
        lambert(self.0)
    }
    fn sample(&self, _: DVec3, random: [f64; 2]) -> Option<DVec3> {
        Some(cosine_hemisphere(random))
    }
    fn pdf(&self, _: DVec3, wi: DVec3) -> f64 {
        self.1 * cosine_hemisphere_pdf(wi.z)
    }
    fn albedo(&self) -> DVec3 {
        self.0
    }
}

#[test]
fn a_model_of_ones_own_makes_the_same_images() {
    let images = |model: fn(DVec3) -> Bsdf| physical_images(&room(|colour| colour, |light| light, false, model));
    let [ours, own, wrong] =
        [lambertian, |albedo| Bsdf::model(Paper(albedo, 1.0)), |albedo| Bsdf::model(Paper(albedo, 2.0))].map(images);
    for (((name, ours), (_, own)), (_, wrong)) in ours.iter().zip(own).zip(wrong) {
        assert!(*ours == own, "{name}: not the same image");
        // These two take uniform directions, or none.
        assert_eq!(*ours == wrong, ["report", "whitted"].contains(name), "{name}: does it ask for the pdf?");
    }
}
