//! Tests of domains and their partitions: positions of points, measures of parts, masses of cells.

use whitefurnace::harness::domain::MASS_TOLERANCE;

use super::*;

/// All domains with their total measures.
const DOMAINS: [(Domain, f64); 6] = [
    (Domain::Sphere, 4.0 * PI),
    (Domain::Hemisphere, TAU),
    (Domain::CosineHemisphere, TAU),
    (Domain::Disk, PI),
    (Domain::Square, 1.0),
    (Domain::Triangle, 0.5),
];

/// Returns the point at a position in the unit square, by inverting each domain's distribution.
fn point_at(domain: Domain, [s, b]: [f64; 2]) -> DVec3 {
    let around = |rho: f64, z: f64| {
        let (sin, cos) = (TAU * b).sin_cos();
        DVec3::new(rho * cos, rho * sin, z)
    };
    match domain {
        Domain::Sphere => around((4.0 * s * (1.0 - s)).sqrt(), 1.0 - 2.0 * s),
        Domain::Hemisphere => around((s * (2.0 - s)).sqrt(), 1.0 - s),
        Domain::CosineHemisphere => around(s.sqrt(), (1.0 - s).sqrt()),
        Domain::Disk => around(s.sqrt(), 0.0),
        Domain::Square => DVec3::new(s, b, 0.0),
        Domain::Triangle => {
            let rest = (1.0 - s).sqrt();
            DVec3::new(1.0 - rest, b * rest, 0.0)
        }
    }
}

#[test]
fn points_have_their_place_in_the_square() {
    for (domain, _) in DOMAINS {
        property(
            &format!("{domain:?}"),
            500,
            &(0.001..0.999, 0.0..0.999),
            |(s, b)| {
                let found = domain
                    .to_square(point_at(domain, [s, b]))
                    .expect("a point of the domain");
                assert_abs_diff_eq!(found[..], [s, b][..], epsilon = 1e-12);
            },
        );
    }
    // The azimuth starts at the x-axis, and is less than a full turn below it.
    assert_eq!(Domain::Sphere.to_square(DVec3::X), Some([0.5, 0.0]));
    assert_eq!(Domain::Disk.to_square(-0.5 * DVec3::X), Some([0.25, 0.5]));
    assert_eq!(Domain::Disk.to_square(-0.5 * DVec3::Y), Some([0.25, 0.75]));
}

#[test]
fn borders_are_inside_and_what_lies_beyond_is_not() {
    let ([o, x, y, z], nan) = ([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], DVec3::NAN);
    // Rounding may move a point across by 5e-10.
    let across = 5e-10;
    let hair = 1.0 + 0.4 * across;
    let [upper, elsewhere] = [vec![z, x, -y], vec![-z, 1.001 * z, 0.999 * z, nan]];
    let square = vec![
        0.5 * y - 0.1 * x,
        0.5 * y + 1.1 * x,
        0.5 * x - 0.1 * y,
        0.5 * x + 1.1 * y,
        nan,
    ];
    let triangle = vec![
        0.5 * y - 0.1 * x,
        0.5 * x - 0.1 * y,
        0.75 * x + 0.5 * y,
        1.1 * x,
        nan,
    ];
    for (domain, inside, outside) in [
        (
            Domain::Sphere,
            vec![z, -z, hair * x],
            vec![1.001 * x, 0.999 * x, o, nan],
        ),
        (Domain::Hemisphere, upper.clone(), elsewhere.clone()),
        (Domain::CosineHemisphere, upper, elsewhere),
        (
            Domain::Disk,
            vec![o, -x, hair * y],
            vec![1.001 * x, 0.5 * x + 0.1 * z, nan],
        ),
        (Domain::Square, vec![o, x, y, x + y], square),
        (
            Domain::Triangle,
            vec![o, x, y, 0.25 * x + (0.75 + across) * y],
            triangle,
        ),
    ] {
        for point in inside {
            let place = domain.to_square(point);
            let legal =
                |place: [f64; 2]| place.iter().all(|x| (0.0..=1.0 + 3.0 * across).contains(x));
            assert!(place.is_some_and(legal), "{domain:?} {point} {place:?}");
        }
        for point in outside {
            assert_eq!(domain.to_square(point), None, "{domain:?} {point}");
        }
    }
    assert_eq!(Domain::Triangle.to_square(x), Some([1.0, 0.0]));
}

