//! Error of single precision: the same paths in both precisions, in scenes whose smallest things
//! shrink.

use whitefurnace::render::{LaneEstimator, LaneRenderer, Precision, check_single_precision};
use whitefurnace::scene::file::Description;

use super::speed::growth::{in_a_room, waves};
use crate::experiments::prelude::*;

pub(super) const SINGLE: Experiment = Experiment {
    id: "single",
    title: "single precision against double, the same paths: how far images are off, and which scenes are refused",
    headline: "single precision: a tile is off by up to {taken.tile %.2%} in scenes that are taken, {refused.tile %.0%} in those refused",
    version: 2,
    equations: &[&equation::SINGLE_PRECISION],
    run,
};

const SIZE: [u32; 2] = [64, 48];
/// Side of a tile in pixels.
const TILE: u32 = 8;
const SAMPLES: u32 = 64;
/// Largest relative error of a tile in accepted scenes.
const MAX_RELATIVE_DIFFERENCE: f64 = 0.005;
/// Ratios of a scene's extent to the size of its smallest thing: all but the last two are accepted.
const RATIOS: [u32; 6] = [10, 100, 1_000, 4_000, 65_536, 1_000_000];

/// A ball and a box of size 1 on a plane under a bright sky, near the origin.
const ON_A_PLANE: &str = r#"
    background = 1
    camera = { eye = [3, -6, 2], target = [0, 0, 0.5], up = [0, 0, 1], fov_deg = 40 }
    materials.grey = { model = "lambert", albedo = 0.7 }
    [[objects]]
    shape = "rectangle"
    material = "grey"
    corner = [-REACH, -REACH, 0]
    edges = [[TWICE, 0, 0], [0, TWICE, 0]]
    [[objects]]
    shape = "sphere"
    material = "grey"
    centre = [1.6, 0, 1]
    radius = 1
    [[objects]]
    shape = "mesh"
    vertices = [[-1, -1, 0], [0, -1, 0], [0, 0, 0], [-1, 0, 0], [-1, -1, 1], [0, -1, 1], [0, 0, 1], [-1, 0, 1]]
    faces = { grey = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]] }
"#;

/// A ball of radius 1 in the corner of a closed room, far from the origin, under a lamp that
/// belongs to the ceiling.
const IN_A_CORNER: &str = r#"
    camera = { eye = [EYE, EYE, NEAR], target = [AT, AT, AT], up = [0, 0, 1], fov_deg = 40 }
    materials.grey = { model = "lambert", albedo = 0.7 }
    materials.lamp = { model = "black", emission = 5 }
    [[objects]]
    shape = "mesh"
    vertices = [
        [-REACH, -REACH, -REACH], [REACH, -REACH, -REACH], [REACH, REACH, -REACH], [-REACH, REACH, -REACH],
        [-REACH, -REACH, REACH], [REACH, -REACH, REACH], [REACH, REACH, REACH], [-REACH, REACH, REACH],
    ]
    [objects.faces]
    lamp = [[4, 7, 6, 5]]
    grey = [[0, 1, 2, 3], [3, 7, 4, 0], [1, 5, 6, 2], [2, 6, 7, 3], [0, 4, 5, 1]]
    [[objects]]
    shape = "sphere"
    material = "grey"
    centre = [AT, AT, AT]
    radius = 1
"#;

