//! Shares of the error budget that this target uses, as data: the test of the whole budget adds
//! them to those of the registry.

/// Largest number of tests of identities on random arguments, each of which has a share: they are
/// counted as they run.
pub const IDENTITIES: usize = 115;

/// Tests with random arguments that compare only where a ray hits or a path arrives: name, count to
/// be exceeded, and number of checks. Each has a share of the budget, although the counts are far
/// exceeded.
pub const MIN_COMPARISONS: [(&str, usize, usize); 9] = [
    ("mixed", 100, 1),
    ("flat", 100, 3),
    ("scales", 200, 4),
    ("large mesh", 8, 1),
    ("around", 2500, 1),
    ("through glass", 2500, 1),
    ("inside glass", 1500, 1),
    ("inside glass, bidirectional", 1500, 1),
    ("behind nothing", 100, 2),
];

/// Number of random assertions among the library's tests, by module.
pub const RANDOM_ASSERTIONS: [(&str, usize); 9] = [
    ("directions", 31),
    ("images", 31),
    ("lobes", 50),
    ("checkup parts", 9),
    ("narrow lobes", 4),
    ("own pdfs", 25),
    // One for each table, two for negative controls, and four for identities of random paths.
    ("features", 13),
    ("single precision", 17),
    // The examples of the library, of `harness` and of its `directions` and `bsdf_checkup` (three).
    ("documentation", 57),
];
