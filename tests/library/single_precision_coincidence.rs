//! Tests of single precision with surfaces close to each other and with long rays: scenes that are
//! accepted look as in double precision in each estimator, and scenes that are refused would not.

use whitefurnace::render::check_single_precision;
use whitefurnace::scene::SINGLE_COINCIDENCE_TOLERANCE;

use crate::prelude::*;

/// The largest coordinate.
const EXTENT: f64 = 3.0;

fn estimators() -> [LaneEstimator<'static>; 4] {
    let path = |strategy| Path::new(strategy);
    let specular_nee = Path {
        specular_nee: true,
        ..path(PathStrategy::Mis)
    };
    [
        path(PathStrategy::Mis),
        path(PathStrategy::Bsdf),
        path(PathStrategy::Light),
        specular_nee,
    ]
    .map(LaneEstimator::Path)
}

/// Renders an image and returns its mean radiance.
fn mean(scene: &Scene, estimator: LaneEstimator, precision: Precision) -> f64 {
    let seed = seed_for(5, "near in singles");
    let sampling = sampling(Random, SamplerKind::Independent, seed);
    let film = filled(
        &lanes(estimator, sampling, precision),
        scene,
        [16, 12],
        0..16,
    );
    film.expect("legal values").mean()
}

/// A patch under two parallel sheets at this distance, added in either order.
fn covered(gap: f64, [front, back]: [Surface; 2], is_reversed: bool) -> Scene {
    scene_from(
        Camera::new(DVec3::new(0.0, -0.3, 0.4), DVec3::ZERO, DVec3::Z, 0.3),
        |s| {
            square(s, 1.0, 0.0, true, diffuse(0.8));
            // A lamp that is visible in a mirror.
            square(s, EXTENT, -0.4, true, lamp(1.0));
            let sheets = [(1.0 - gap, front), (1.0, back)];
            let [first, second] =
                if is_reversed { [1, 0] } else { [0, 1] }.map(|i: usize| sheets[i]);
            for (height, surface) in [first, second] {
                square(s, EXTENT, height, false, surface);
            }
        },
    )
}

#[test]
fn a_cover_hides_what_is_just_behind_it_or_is_refused() {
    let black = Surface::new(Bsdf::Black);
    let tolerance = SINGLE_COINCIDENCE_TOLERANCE * EXTENT;
    for behind in [
        lamp(5.0),
        Surface::new(Bsdf::Mirror {
            reflectance: DVec3::ONE,
        }),
    ] {
        let mut seen = 0.0_f64;
        for (is_reversed, estimator) in [false, true]
            .into_iter()
            .flat_map(|order| estimators().map(|e| (order, e)))
        {
            let scene = covered(1.05 * tolerance, [black, behind], is_reversed);
            check_single_precision(&scene).expect("far enough apart");
            assert_eq!(
                mean(&scene, estimator, Precision::Single),
                0.0,
                "{estimator:?}, {behind:?}"
            );
            let scene = covered(0.2 * tolerance, [black, behind], is_reversed);
            assert_option_refused(
                check_single_precision(&scene),
                "in single precision object ",
            );
            assert_eq!(mean(&scene, estimator, Precision::Double), 0.0);
            seen = seen.max(mean(&scene, estimator, Precision::UncheckedSingle));
            // Distances up to the tolerance are refused in either order.
            let scene = covered(0.95 * tolerance, [black, behind], is_reversed);
            assert_option_refused(check_single_precision(&scene), "move one of them by ");
        }
        assert!(seen > 0.0, "{behind:?} need not be refused");
    }
    // Sharp edges are accepted.
    let wedge = scene(|s| {
        let shine = s.surface(lamp(1.0));
        let corners = [
            DVec3::ZERO,
            DVec3::X,
            DVec3::new(0.0, 1.0, 0.05),
            DVec3::new(0.0, 1.0, -0.05),
        ];
        s.mesh(&corners, &[[0, 1, 2], [1, 0, 3]], shine);
    });
    assert_eq!(wedge.coincident_in_singles(), None);
}

/// Shadow rays to a small, distant lamp end before it, not within.
#[test]
fn a_small_lamp_lights_a_wide_room_as_in_double_precision() {
    for centre in [DVec3::ZERO, DVec3::new(700.0, -300.0, 500.0)] {
        let scene = scene_from(
            Camera::new(DVec3::new(-900.0, 0.0, 0.0), DVec3::ZERO, DVec3::Z, 0.5),
            |s| {
                let walls = s.surface(diffuse(0.5));
                simple::closed_cube(s, 1000.0, true, walls);
                ball(s, Sphere::new(centre, 1.0), lamp(1e6));
            },
        );
        for estimator in [estimators()[0], estimators()[2]] {
            check_single_precision(&scene).expect("accepted");
            let [double, single] =
                [Precision::Double, Precision::Single].map(|p| mean(&scene, estimator, p));
            assert!(
                double > 0.0 && (single / double - 1.0).abs() < 1e-3,
                "{estimator:?}: {single} and {double}"
            );
        }
    }
}
