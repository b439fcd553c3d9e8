//! Tests of the film's accumulators: exact, mergeable in any order, strict about sizes.

use rayon::prelude::*;
use whitefurnace::film::MAX_FILM_PIXELS;
use whitefurnace::film::splat::Splats;

use crate::prelude::*;

fn pixel(values: &[DVec3]) -> Pixel {
    let mut pixel = Pixel::default();
    for &value in values {
        pixel.push(value.abs(), 1).expect("a legal value");
    }
    pixel
}

#[test]
fn pixels_hold_mean_and_standard_error_and_merge_exactly() {
    let strategy = (
        prop::collection::vec(point(10.0), 2..40),
        any::<prop::sample::Index>(),
    );
    property("pixel", 300, &strategy, |(values, cut)| {
        let all = pixel(&values);
        assert_eq!(all.replications(), values.len() as u32);
        let moments = [0, 1, 2].map(|i| values.iter().map(|v| v[i].abs()).collect::<Moments>());
        // Values of at most 10 move by half a unit; 40 of them are summed.
        let bound = FIXED_POINT_UNIT + 4000.0 * UNIT_ROUNDOFF;
        assert_abs_diff_eq!(
            all.mean(),
            DVec3::from(moments.map(|m| m.mean())),
            epsilon = bound
        );
        let error = DVec3::from(moments.map(|m| m.standard_error()));
        assert_abs_diff_eq!(all.standard_error(), error, epsilon = 2.0 * bound);
        let (a, b) = values.split_at(cut.index(values.len()));
        let (a, b, none) = (pixel(a), pixel(b), Pixel::default());
        for (one, other) in [(a, b), (b, a), (all, none)] {
            let mut merged = one;
            merged.merge(&other).expect("room for more");
            assert_eq!(merged, all);
        }
    });
}

#[test]
fn pixels_without_replications() {
    let empty = Pixel::default();
    assert_eq!(
        (empty.mean(), empty.standard_error(), empty.features().depth),
        (DVec3::ZERO, DVec3::INFINITY, 0.0)
    );
    assert_eq!(pixel(&[DVec3::ONE]).standard_error(), DVec3::INFINITY);
    assert_eq!(pixel(&[DVec3::ONE; 2]).standard_error(), DVec3::ZERO);
}

#[test]
fn features_are_means_over_the_hits() {
    let feature = |albedo: f64, depth: f64| Features {
        albedo: DVec3::new(albedo, 0.5, 1.0),
        normal: if albedo < 0.6 { -DVec3::Y } else { DVec3::Z },
        depth,
    };
    let (mut one, mut other) = (Pixel::default(), Pixel::default());
    one.push_features(&feature(0.25, 2.0)).expect("legal");
    one.push_features(&feature(0.75, 4.0)).expect("legal");
    other.push_features(&feature(0.5, 12.0)).expect("legal");
    one.merge(&other).expect("room for more");
    let found = one.features();
    assert_eq!(found.albedo, DVec3::new(0.5, 0.5, 1.0));
    assert_abs_diff_eq!(
        found.normal,
        DVec3::new(0.0, -2.0, 1.0) / 3.0,
        epsilon = FIXED_POINT_UNIT
    );
    assert_eq!(found.depth, 6.0);
    // Rays without a hit do not count; replications do not matter.
    one.push(DVec3::ONE, 1).expect("legal");
    assert_eq!(one.features().depth, 6.0);
}

#[test]
fn films_have_possible_sizes() {
    const TOO_MANY: u32 = MAX_FILM_PIXELS as u32 + 1;
    let window = |x, y, width, height| {
        Some(Window {
            corner: [x, y],
            size: [width, height],
        })
    };
    let large = [1 << 20, 1 << 20];
    for (frame, window, hint) in [
        ([0, 5], None, "at least 1"),
        ([5, 0], None, "at least 1"),
        ([0, 0], None, "at least 1"),
        ([1_000_000_000, 1_000_000_000], None, "memory"),
        ([u32::MAX, u32::MAX], None, "memory"),
        (large, None, "memory"),
        ([TOO_MANY, 1], None, "memory"),
        ([8, 6], window(0, 0, 9, 6), "leaves the frame"),
        ([8, 6], window(0, 0, 8, 7), "leaves the frame"),
        ([8, 6], window(1, 0, 8, 6), "leaves the frame"),
        ([8, 6], window(0, 1, 8, 6), "leaves the frame"),
        ([8, 6], window(8, 0, 1, 1), "leaves the frame"),
        ([8, 6], window(u32::MAX, 0, 2, 1), "leaves the frame"),
        ([8, 6], window(0, u32::MAX, 1, 2), "leaves the frame"),
        ([8, 6], window(0, 0, 0, 3), "at least 1"),
        ([8, 6], window(0, 0, 3, 0), "at least 1"),
        // Pixels are numbered with 32 bits.
        (large, window(7, 7, 2, 2), "smaller"),
    ] {
        assert_option_refused(Film::new(frame, window, 1), hint);
    }
    let film = Film::new([8, 6], window(5, 4, 3, 2), 4).expect("the last pixels");
    assert_eq!((film.resolution(), film.size()), ([8, 6], [3, 2]));
    assert_eq!(film.samples_per_replication(), 4);
    assert_eq!(film.pixels().len(), 6);
    assert!(
        Film::checked_window([TOO_MANY - 1, 1], None).is_ok(),
        "the largest"
    );
    // A small window of a frame too large to hold.
    assert!(Film::new([1 << 15, 1 << 15], window(7, 7, 2, 2), 1).is_ok());
}