fn run(run: &mut Run) -> Result<(), Error> {
    let numbered = |text: &str, reach: f64| {
        let numbers = [
            ("REACH", reach),
            ("TWICE", 2.0 * reach),
            ("EYE", 6.0 - reach),
            ("NEAR", 3.0 - reach),
        ];
        let numbers = numbers.into_iter().chain([("AT", 1.0 - reach)]);
        numbers.fold(text.to_owned(), |text, (name, number)| {
            text.replace(name, &format!("{number:?}"))
        })
    };
    let mut worst = Worst::default();
    for (place, text) in [("plane", ON_A_PLANE), ("corner", IN_A_CORNER)] {
        for ratio in RATIOS {
            let scene = Description::parse(place, &numbered(text, f64::from(ratio)))?.build()?;
            worst.measure(run, &format!("{place}.{ratio}"), &scene)?;
        }
    }
    // The room in another unit of length.
    for (name, unit) in [
        ("micro", "1e-6"),
        ("milli", "1e-3"),
        ("kilo", "1e3"),
        ("hundred-kilo", "1e5"),
    ] {
        let text = format!("unit = {unit}\n{}", numbered(IN_A_CORNER, 8.0));
        worst.measure(
            run,
            &format!("unit.{name}"),
            &Description::parse(name, &text)?.build()?,
        )?;
    }
    for about in [1_000, 10_000, 100_000, 1_000_000]
        .into_iter()
        .take(run.by_tier(3, 4))
    {
        let (vertices, triangles) = waves(about);
        worst.measure(
            run,
            &format!("mesh.{about}"),
            &in_a_room(&vertices, &triangles)?,
        )?;
    }
    run.number("taken.tile", worst.taken);
    run.number("refused.tile", worst.refused);
    Ok(())
}

/// Largest error of a tile in accepted scenes, and in refused ones.
#[derive(Default)]
struct Worst {
    taken: f64,
    refused: f64,
}

impl Worst {
    /// Records the error of the image in single precision, overall and in the worst tile, and
    /// whether the scene is accepted.
    fn measure(&mut self, run: &mut Run, key: &str, scene: &Scene) -> Result<(), Error> {
        let estimator = LaneEstimator::Path(Path {
            specular_nee: true,
            ..Path::new(Strategy::Mis)
        });
        let films = [Precision::Double, Precision::UncheckedSingle].map(|precision| {
            let lanes = LaneRenderer {
                estimator,
                sampling: random_points(run.seed()),
                precision,
            };
            render_film(&lanes, scene, Film::new(SIZE, None, 1)?, SAMPLES)
        });
        let [double, single] = films;
        let [double, single] = [double?, single?];
        let refusal = check_single_precision(scene).err();
        let image = single.mean() / double.mean() - 1.0;
        let tile = tiles(&double)
            .into_iter()
            .zip(tiles(&single))
            .map(|(a, b)| (b - a).abs() / a.max(1e-3 * double.mean()));
        let tile = tile.fold(0.0, f64::max);
        let noise = double.relative_error() / f64::from(TILE);
        let taken = if refusal.is_none() { 1.0 } else { 0.0 };
        run.numbers(
            key,
            [
                ("image", image),
                ("tile", tile),
                ("noise", noise),
                ("taken", taken),
            ],
        );
        let off = format!(
            "a tile is off by up to {:.3} %, the image by {:+.4} %",
            100.0 * tile,
            100.0 * image
        );
        let worst = if refusal.is_none() {
            &mut self.taken
        } else {
            &mut self.refused
        };
        *worst = worst.max(tile);
        match refusal {
            None => run.claim(
                key,
                format!("{off}; {:.1} % allowed", 100.0 * MAX_RELATIVE_DIFFERENCE),
                tile <= MAX_RELATIVE_DIFFERENCE,
            ),
            Some(_) => run.note(key, format!("{off}; refused")),
        }
        Ok(())
    }
}

/// Returns the mean radiance of each tile.
fn tiles(film: &Film) -> Vec<f64> {
    let [across, down] = SIZE.map(|pixels| pixels / TILE);
    let mut tiles = vec![0.0; (across * down) as usize];
    for (i, pixel) in (0..).zip(film.pixels()) {
        let [x, y] = [i % SIZE[0] / TILE, i / SIZE[0] / TILE];
        tiles[(y * across + x) as usize] += pixel.mean().element_sum() / f64::from(3 * TILE * TILE);
    }
    tiles
}
