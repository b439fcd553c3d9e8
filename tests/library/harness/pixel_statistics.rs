//! Tests of maps of Welch tests and of means of images, against their definitions on small images.

use whitefurnace::harness::images::{ImageMoments, PValueMap};

use super::*;

#[test]
fn maps_leave_out_what_says_nothing() {
    let found = PValueMap {
        width: 3,
        height: 2,
        p: [0.5, -1.0, 0.2, 1.0, 0.001, 0.7]
            .map(|p| (p >= 0.0).then_some(p))
            .to_vec(),
        sigmas: vec![0.7, f64::NAN, 1.3, 0.0, -3.3, 0.4],
        dof: vec![9.0, 8.0, 7.0, 6.0, 5.0, 4.0],
    };
    assert_eq!(found.histogram(4), [2, 0, 2, 1]);
    let mut known = vec![0.5, 0.2, 1.0, 0.001, 0.7];
    let flat = found.flatness("flat", 0.1);
    let expected = Outcome {
        claim: Claim::Equivalent { margin: 0.1 },
        graded: Vec::new(),
        ..kolmogorov_smirnov("flat", &mut known, |p| p, 0.1)
    };
    assert_eq!(flat, expected);
    let smallest = found.smallest("smallest", 17);
    assert_eq!((smallest.name.as_str(), smallest.n), ("smallest", 17));
    assert_relative_eq!(smallest.p, 0.005, max_relative = 1e-12);
    assert_eq!((smallest.value, smallest.estimate), (-3.3, -3.3));
    assert_eq!(smallest.claim, Claim::Test);
    // The level is divided among the five tiles that can be tested.
    assert_eq!(
        smallest.sensitivity,
        Sensitivity::Normal {
            standard_error: 1.0,
            dof: 5.0,
            tests: 5
        }
    );
    assert_eq!(smallest.worst, "(1, 1) of 3 × 2: -3.30 sigmas");
    assert_eq!(smallest.cells.len(), 6);
    let cell = &smallest.cells[5];
    assert_eq!(
        (cell.place.as_str(), cell.observed, cell.sigmas),
        ("x 2 y 1", 0.4, 0.4)
    );
    // NaN is neither left out nor large: it fails, and is the worst.
    let mut broken = found;
    broken.p[3] = Some(f64::NAN);
    let smallest = broken.smallest("smallest", 17);
    assert!(smallest.p.is_nan() && smallest.verdict() == Verdict::Fails);
    assert!(smallest.worst.starts_with("(0, 1)"), "{}", smallest.worst);
    assert_eq!(broken.flatness("flat", 0.1).verdict(), Verdict::Fails);
    assert_eq!(broken.histogram(4), [3, 0, 2, 0]);
}

/// A pixel whose mean or variance is NaN fails instead of being left out.
#[test]
fn a_pixel_that_is_no_number_fails() {
    let right = Image::new(&[1.0, 1.0, 2.0], &[0.1, 0.0, 0.2], &[9; 3]);
    for (mean, variance) in [(f64::NAN, 0.0), (1.0, f64::NAN), (f64::NAN, f64::NAN)] {
        let mut wrong = right.clone();
        (wrong.mean[1], wrong.variance[1]) = (mean, variance);
        let [a, b] = [&wrong, &right].map(Image::statistics);
        assert_eq!(
            welch_map(&a, &b, 3, 1).smallest("pixels", 9).verdict(),
            Verdict::Fails
        );
        assert_eq!(welch_map(&b, &b, 3, 1).p[1], None);
    }
}

/// Returns an image of 7 × 5 pixels, all of them different.
fn image(shift: usize, count: impl Fn(u64) -> u64) -> Image {
    let pixel = |i: usize| ((i + shift) * 37 % 53) as f64;
    Image {
        mean: (0..35).map(|i| 1.0 + 0.01 * pixel(i)).collect(),
        variance: (0..35).map(|i| 0.04 + 0.001 * pixel(i * i)).collect(),
        count: (0..35).map(count).collect(),
    }
}

