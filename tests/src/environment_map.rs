//! Environment maps through the path tracer: the CIE overcast sky over a floor, a sky that varies
//! by azimuth beside a wall, and a sky partly hidden by a light, each in closed form.

use whitefurnace::light::emitter::LightSampling;
use whitefurnace::light::environment::{Environment, EnvironmentMap};

use crate::prelude::*;
use crate::scenes::{
    FLOOR, HEIGHT, LIGHT, RECTANGLE, TINT, floor, lambert, light, panel, polygon_irradiance,
    ray_to_origin, scene, square,
};
use crate::strategies::path_with;

/// Sets a sky of these radiances, row by row from the zenith; the middle of each row is towards x.
pub(super) fn sky(builder: &mut SceneBuilder, size: [usize; 2], pixels: Vec<DVec3>) {
    let map = EnvironmentMap::new(size, pixels, DVec3::Z, DVec3::X);
    builder.environment(Environment::Map(
        map.unwrap_or_else(|error| panic!("{error}")),
    ));
}

/// Bands of the overcast sky: with linear interpolation between their middles it is accurate to
/// 10⁻⁴.
const BANDS: usize = 180;

/// L(θ) = L_z (1 + 2 cos θ)/3 above the horizon (CIE S 011), darkness below. A horizontal plane
/// receives 7π/9 L_z.
fn overcast() -> Arc<Scene> {
    scene("overcast", |s| {
        floor(s, lambert(FLOOR));
        let cosine = |band: usize| (PI * (band as f64 + 0.5) / BANDS as f64).cos();
        let radiance = |cosine: f64| {
            if cosine > 0.0 {
                LIGHT * (1.0 + 2.0 * cosine) / 3.0
            } else {
                0.0
            }
        };
        sky(
            s,
            [1, BANDS],
            (0..BANDS)
                .map(|band| DVec3::splat(radiance(cosine(band))))
                .collect(),
        );
    })
}

/// Radiances at −135°, −45°, 45° and 135° to the right of x, linear in azimuth between them.
const RADIANCES: [f64; 4] = [0.5, 3.0, 1.0, 2.0];

/// Direction of the third of [`RADIANCES`].
fn towards_third() -> DVec3 {
    DVec3::new(1.0, -1.0, 0.0).normalize()
}

/// A wall that faces the third of [`RADIANCES`].
fn wall() -> Arc<Scene> {
    scene("wall", |s| {
        let edges = [100.0 * DVec3::Z, 100.0 * towards_third().cross(DVec3::Z)];
        panel(
            s,
            -0.5 * (edges[0] + edges[1]),
            edges,
            Surface::new(lambert(FLOOR)),
        );
        sky(s, [4, 1], RADIANCES.map(DVec3::splat).to_vec());
    })
}

/// Irradiance of the wall: (π/2) ∫ L(φ) cos φ dφ from −90° to 90°.
fn beside_wall() -> f64 {
    let [_, left, middle, right] = RADIANCES;
    0.5 * PI * (2.0 * middle + (left + right - 2.0 * middle) * (1.0 - 2.0 / PI))
}

/// A sky of radiance 1, partly hidden by the light of [`crate::scenes::rectangle_light`].
fn behind_light() -> Arc<Scene> {
    scene("sky behind a light", |s| {
        floor(s, lambert(FLOOR));
        square(s, HEIGHT * DVec3::Z, 1.0, false, light(LIGHT));
        sky(s, [2, 2], vec![TINT; 4]);
    })
}

pub(crate) fn trials() -> Vec<FamilyTrial<EstimatorSubject>> {
    let by = |strategy| path_with(strategy, LightSampling::Area);
    let of = |name,
              consequence: &str,
              scene: &Arc<Scene>,
              (kind, ray): (EstimatorKind, Rays),
              what: &str,
              irradiance: f64,
              draws| {
        let reference = FLOOR * FRAC_1_PI * irradiance;
        let property = format!("{what} reflects {reference:.6}");
        radiance(name, &MIS, scene, kind, ray)
            .states(property, consequence)
            .by_draws(reference, BOUNCES_DELTA, draws)
    };
    let (overcast, behind_light) = (overcast(), behind_light());
    let floor = |name, consequence, kind, draws| {
        let irradiance = 7.0 / 9.0 * PI * LIGHT;
        of(
            name,
            consequence,
            &overcast,
            (kind, |_| ray_to_origin()),
            "a floor under the CIE overcast sky",
            irradiance,
            draws,
        )
    };
    let panel = polygon_irradiance(&RECTANGLE);
    let panelled = PI - panel + LIGHT * panel;
    vec![
        floor(
            "sky/overcast/mis",
            "outdoor scenes are too bright or dark, as hits of the sky count twice or too little",
            EstimatorKind::Path,
            Draws::Rays(500_000),
        ),
        floor(
            "sky/overcast/light",
            "outdoor light is off, as shadow rays crowd at the top of an environment map",
            by(Strategy::Light),
            Draws::scrambles(16, 9_500),
        ),
        floor(
            "sky/overcast/bsdf",
            "an environment map lights matte things too much or too little by BSDF samples",
            by(Strategy::Bsdf),
            Draws::Rays(800_000),
        ),
        of(
            "sky/wall/mis",
            "an environment map lights walls from the wrong side, as if mirrored or turned",
            &wall(),
            (EstimatorKind::Path, |_| {
                let w = (towards_third() + 0.4 * DVec3::Z).normalize();
                Ray::new(0.1 * w, -w)
            }),
            "a wall beside a sky that varies by azimuth",
            beside_wall(),
            Draws::scrambles(16, 10_700),
        ),
        of(
            "sky/panel",
            "a lamp before an environment map is too dim, or the map shines through it",
            &behind_light,
            (EstimatorKind::Path, |_| ray_to_origin()),
            "a floor under a white sky of which a light hides a part",
            panelled,
            Draws::scrambles(16, 11_000),
        ),
    ]
}

pub(crate) fn faults() -> Vec<Fault<EstimatorSubject>> {
    vec![
        fault!("map-crowded-above", MIS, "directions crowd at the top of a map, with the pdf of those that do not",
            { sample_map: |map, [r1, r2]| map.sample([r1 * r1, r2]) }, "sky/overcast/light"),
        fault!("map-share-forgotten", MIS, "the pdf ignores that a shadow ray samples either the map or a light",
            { sample_map: |map, random| {
                let (direction, pdf) = map.sample(random);
                (direction, 2.0 * pdf)
            } }, "sky/panel"),
        fault!("map-pdf-mirrored", MIS, "the pdf is that of the map mirrored, left for right",
            { sample_map: |map, random| {
                let (direction, _) = map.sample(random);
                (direction, map.pdf(DVec3 { y: -direction.y, ..direction }))
            } }, "sky/wall/mis"),
        fault!("map-hits-in-full", MIS, "a path that leaves the scene counts the map in full, shadow rays or not",
            { map_pdf: |_, _| 0.0 }, "sky/overcast/mis", "sky/wall/mis", "sky/panel"),
        fault!("map-everywhere", GEOMETRY, "the map is seen through everything",
            { sees_background: |_, _, _| true }, "sky/panel"),
        fault!("map-hits-weighted-less", MIS, "hits of the map are weighted with five times its pdf",
            { map_pdf: |map, direction| 5.0 * map.pdf(direction) }, "sky/overcast/mis", "sky/panel"),
    ]
}
