//! The light tracer and bidirectional path tracing on scenes with closed forms, strategy by
//! strategy, and against the path tracer.

mod faults;
pub(super) mod scenes;
mod strategies;

use whitefurnace::harness::mean::MIN_SYMMETRIC_VALUES;
use whitefurnace::sampling::sampler::SamplerKind;
use whitefurnace::scene::simple::{Cap, environment, furnace_box};

use crate::bidirectional::scenes::KnownImage;
use crate::furnace::off_cap_radiance;
use crate::image_mean::ImageEstimatorKind::{Bdpt, BdptEnds, LightTracer};
use crate::image_mean::{ImageEstimatorKind, Passes, Region, image, same_as_path, whole};
use crate::images::near_furnace;
use crate::prelude::*;
use crate::scenes::valid;

/// Trials and faults of estimators that trace particles to the camera.
pub fn families() -> Vec<Box<dyn AnyFamily>> {
    let mut trials = direct();
    trials.extend(furnaces());
    trials.extend(specular());
    trials.extend(strategies::alone());
    trials.extend(equivalence());
    trials.extend(sobol());
    trials.push(strategies::weights());
    vec![Box::new(Family {
        whole_estimator: true,
        trials,
        faults: faults::faults(),
        equivalents: faults::equivalents(),
        ..Family::new("bidirectional", STANDARD)
    })]
}

/// Size of a square image.
const SQUARE: [u32; 2] = [14, 14];
/// Size of an image of which few pixels are enough.
const SMALL: [u32; 2] = [3, 3];

/// Size of a trial of images.
#[derive(Clone, Copy)]
struct Size {
    /// Width and height of the image.
    frame: [u32; 2],
    /// Source of random numbers, as in [`Passes`].
    sampler: SamplerKind,
    /// Number of replications at scale 1.
    count: u64,
    /// Relative δ; 0 claims the mean of every single pass.
    delta: f64,
}

impl Size {
    /// Returns this size for passes by independent numbers, with the δ of image means.
    const fn new(frame: [u32; 2], count: u64) -> Self {
        Self {
            frame,
            sampler: SamplerKind::Independent,
            count,
            delta: IMAGE_DELTA,
        }
    }

    /// Returns this size for replications of so many passes by Sobol' points, with the δ of image
    /// means.
    const fn sobol(frame: [u32; 2], passes: u32, count: u64) -> Self {
        Self {
            sampler: SamplerKind::Sobol(passes),
            ..Self::new(frame, count)
        }
    }
}

/// Returns a trial of the mean of a whole image.
fn mean(
    name: &'static str,
    consequence: &'static str,
    kind: ImageEstimatorKind,
    equation: &'static Equation,
    what: &str,
    image_of: KnownImage,
    size: Size,
) -> FamilyTrial<EstimatorSubject> {
    let KnownImage {
        scene,
        mean: reference,
    } = image_of;
    let passes = Passes {
        scene,
        kind,
        frame: size.frame,
        sampler: size.sampler,
        count: size.count,
    };
    image(
        name,
        format!("{what}: the image has mean {reference:.6}"),
        consequence,
        equation,
        &passes,
        reference,
        &[whole(size.delta)],
    )
}

/// Trials of a floor that reflects light once.
fn direct() -> Vec<FamilyTrial<EstimatorSubject>> {
    let under_square = "a floor under a square light";
    let under_sphere = "a floor under a spherical light";
    let floor = |name, consequence, kind, what, image, size| {
        mean(name, consequence, kind, &GEOMETRY, what, image, size)
    };
    vec![
        floor(
            "bidirectional/light-tracer/rectangle",
            "a panel lamp lights a floor by a wrong amount when its light is traced from it",
            LightTracer,
            under_square,
            scenes::rectangle(false),
            Size::sobol([8, 8], 1, MIN_SYMMETRIC_VALUES),
        ),
        floor(
            "bidirectional/bdpt/rectangle",
            "direct light of a panel is counted more or less than once bidirectionally",
            Bdpt,
            under_square,
            scenes::rectangle(false),
            Size::sobol(SMALL, 4, 18_000),
        ),
        floor(
            "bidirectional/light-tracer/sphere",
            "a globe lamp is too bright or too dim when its light is traced from it",
            LightTracer,
            under_sphere,
            scenes::sphere(),
            Size::sobol([15, 15], 1, MIN_SYMMETRIC_VALUES),
        ),
        floor(
            "bidirectional/bdpt/sphere",
            "a globe lamp's light falls off wrongly where bidirectional paths are joined",
            Bdpt,
            under_sphere,
            scenes::sphere(),
            Size::sobol([4, 4], 4, MIN_SYMMETRIC_VALUES),
        ),
        mean(
            "bidirectional/bdpt/behind",
            "a one-sided lamp lights a floor through its own back, bidirectionally",
            Bdpt,
            &GEOMETRY,
            "a floor under a light that faces up",
            scenes::rectangle(true),
            Size {
                delta: 0.0,
                ..Size::new(SQUARE, 6_000)
            },
        ),
        frame(
            "bidirectional/light-tracer/frame",
            "a wide light-traced image gets darker or brighter towards its sides",
            LightTracer,
            SamplerKind::Sobol(1),
            9_500,
        ),
        frame(
            "bidirectional/bdpt/frame",
            "a wide bidirectional image gets darker or brighter towards its sides",
            Bdpt,
            SamplerKind::Independent,
            12_500,
        ),
        frame(
            "bidirectional/bdpt-ends/frame",
            "a wide image darkens at its sides when only the ends of paths are joined",
            BdptEnds,
            SamplerKind::Sobol(1),
            12_700,
        ),
    ]
}