#[test]
fn tiles_hold_their_own_pixels() {
    let images = [image(3, |i| 50 + i), image(11, |i| 90 - i)];
    let [a, b] = images.each_ref().map(Image::statistics);
    // Sums instead of means: t and the degrees of freedom are the same.
    let expected = |inside: &dyn Fn(usize, usize) -> bool| {
        let pixels: Vec<usize> = (0..35).filter(|i| inside(i % 7, i / 7)).collect();
        let [sum_a, sum_b] = images
            .each_ref()
            .map(|image| pixels.iter().map(|&i| image.mean[i]).sum::<f64>());
        let part =
            |image: &Image, i: usize| (image.variance[i] / image.count[i] as f64, image.count[i]);
        let parts: Vec<(f64, u64)> = pixels
            .iter()
            .flat_map(|&i| images.each_ref().map(|image| part(image, i)))
            .collect();
        let error = parts.iter().map(|part| part.0).sum::<f64>().sqrt();
        (
            (sum_a - sum_b) / error,
            welch_satterthwaite(parts),
            error / pixels.len() as f64,
        )
    };
    for side in [1, 2, 3, 4, 7] {
        let found = welch_map(&a, &b, 7, side);
        assert_eq!(
            (found.width, found.height),
            (7_usize.div_ceil(side), 5_usize.div_ceil(side))
        );
        assert_eq!(found.p.len(), found.width * found.height);
        for (i, (&p, &sigmas)) in found.p.iter().zip(&found.sigmas).enumerate() {
            let tile = [i % found.width, i / found.width];
            let (t, dof, _) = expected(&|x, y| [x / side, y / side] == tile);
            assert_relative_eq!(sigmas, t, max_relative = 1e-9);
            assert_relative_eq!(
                p.expect("judged"),
                student_two_sided(t, dof),
                max_relative = 1e-9
            );
        }
    }
    let even = [0.0; 35];
    let symmetric = |statistics| ImageMoments {
        statistics,
        skewness: &even,
    };
    let whole = image_mean("whole", symmetric(&a), symmetric(&b), 0.01);
    let (t, dof, error) = expected(&|_, _| true);
    assert_eq!((whole.name.as_str(), whole.n), ("whole", 50));
    let critical = student_upper(ALPHA / 2.0, dof);
    let expected = [
        t,
        student_two_sided(t, dof),
        t * error,
        (t - critical) * error,
        (t + critical) * error,
    ];
    let found = [
        whole.value,
        whole.p,
        whole.estimate,
        whole.interval[0],
        whole.interval[1],
    ];
    assert_relative_eq!(found[..], expected[..], max_relative = 1e-9);
    let scale = b.mean.iter().sum::<f64>() / 35.0;
    assert_relative_eq!(whole.claim.size(), 0.01 * scale, max_relative = 1e-12);
    // Equal values without variance: nothing is known.
    let still = PixelStatistics {
        variance: &even,
        ..a
    };
    let same = image_mean("same", symmetric(&still), symmetric(&still), 0.01);
    assert_eq!(
        (same.value, same.p, same.verdict()),
        (0.0, 1.0, Verdict::Undecided { needed: u64::MAX })
    );
    assert!(
        welch_map(&still, &still, 7, 1)
            .p
            .iter()
            .all(Option::is_none)
    );
}

#[test]
fn an_image_is_kept_in_stretches_of_its_rows() {
    // 149 pixels in at most 64 stretches: 49 of three pixels, and one of two.
    let mean_a: Vec<f64> = (0..149).map(|i| f64::from(i * i % 31)).collect();
    let mean_b: Vec<f64> = (0..149).map(|i| f64::from(i * 5 % 17)).collect();
    let images = [
        Image::new(&mean_a, &[0.04; 149], &[100; 149]),
        Image::new(&mean_b, &[0.21; 149], &[300; 149]),
    ];
    let [a, b] = images.each_ref().map(Image::statistics);
    let even = [0.0; 149];
    let symmetric = |statistics| ImageMoments {
        statistics,
        skewness: &even,
    };
    let cells = image_mean("stretches", symmetric(&a), symmetric(&b), 0.01).cells;
    assert_eq!(cells.len(), 50);
    for (i, cell) in cells.iter().enumerate() {
        let n = if i < 49 { 3 } else { 2 };
        let sum = |mean: &[f64]| mean[3 * i..3 * i + n].iter().sum::<f64>();
        let [sum_a, sum_b] = [sum(&mean_a), sum(&mean_b)];
        // Sums of n pixels with variances 0.0004 and 0.0007.
        let sigmas = (sum_a - sum_b) / (n as f64 * 0.0011).sqrt();
        let place = format!("{n} pixels from {} on, row by row", 3 * i);
        assert_cell(cell, &place, [sum_b / n as f64, sum_a / n as f64, sigmas]);
    }
}
