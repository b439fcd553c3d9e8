//! Tests that reflection models from outside the library are rendered like its own, by every
//! estimator, to the last bit.

use whitefurnace::material::{Model, Vertex};

use crate::channels::{lambertian, physical_images, room};
use crate::prelude::*;

/// Lambert's BRDF, as a user would write it: albedo, and a factor of the pdf that should be 1.
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
    let images = |model: fn(DVec3) -> Bsdf| {
        physical_images(&room(|colour| colour, |light| light, false, model))
    };
    let [ours, own, wrong] = [
        lambertian,
        |albedo| Bsdf::model(Paper(albedo, 1.0)),
        |albedo| Bsdf::model(Paper(albedo, 2.0)),
    ]
    .map(images);
    for (((name, ours), (_, own)), (_, wrong)) in ours.iter().zip(own).zip(wrong) {
        assert!(*ours == own, "{name}: not the same image");
        // These two use uniform directions, or none.
        assert_eq!(
            *ours == wrong,
            ["report", "whitted"].contains(name),
            "{name}: does it ask for the pdf?"
        );
    }
}

#[test]
fn models_are_equal_if_they_are_one() {
    let [one, other] = [0.5, 0.5].map(|albedo| Bsdf::model(Paper(DVec3::splat(albedo), 1.0)));
    assert_eq!(one, one);
    assert_ne!(one, other);
}

/// A vertex without a scene is the same from either side of the surface.
#[test]
fn local_vertices_are_above_the_horizon() {
    let wo = DVec3::new(0.6, 0.0, 0.8);
    for outside in [true, false] {
        let at = Vertex::local(wo, outside);
        assert_eq!(
            (at.wo, at.direction, at.frame.z, at.outside),
            (wo, -wo, DVec3::Z, outside)
        );
    }
}

/// A model whose pdf is positive everywhere.
#[derive(Debug)]
struct Anywhere;

impl Model for Anywhere {
    fn eval(&self, _: DVec3, _: DVec3) -> DVec3 {
        DVec3::ONE
    }
    fn sample(&self, _: DVec3, _: [f64; 2]) -> Option<DVec3> {
        Some(DVec3::Z)
    }
    fn pdf(&self, _: DVec3, _: DVec3) -> f64 {
        1.0
    }
    fn albedo(&self) -> DVec3 {
        DVec3::ONE
    }
}

/// Models are asked for pdfs above the horizon only.
#[test]
fn models_have_no_pdf_below_the_horizon() {
    let bsdf = Bsdf::model(Anywhere);
    let heights = [-0.5, 0.0, 0.5];
    for (wo, wi) in heights.into_iter().flat_map(|a| heights.map(|b| (a, b))) {
        let found = DefaultParts.pdf(&bsdf, DVec3::X.with_z(wo), DVec3::X.with_z(wi));
        assert_eq!(found, f64::from(wo > 0.0 && wi > 0.0));
    }
}