#[test]
fn pixels_are_stored_row_by_row() {
    let mut film = Film::new([4, 3], None, 1).expect("a film");
    assert_eq!(film.window().size, [4, 3]);
    film.pixels_mut()[4 * 2 + 1]
        .push(DVec3::ONE, 1)
        .expect("legal");
    assert_eq!(film.pixel(1, 2).replications(), 1);
    assert_eq!(
        film.pixels()
            .iter()
            .filter(|p| p.replications() == 1)
            .count(),
        1
    );
}

#[test]
fn films_of_different_kinds_do_not_merge() {
    let window = Some(Window {
        corner: [1, 0],
        size: [3, 3],
    });
    let film = |frame, window, samples| Film::new(frame, window, samples).expect("a film");
    let mut base = film([4, 3], None, 1);
    for other in [
        film([3, 4], None, 1),
        film([4, 3], window, 1),
        film([4, 3], None, 4),
    ] {
        assert_refused(base.merge(&other), "cannot be merged");
    }
    assert!(base.merge(&film([4, 3], None, 1)).is_ok());
}

#[test]
fn averages_run_over_pixels_and_channels() {
    let mut film = Film::new([2, 1], None, 1).expect("a film");
    for value in [1.0, 3.0] {
        let [first, second] = film.pixels_mut() else {
            unreachable!("two pixels");
        };
        first.push(DVec3::splat(value), 1).expect("legal");
        second.push(DVec3::new(6.0, 0.0, 0.0), 1).expect("legal");
    }
    // Means 2, 2, 2 and 6, 0, 0; standard errors 1, 1, 1 and 0, 0, 0.
    assert_eq!(film.mean(), 2.0);
    assert_abs_diff_eq!(film.relative_error(), 0.25, epsilon = 4.0 * UNIT_ROUNDOFF);
    assert_eq!(Film::new([1, 1], None, 1).expect("a film").mean(), 0.0);
}

/// Splats add up in their own pixels, in images with fewer and with more rows than bands, also
/// where the last band is not full, and through buffers that are flushed more than once.
#[test]
fn splats_add_up_in_their_own_pixel() {
    for [width, height] in [[3, 4], [5, 16], [2, 37], [1, 1], [4, 192]] {
        let image = Splats::new([width, height]);
        let value = |x: u32, y: u32| DVec3::new(f64::from(x), f64::from(y), 0.25);
        (0..3).into_par_iter().for_each(|_| {
            let mut splats = image.buffer();
            for _ in 0..2 {
                for (x, y) in (0..width).flat_map(|x| (0..height).map(move |y| (x, y))) {
                    splats.add([x, y], value(x, y)).expect("legal");
                }
                splats.flush().expect("legal sums");
            }
        });
        let rows = (0..height).flat_map(|y| (0..width).map(move |x| 6.0 * value(x, y)));
        assert_eq!(image.into_values(), rows.collect::<Vec<_>>());
    }
}

/// Rounding stays within its bound for backgrounds from values rounded to 0 to the largest
/// radiance.
#[test]
fn rounding_is_within_its_bound() {
    for exponent in -30..=7 {
        for value in [1.0, 1.3, 1.6, 3.7, 7.1].map(|digits| digits * 10_f64.powi(exponent)) {
            let mut film = Film::new([2, 1], None, 1).expect("a legal size");
            if value > LARGEST {
                continue;
            }
            for pixel in film.pixels_mut() {
                (0..3).for_each(|_| pixel.push(DVec3::splat(value), 1).expect("a legal value"));
            }
            let error = (film.mean() - value).abs();
            assert!(
                error <= (1.0 + 1e-12) * film.rounding_error() * film.mean() || film.mean() == 0.0,
                "{value:e}"
            );
            assert_eq!(
                film.mean() == 0.0,
                value < 0.5 * FIXED_POINT_UNIT,
                "{value:e}"
            );
            assert!(
                error <= (0.5 * FIXED_POINT_UNIT).max(1e-15 * value),
                "{value:e}: {error:e}"
            );
            assert_eq!(
                film.rounding_error() > 1e-4,
                value < 5000.0 * FIXED_POINT_UNIT,
                "{value:e}"
            );
        }
    }
}