/// Trial of a uniform emitter that fills the image: every pixel shows its radiance, the outermost
/// as well.
fn frame(
    name: &'static str,
    consequence: &'static str,
    kind: ImageEstimatorKind,
    sampler: SamplerKind,
    count: u64,
) -> FamilyTrial<EstimatorSubject> {
    let KnownImage {
        scene,
        mean: reference,
    } = scenes::emitting_plane();
    let passes = Passes {
        scene,
        kind,
        frame: [24, 8],
        sampler,
        count,
    };
    let outer = Region {
        name: "outer columns",
        holds: |[x, _], [width, _]| x < 2 || x + 2 >= width,
        delta: 0.02,
    };
    let property = format!("an emitter that fills a wide image shows {reference} in every pixel");
    image(
        name,
        property,
        consequence,
        &IMPORTANCE,
        &passes,
        reference,
        &[whole(CLOSED_FORM_DELTA), outer],
    )
}

/// Trials of multiple reflection: closed boxes, cavities with a cap, and a white sky.
fn furnaces() -> Vec<FamilyTrial<EstimatorSubject>> {
    let rho = 0.75;
    let furnace = |name, consequence, kind, size| {
        let what = "a closed furnace box of albedo 0.75";
        let image = KnownImage {
            scene: valid(furnace_box(rho)),
            mean: 1.0 / (1.0 - rho),
        };
        mean(name, consequence, kind, &RENDERING, what, image, size)
    };
    let cavity = |name, consequence, kind, cap, size| {
        let what = match cap {
            Cap::Reflecting => "a cavity of albedo 0.75 with a reflecting cap that emits",
            Cap::Black => "a cavity of albedo 0.75 with a black cap that emits",
        };
        let image = KnownImage {
            scene: scenes::cavity(rho, cap),
            mean: off_cap_radiance(rho, cap),
        };
        mean(name, consequence, kind, &RENDERING, what, image, size)
    };
    let sky = |name, consequence, size: Size| {
        let what = "white surfaces, mirror and glass under a white sky";
        let image = KnownImage {
            scene: valid(environment().and_then(|scene| scene.with_camera(near_furnace()))),
            mean: 1.0,
        };
        let size = Size {
            delta: CLOSED_FORM_DELTA,
            ..size
        };
        mean(name, consequence, Bdpt, &RENDERING, what, image, size)
    };
    vec![
        furnace(
            "bidirectional/light-tracer/furnace-box",
            "each bounce of a particle loses or gains light: rooms are too dark or too bright",
            LightTracer,
            Size::new([16, 12], 9_400),
        ),
        furnace(
            "bidirectional/bdpt/furnace-box",
            "a furnace is too dark or bright bidirectionally, as in mitsuba-renderer/mitsuba#80",
            Bdpt,
            Size::new([10, 8], MIN_SYMMETRIC_VALUES),
        ),
        cavity(
            "bidirectional/light-tracer/cavity-reflecting",
            "a lamp that also reflects gives a light-traced room too much or too little light",
            LightTracer,
            Cap::Reflecting,
            Size::new(SQUARE, 21_600),
        ),
        cavity(
            "bidirectional/bdpt/cavity-black",
            "a room lit by a small window is too dark or too bright bidirectionally",
            Bdpt,
            Cap::Black,
            Size::sobol(SMALL, 4, 14_400),
        ),
        cavity(
            "bidirectional/bdpt-ends/cavity-black",
            "leaving out connections between inner vertices darkens rooms",
            BdptEnds,
            Cap::Black,
            Size::sobol([4, 4], 4, 13_800),
        ),
        sky(
            "bidirectional/bdpt/environment",
            "white things stand out from a white sky: a bidirectional path loses or adds light",
            Size::new([24, 8], 16_500),
        ),
    ]
}

