//! Tests of coincident surfaces that are refused.

use super::*;

#[test]
fn what_light_could_meet_by_chance_is_refused() {
    let refused = [
        (
            "a lamp in the ceiling",
            vec![(ROOM, clay()), (PANEL_DOWN, lamp())],
        ),
        (
            "a lamp larger than the ceiling",
            vec![(ROOM, clay()), (Square(CENTRE, 3.0, false), lamp())],
        ),
        (
            "a lamp half in the ceiling's plane",
            vec![
                (Square(CENTRE, 1.0, false), clay()),
                (Triangle(CENTRE, 0.3, true), lamp()),
            ],
        ),
        (
            "two lamps back to back",
            vec![(PANEL_DOWN, lamp()), (PANEL_UP, lamp())],
        ),
        (
            "a lamp twice",
            vec![(PANEL_DOWN, lamp()), (PANEL_DOWN, lamp())],
        ),
        (
            "a mirror in the wall",
            vec![(ROOM, clay()), (PANEL_DOWN, mirror())],
        ),
        (
            "a mirror of both windings",
            vec![(PANEL_DOWN, mirror()), (PANEL_UP, mirror())],
        ),
        (
            "a poster in the wall",
            vec![(ROOM, clay()), (PANEL_DOWN, chalk())],
        ),
        (
            "a poster that faces the wall",
            vec![(ROOM, clay()), (PANEL_UP, chalk())],
        ),
        (
            "a card of two colours",
            vec![(PANEL_UP, clay()), (PANEL_DOWN, chalk())],
        ),
        (
            "a small overlap",
            vec![
                (Square(CENTRE, 0.5, true), clay()),
                (Square([1.09, 1.19, 1.0], 0.5, true), chalk()),
            ],
        ),
        (
            "three sheets",
            vec![
                (Square(CENTRE, 0.5, true), clay()),
                (Square(CENTRE, 0.4, true), clay()),
                (PANEL_UP, chalk()),
            ],
        ),
        ("glass on a table", vec![(SHEET, clay()), (BLOCK, glass())]),
        (
            "frosted glass on it",
            vec![(SHEET, clay()), (BLOCK, rough_glass())],
        ),
        (
            "a block over the edge of a sheet",
            vec![
                (Square([0.0; 3], 1.0, true), clay()),
                (Cuboid([0.5, -0.5, 0.0], [1.5, 0.5, 0.5], false), chalk()),
            ],
        ),
        (
            "a box of light on a sheet",
            vec![(SHEET, clay()), (BLOCK, lamp())],
        ),
        (
            "a box flush with a wall",
            vec![
                (ROOM, clay()),
                (Cuboid([-0.5, -0.5, 1.0], [0.5, 0.5, 1.5], false), chalk()),
            ],
        ),
        (
            "a box open above",
            vec![(SHEET, clay()), (Square([0.0; 3], 0.5, false), chalk())],
        ),
        (
            "three sheets, two of them back to back",
            vec![
                (Square(CENTRE, 0.5, true), clay()),
                (PANEL_UP, chalk()),
                (PANEL_DOWN, chalk()),
            ],
        ),
        (
            "a closed body twice",
            vec![
                (Cuboid([-0.5; 3], [0.5; 3], false), clay()),
                (Cuboid([-0.5; 3], [0.5; 3], false), chalk()),
            ],
        ),
        (
            "two balls of glass",
            vec![(Ball(CENTRE, 0.5), glass()), (Ball(CENTRE, 0.5), glass())],
        ),
        (
            "two balls of two colours",
            vec![(Ball(CENTRE, 0.5), clay()), (Ball(CENTRE, 0.5), chalk())],
        ),
        (
            "a ball and a zone of it",
            vec![
                (Ball(CENTRE, 0.5), mirror()),
                (Zone(CENTRE, 0.5, [0.1, 0.2]), clay()),
            ],
        ),
        (
            "zones that overlap",
            vec![
                (Zone(CENTRE, 0.5, [-1.0, 0.2]), lamp()),
                (Zone(CENTRE, 0.5, [0.1, 1.0]), clay()),
            ],
        ),
    ];
    for (what, shapes) in refused {
        assert!(!is_built(&shapes), "{what}");
    }
}