#[test]
fn parts_have_their_share_of_the_measure() {
    let part = [[0.2, 0.5], [0.1, 0.4]];
    let area = 0.09;
    // The mean of each coordinate of the square over the part.
    let means = [0.35, 0.25];
    for (domain, measure) in DOMAINS {
        // Uniform in the square: cos θ/π times 2π, or 1.
        let even = |p: DVec3| match domain {
            Domain::CosineHemisphere => 2.0 * p.z,
            _ => 1.0,
        };
        assert_relative_eq!(
            domain.integrate_all(1e-9, &|_| 1.0).value,
            measure,
            max_relative = 1e-9
        );
        let found = domain.integrate(part, 1e-12, &even).value;
        assert_relative_eq!(found, area * measure, max_relative = 1e-10);
        for (axis, mean) in means.into_iter().enumerate() {
            let place = |p: DVec3| domain.to_square(p).expect("a point of the domain")[axis];
            let found = domain.integrate(part, 1e-12, &|p| even(p) * place(p)).value;
            assert_relative_eq!(found, area * measure * mean, max_relative = 1e-10);
        }
        // Cells of the uniform distribution are equally probable, however they are cut.
        let partition = Partition::from_pdf(domain, 8, &|p| even(p) / measure);
        assert_relative_eq!(partition.masses[..], [0.125; 8][..], max_relative = 1e-6);
    }
}

#[test]
fn errors_of_parts_add_up_to_less_than_the_tolerance() {
    for tolerance in [1e-3, 1e-4, 1e-5, 1e-6] {
        for kink in [0.13, 0.3, 0.41] {
            let found = Domain::Square.integrate_all(tolerance, &|p| (p.x + p.y - kink).abs());
            assert!(found.error > 0.0 && found.error <= tolerance, "{found:?}");
            // ∫ (x + y − k) over the square, and twice the pyramid below the kink.
            assert_abs_diff_eq!(
                found.value,
                1.0 - kink + kink.powi(3) / 3.0,
                epsilon = tolerance
            );
        }
    }
}

#[test]
fn equal_cells_run_row_by_row() {
    let cells = Partition::equal(Domain::Square, 3, 4);
    assert_eq!(cells.masses, vec![1.0 / 12.0; 12]);
    assert_eq!((cells.loss, cells.error), (0.0, 0.0));
    assert_relative_eq!(cells.mass(), 1.0, max_relative = 1e-15);
    for k in 0..12 {
        let [row, column] = [k / 4, k % 4];
        let centre = [(row as f64 + 0.5) / 3.0, (column as f64 + 0.5) / 4.0];
        assert_eq!(cells.cell(point_at(Domain::Square, centre)), Some(k));
        assert_eq!(
            cells.places[k],
            format!(
                "row {row}-{} of 3; column {column}-{} of 4",
                row + 1,
                column + 1
            )
        );
    }
    // The far border belongs to the last row and column.
    assert_eq!(cells.cell(DVec3::new(1.0, 1.0, 0.0)), Some(11));
    assert_eq!(cells.cell(DVec3::new(1.1, 1.0, 0.0)), None);
    let outcomes = Partition::from_masses(vec![0.5, 0.25, 0.25], vec![String::new(); 3]);
    for (k, x) in [0.2, 0.5, 0.8].into_iter().enumerate() {
        assert_eq!(outcomes.cell(DVec3::new(0.5, x, 0.0)), Some(k));
    }
    assert_eq!(outcomes.mass(), 1.0);
}

/// Returns the numbers in a place such as "row 0-16 of 32; column 5-9 of 64".
fn numbers(place: &str) -> Vec<usize> {
    let digits = |c: char| !c.is_ascii_digit();
    place
        .split(digits)
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().expect("a number"))
        .collect()
}

#[test]
fn cells_of_a_density_hold_what_lies_in_them() {
    // 0.9 (1 + x)(3 − y²)/4: ∫ (1 + x) = 3/2, ∫ (3 − y²) = 8/3, so a tenth is lost.
    let pdf = |p: DVec3| 0.9 * (1.0 + p.x) * (3.0 - p.y * p.y) / 4.0;
    for cells in [1, 2, 5, 6, 12] {
        let partition = Partition::from_pdf(Domain::Square, cells, &pdf);
        assert_eq!(partition.places.len(), cells);
        assert_eq!(partition.error, MASS_TOLERANCE);
        assert_relative_eq!(partition.loss, 0.1, max_relative = 1e-6);
        assert_relative_eq!(partition.mass(), 0.9, max_relative = 1e-9);
        let mut masses = vec![0.0; cells];
        for row in 0..32_usize {
            for column in 0..64_usize {
                let [x, y] = [row as f64 / 32.0, column as f64 / 64.0];
                let centre = DVec3::new(x + 1.0 / 64.0, y + 1.0 / 128.0, 0.0);
                let cell = partition.cell(centre).expect("a point of the square");
                // The product of two integrals over the field.
                let along_x = (1.0 + x + 1.0 / 64.0) / 32.0;
                let end = y + 1.0 / 64.0;
                let along_y = 3.0 / 64.0 - (end.powi(3) - y.powi(3)) / 3.0;
                masses[cell] += 0.9 * along_x * along_y / 4.0;
                let place = numbers(&partition.places[cell]);
                assert!((place[0]..place[1]).contains(&row), "{place:?}");
                assert!((place[3]..place[4]).contains(&column), "{place:?}");
                assert_eq!((place[2], place[5]), (32, 64));
            }
        }
        assert_relative_eq!(partition.masses[..], masses[..], max_relative = 1e-9);
        // A row of fields holds three hundredths of the whole: cuts are off by at most half of
        // that.
        assert_abs_diff_eq!(
            masses[..],
            vec![0.9 / cells as f64; cells][..],
            epsilon = 0.02
        );
    }
}

