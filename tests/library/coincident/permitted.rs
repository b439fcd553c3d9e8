//! Tests of coincident surfaces that are permitted.

use super::*;

#[test]
fn what_no_light_can_tell_apart_is_built() {
    let built = [
        (
            "the same clay twice",
            vec![(PANEL_UP, clay()), (PANEL_DOWN, clay())],
        ),
        (
            "a ball of clay twice",
            vec![(Ball(CENTRE, 0.5), clay()), (Ball(CENTRE, 0.5), clay())],
        ),
        (
            "a block on the floor",
            vec![
                (ROOM, clay()),
                (Cuboid([-0.5, -0.5, -1.0], [0.5, 0.5, 0.0], false), chalk()),
            ],
        ),
        (
            "a mirror on the floor",
            vec![
                (ROOM, clay()),
                (Cuboid([-0.5, -0.5, -1.0], [0.5, 0.5, 0.0], false), mirror()),
            ],
        ),
        (
            "a lamp at the ceiling",
            vec![
                (ROOM, clay()),
                (Cuboid([-0.5, -0.5, 0.9], [0.5, 0.5, 1.0], false), lamp()),
            ],
        ),
        (
            "with its fronts inside",
            vec![
                (ROOM, clay()),
                (Cuboid([-0.5, -0.5, 0.9], [0.5, 0.5, 1.0], true), chalk()),
            ],
        ),
        (
            "of six rectangles",
            vec![
                (ROOM, clay()),
                (
                    SixRectangles([-0.53, -0.51, -1.0], [0.47, 0.59, 0.13]),
                    chalk(),
                ),
            ],
        ),
        (
            "in a corner",
            vec![
                (ROOM, clay()),
                (Cuboid([1.5, 1.5, -1.0], [2.5, 2.5, 0.0], false), chalk()),
            ],
        ),
        (
            "as high as the room",
            vec![
                (ROOM, clay()),
                (Cuboid([1.5, 1.5, -1.0], [2.5, 2.5, 1.0], false), chalk()),
            ],
        ),
        (
            "a block on a sheet",
            vec![(SHEET, clay()), (BLOCK, chalk())],
        ),
        (
            "a mirror on a sheet",
            vec![(SHEET, clay()), (BLOCK, mirror())],
        ),
        (
            "on two tiles",
            vec![
                (Square([-1.0, 0.0, 0.0], 1.0, true), clay()),
                (Square([1.0, 0.0, 0.0], 1.0, true), chalk()),
                (BLOCK, chalk()),
            ],
        ),
        (
            "a tower, which hangs over",
            vec![
                (ROOM, clay()),
                (Cuboid([-0.5, -0.5, -1.0], [0.5, 0.5, -0.5], false), chalk()),
                (Cuboid([-0.5, -0.5, -0.5], [0.5, 0.5, 0.0], false), clay()),
                (Cuboid([-0.3, -0.8, 0.0], [0.7, 0.2, 0.5], false), mirror()),
            ],
        ),
        (
            "lamps side by side",
            vec![
                (Square([-0.5, 0.0, 1.0], 0.5, true), lamp()),
                (Square([0.5, 0.0, 1.0], 0.5, true), mirror()),
            ],
        ),
        (
            "a ball on a sheet",
            vec![(SHEET, clay()), (Ball([0.0, 0.0, 0.5], 0.5), glass())],
        ),
        (
            "balls in a ball",
            vec![
                (Ball(CENTRE, 0.5), glass()),
                (Ball(CENTRE, 0.49), lamp()),
                (Ball([0.1, 0.2, 1.25], 0.25), mirror()),
            ],
        ),
        (
            "zones that touch",
            vec![
                (Zone(CENTRE, 0.5, [-1.0, 0.1]), lamp()),
                (Zone(CENTRE, 0.5, [0.1, 1.0]), clay()),
            ],
        ),
        (
            "sheets that cross",
            vec![
                (Square([0.0; 3], 1.0, true), lamp()),
                (Cuboid([-0.5; 3], [0.5; 3], false), mirror()),
            ],
        ),
    ];
    for (what, shapes) in built {
        assert!(is_built(&shapes), "{what}");
    }
}