/// Trials by Sobol' points for both walks of a pixel, and for all particles of an image. The box's
/// light comes from everywhere, so that walks which share their numbers would show.
fn sobol() -> Vec<FamilyTrial<EstimatorSubject>> {
    let furnace = |name, consequence, kind, frame, count| {
        let rho = 0.75;
        let reference = 1.0 / (1.0 - rho);
        let passes = Passes {
            scene: valid(furnace_box(rho)),
            kind,
            frame,
            sampler: SamplerKind::Sobol(4),
            count,
        };
        let property = format!(
            "a closed furnace box of albedo {rho}, by Sobol' points: the image has mean {reference}"
        );
        let regions = [whole(IMAGE_DELTA)];
        image(
            name,
            property,
            consequence,
            &SOBOL,
            &passes,
            reference,
            &regions,
        )
    };
    vec![
        furnace(
            "bidirectional/light-tracer/sobol",
            "particles by Sobol' points miss parts of a room: it is too dark or too bright",
            LightTracer,
            [8, 6],
            MIN_SYMMETRIC_VALUES,
        ),
        furnace(
            "bidirectional/bdpt/sobol",
            "eye and light paths share their Sobol' points: bidirectional images are biased",
            Bdpt,
            [2, 2],
            23_000,
        ),
    ]
}

/// Trials with mirror and glass between light and surface.
fn specular() -> Vec<FamilyTrial<EstimatorSubject>> {
    let mirror = |name, consequence, kind, size| {
        let what = "a floor lit through a mirror";
        let image = scenes::mirror_caustic();
        mean(name, consequence, kind, &PATH_DENSITY, what, image, size)
    };
    let (scene, eta_squared, share) = scenes::in_glass();
    let glass = |name, consequence, kind, what, mean_radiance, size| {
        let image = KnownImage {
            scene: Arc::clone(&scene),
            mean: mean_radiance,
        };
        mean(name, consequence, kind, &REFRACTION, what, image, size)
    };
    vec![
        mirror(
            "bidirectional/light-tracer/mirror-caustic",
            "a mirror throws a spot of the wrong brightness on a floor in light-traced images",
            LightTracer,
            Size::sobol([15, 6], 4, MIN_SYMMETRIC_VALUES),
        ),
        mirror(
            "bidirectional/bdpt/mirror-caustic",
            "light that a mirror throws on a floor is lost or counted twice bidirectionally",
            Bdpt,
            Size::sobol([5, 2], 48, 8_200),
        ),
        glass(
            "bidirectional/light-tracer/in-glass",
            "what lies in glass is n² times too bright or too dark in light-traced images",
            LightTracer,
            "a ball in glass in thermal equilibrium, which is all that a light tracer sees",
            share * eta_squared,
            Size::sobol([16, 16], 1, 9_500),
        ),
        glass(
            "bidirectional/bdpt/in-glass",
            "what lies in glass is too bright or too dark where bidirectional paths refract",
            Bdpt,
            "a ball in glass in thermal equilibrium",
            eta_squared,
            Size::sobol([2, 2], 6, MIN_SYMMETRIC_VALUES),
        ),
        glass(
            "bidirectional/bdpt-ends/in-glass",
            "what lies in glass changes brightness when inner connections are left out",
            BdptEnds,
            "a ball in glass in thermal equilibrium",
            eta_squared,
            Size::sobol([2, 2], 6, MIN_SYMMETRIC_VALUES),
        ),
    ]
}

/// Trials of equality with the path tracer where no closed form is known.
fn equivalence() -> Vec<FamilyTrial<EstimatorSubject>> {
    let same = |name, consequence, passes: &Passes, scrambles| {
        let property = "the image has the mean of the path tracer's";
        same_as_path(
            name,
            property,
            consequence,
            &RENDERING,
            passes,
            scrambles,
            IMAGE_DELTA,
        )
    };
    vec![
        same(
            "bidirectional/light-tracer/cornell",
            "the Cornell box differs by method, as in mitsuba-renderer/mitsuba3#42",
            &Passes {
                scene: scenes::cornell_box(),
                kind: LightTracer,
                frame: [16, 12],
                sampler: SamplerKind::Sobol(1),
                count: 12_000,
            },
            26_000,
        ),
        same(
            "bidirectional/bdpt/diffuse-room",
            "a room gets darker when rendered bidirectionally, as in yuphin/Lumen#42",
            &Passes {
                scene: scenes::diffuse_room(),
                kind: Bdpt,
                frame: [4, 3],
                sampler: SamplerKind::Sobol(4),
                count: 9_600,
            },
            14_900,
        ),
    ]
}
