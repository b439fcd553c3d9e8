//! The albedos of the scene `cornell` against the reflectances that Cornell measured in the real
//! box.
//!
//! Three numbers stand for a spectrum of 76. Those of our file have been handed on from renderer to
//! renderer; they are reflectances in narrow bands, not what the eye integrates.

use whitefurnace::scene::file::Description;

use crate::mean_radiance::largest;
use crate::prelude::*;

/// Materials, in the order of the table's columns.
const MATERIALS: [&str; 3] = ["white", "green", "red"];

/// Bands of wavelengths, nm, in which the measured reflectances are nearly the red, green and blue
/// of our file.
const BANDS: [[f64; 2]; 3] = [[640.0, 700.0], [520.0, 550.0], [424.0, 444.0]];

/// Largest difference from the means over the bands.
const TOLERANCE: f64 = 0.01;

/// Red, green and blue of the measured reflectances by [`by_eye`], rounded.
pub const BY_EYE: [[f64; 3]; 3] = [
    [0.738, 0.736, 0.737], // white
    [0.088, 0.399, 0.084], // green
    [0.472, 0.047, 0.049], // red
];

/// Returns wavelength, nm, and reflectance of the materials.
fn spectra() -> impl Iterator<Item = (f64, DVec3)> {
    include_str!("cornell.tsv")
        .lines()
        .filter(|line| line.starts_with(|first: char| first.is_ascii_digit()))
        .map(|line| {
            let numbers: Vec<f64> = line
                .split('\t')
                .map(|number| number.parse().expect("a number"))
                .collect();
            let [wavelength, white, green, red] = numbers[..] else {
                panic!("{line}: four columns");
            };
            (wavelength, DVec3::new(white, green, red))
        })
}

/// The colour matching functions of CIE 1931 at a wavelength, nm, by the fit of Wyman, Sloan and
/// Shirley, JCGT 2(2), 2013.
fn colour_matching(wavelength: f64) -> DVec3 {
    let lobe = |height: f64, at: f64, [below, above]: [f64; 2]| {
        let width = if wavelength < at { below } else { above };
        height * (-0.5 * ((wavelength - at) / width).powi(2)).exp()
    };
    DVec3::new(
        lobe(1.056, 599.8, [37.9, 31.0]) + lobe(0.362, 442.0, [16.0, 26.7])
            - lobe(0.065, 501.1, [20.4, 26.2]),
        lobe(0.821, 568.8, [46.9, 40.5]) + lobe(0.286, 530.9, [16.3, 31.1]),
        lobe(1.217, 437.0, [11.8, 36.0]) + lobe(0.681, 459.0, [26.0, 13.8]),
    )
}

/// Converts CIE XYZ to the linear primaries of sRGB, IEC 61966-2-1.
fn to_srgb(xyz: DVec3) -> DVec3 {
    DVec3::new(
        DVec3::new(3.240_454_2, -1.537_138_5, -0.498_531_4).dot(xyz),
        DVec3::new(-0.969_266, 1.876_010_8, 0.041_556).dot(xyz),
        DVec3::new(0.055_643_4, -0.204_025_9, 1.057_225_2).dot(xyz),
    )
}

/// Returns red, green and blue of each material under light of equal energy at all wavelengths, in
/// units of those of a perfect reflector.
pub fn by_eye() -> [DVec3; 3] {
    let reduced = |reflectance: fn(DVec3) -> f64| {
        let sum = spectra().map(|(wavelength, of)| reflectance(of) * colour_matching(wavelength));
        to_srgb(sum.sum())
    };
    let white = reduced(|_| 1.0);
    let columns: [fn(DVec3) -> f64; 3] = [|of| of.x, |of| of.y, |of| of.z];
    columns.map(|column| reduced(column) / white)
}

/// Returns the mean reflectance of the materials in each of [`BANDS`].
fn in_bands() -> [DVec3; 3] {
    BANDS.map(|[low, high]| {
        let inside: Vec<DVec3> = spectra()
            .filter(|(wavelength, _)| (low..=high).contains(wavelength))
            .map(|(_, of)| of)
            .collect();
        inside.iter().sum::<DVec3>() / inside.len() as f64
    })
}

/// Albedo of each of `MATERIALS`.
#[derive(Clone, Copy, Debug)]
pub struct Albedos(fn(usize) -> DVec3);

/// Returns the albedo of a material in our file.
fn of_file(material: usize) -> DVec3 {
    let text = include_str!("../../../src/scene/files/cornell.toml");
    let scene = Description::parse("cornell", text).expect("a scene file");
    let of_name = |(name, _): &&(String, Surface)| name == MATERIALS[material];
    let found = scene.materials.iter().find(of_name).expect("a material");
    found.1.bsdf.albedo()
}

fn near_the_measured(_: &Context, albedos: Albedos) -> Vec<Outcome> {
    let bands = in_bands();
    let errors = (0..MATERIALS.len()).flat_map(|material| {
        let measured = DVec3::from_array(bands.map(|band| band[material]));
        let differences = (albedos.0)(material) - measured;
        differences.abs().to_array()
    });
    let count = MATERIALS.len() * BANDS.len();
    let bands = "means over 640 to 700, 520 to 550 and 424 to 444 nm";
    vec![Outcome::identity(
        "albedo",
        count as u64,
        largest(errors),
        TOLERANCE,
        bands,
    )]
}

/// The trial of the albedos and its faults.
pub(super) fn family() -> Box<dyn AnyFamily> {
    Box::new(Family {
        trials: vec![trial(
            "references/cornell-albedos",
            "the albedos of the Cornell box are reflectances that Cornell measured, in three narrow bands",
            "the walls of the Cornell box tint the room in hues that the real walls do not have",
            &LAMBERT,
            "scene::simple::cornell",
            "exact",
            near_the_measured,
        )],
        faults: vec![
            fault!("walls-exchanged", LAMBERT, "the red and the green wall have each other's albedo",
                = Albedos(|material| of_file([0, 2, 1][material])), "references/cornell-albedos"),
            fault!("by-eye", LAMBERT, "albedos as the eye integrates the spectra",
                = Albedos(|material| DVec3::from_array(BY_EYE[material])), "references/cornell-albedos"),
        ],
        ..Family::new("cornell", Albedos(of_file))
    })
}
