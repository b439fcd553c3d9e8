//! Models that are not of the library are rendered like its own, by every estimator, to the last bit.

use whitefurnace::bsdf::Model;
use whitefurnace::scene::simple::closed_cube;

use crate::channels::physical_images;
use crate::prelude::*;

const ALBEDO: DVec3 = DVec3::new(0.7, 0.5, 0.2);

/// Lambert, as an outsider would write it; the pdf is multiplied by the number, which should be 1.
#[derive(Debug)]
struct Paper(f64);

impl Model for Paper {
    fn eval(&self, _: DVec3, _: DVec3) -> DVec3 {
        lambert(ALBEDO)
    }
    fn sample(&self, _: DVec3, random: [f64; 2]) -> Option<DVec3> {
        Some(cosine_hemisphere(random))
    }
    fn pdf(&self, _: DVec3, wi: DVec3) -> f64 {
        self.0 * cosine_hemisphere_pdf(wi.z)
    }
    fn albedo(&self) -> DVec3 {
        ALBEDO
    }
}

/// A cube of the model that emits a little, with a lamp, a mirror and glass in it.
fn room(bsdf: Bsdf) -> Scene {
    let mut room = SceneBuilder::new("model");
    let wall = Surface::new(bsdf).emitting(DVec3::splat(0.1)).absorbing(0.5);
    let wall = room.surface(wall);
    closed_cube(&mut room, 1.0, true, wall);
    let mut ball = |x: f64, y: f64, z: f64, surface: Surface| {
        let surface = room.surface(surface);
        room.sphere(Sphere::new(DVec3::new(x, y, z), 0.3), surface);
    };
    ball(0.5, 0.4, 0.3, lamp(1.0));
    ball(0.4, -0.5, -0.2, Surface::new(Bsdf::Mirror { reflectance: DVec3::splat(0.9) }));
    ball(-0.4, 0.4, -0.5, Surface::new(Bsdf::Glass { index: 1.5 }));
    let eye = DVec3::new(-0.9, -0.9, 0.2);
    room.build(Camera::new(eye, DVec3::ZERO, DVec3::Z, 0.7)).expect("a legal scene")
}

#[test]
fn a_model_of_ones_own_makes_the_same_images() {
    let images = |bsdf| physical_images(&room(bsdf));
    let ours = images(Bsdf::Lambert { albedo: ALBEDO });
    let own = images(Bsdf::model(Paper(1.0)));
    let wrong = images(Bsdf::model(Paper(2.0)));
    for (((name, ours), (_, own)), (_, wrong)) in ours.iter().zip(own).zip(wrong) {
        assert!(*ours == own, "{name}: not the same image");
        // These two take uniform directions, or none.
        let deaf = ["report", "whitted"].contains(name);
        assert_eq!(*ours == wrong, deaf, "{name}: does it ask for the pdf?");
    }
}