/// Surfaces that transmit light have pdfs that jump at the horizon, so it is a border of fields.
#[test]
fn no_field_lies_on_both_sides_of_the_horizon() {
    for up in [0.01, 0.5, 0.77, 0.999] {
        let pdf = |w: DVec3| {
            if w.z > 0.0 {
                up / TAU
            } else {
                (1.0 - up) / TAU
            }
        };
        let partition = Partition::from_pdf(Domain::Sphere, 6, &pdf);
        assert_eq!(partition.error, MASS_TOLERANCE);
        assert_abs_diff_eq!(partition.mass(), 1.0, epsilon = 1e-9);
    }
}

#[test]
fn masses_are_known_to_the_tolerance_together() {
    // A kink at three tenths of every row of fields: the small errors of all fields have the same
    // sign.
    let pdf = |p: DVec3| 0.9 + 0.1 * (((32.0 * p.x).fract() - 0.3).abs() - 0.29);
    let partition = Partition::from_pdf(Domain::Square, 4, &pdf);
    // ∫ |u − 0.3| from 0 to 1 is (0.3² + 0.7²)/2 = 0.29.
    assert_abs_diff_eq!(partition.mass(), 0.9, epsilon = MASS_TOLERANCE);
    assert_abs_diff_eq!(partition.loss, 0.1, epsilon = MASS_TOLERANCE);
    assert_abs_diff_eq!(
        partition.masses[..],
        [0.225; 4][..],
        epsilon = MASS_TOLERANCE
    );
}

#[test]
fn every_cell_holds_a_field() {
    // All of the probability is in the first field: no cut gives a third of it.
    let first = |p: DVec3| f64::from(u8::from(32.0 * p.x < 1.0 && 64.0 * p.y < 1.0)) * 2048.0;
    let partition = Partition::from_pdf(Domain::Square, 3, &first);
    assert_eq!(partition.places.len(), 3);
    let mut fields = 0;
    for place in &partition.places {
        let n = numbers(place);
        assert!(n[0] < n[1] && n[3] < n[4], "{place}");
        fields += (n[1] - n[0]) * (n[4] - n[3]);
    }
    assert_eq!(fields, 32 * 64);
    assert_relative_eq!(partition.masses[0], 1.0, max_relative = 1e-12);
}

/// Partitions of rough densities end, and nothing holds with them. (A pair of rules that disagree
/// does the same everywhere.)
#[test]
fn partitions_of_rough_densities_end_undecided() {
    let noise = |p: DVec3| f64::from((1e8 * (p.x + 1.7 * p.y)).sin() > 0.0);
    let evaluations = std::cell::Cell::new(0_u64);
    let rough = |p: DVec3| {
        evaluations.set(evaluations.get() + 1);
        1.0 + noise(p) - 0.5
    };
    let partition = Partition::from_pdf(Domain::Square, 4, &rough);
    // 2048 cells, each a second time to halve it, and 20 000 halvings, 225 values each.
    assert!(evaluations.get() <= 225 * (2 * 2048 + 2 * 20_000));
    assert!(partition.error > 1e-4, "{}", partition.error);
    let counts = Counts {
        n: 40_000_000,
        observed: vec![10_000_000; 4],
        ..Counts::default()
    };
    let verdict = chi_square("rough", &partition, &counts, 0.5).verdict();
    assert!(matches!(verdict, Verdict::Undecided { .. }), "{verdict:?}");
    let nan = Partition::from_pdf(Domain::Square, 4, &|_| f64::NAN);
    assert!(nan.error.is_nan());
    assert_eq!(
        chi_square("NaN", &nan, &counts, 0.5).verdict(),
        Verdict::Fails
    );
}
