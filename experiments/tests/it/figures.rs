//! Tests that every figure has a title and a description, decimal coordinates, and series that can
//! be distinguished without colour.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

use experiments::plot::agreement::{Agreement, MatrixCell, agreement_matrix, histograms};
use experiments::plot::chart::{Chart, Mark, Series, charts};
use experiments::plot::differences::{PanelSettings, differences};
use experiments::plot::forest::{Line, forest};
use experiments::plot::map::{Map, diverging, maps};
use experiments::plot::matrix::{Detection, matrix};
use roxmltree::{Document, Node};
use whitefurnace::error::Error;
use whitefurnace::harness::outcome::Verdict;

use crate::folder;

/// Returns the text of a figure that `draw` writes.
fn drawn(name: &str, draw: impl FnOnce(&std::path::Path) -> Result<(), Error>) -> String {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("figures");
    fs::create_dir_all(&folder).expect("a folder");
    let path = folder.join(format!("{name}.svg"));
    draw(&path).expect("a figure");
    fs::read_to_string(&path).expect("a figure")
}

/// The colours of series, in their order.
const OKABE_ITO: [&str; 8] = [
    "#D55E00", "#009E73", "#0072B2", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#828282",
];

fn chart(series: Vec<Series>) -> Chart {
    Chart::new("A < B", ["x (m)", "y (s)"], [[0.0, 1.0]; 2], series)
}

/// Parses a figure as browsers do: malformed XML is an error.
fn parsed(svg: &str) -> Document<'_> {
    Document::parse(svg).unwrap_or_else(|error| panic!("{error}: {svg}"))
}

fn polylines<'a>(svg: &'a Document<'_>) -> impl DoubleEndedIterator<Item = Node<'a, 'a>> {
    svg.descendants()
        .filter(|node| node.has_tag_name("polyline"))
}

/// Collects the shapes that are drawn, by colour: elements and the corners of polygons relative to
/// the first.
fn marks<'a>(svg: &'a Document<'_>) -> BTreeMap<&'a str, BTreeSet<String>> {
    let mut marks: BTreeMap<_, BTreeSet<_>> = BTreeMap::new();
    for node in svg.descendants() {
        let tag = node.tag_name().name();
        let colour = match tag {
            "circle" | "polygon" => node.attribute("fill"),
            "polyline" => node.attribute("stroke"),
            _ => continue,
        };
        let points = points(&node);
        let relative = points
            .iter()
            .map(|[x, y]| [x - points[0][0], y - points[0][1]]);
        let look = format!("{tag} {:?}", relative.collect::<Vec<_>>());
        marks
            .entry(colour.expect("a colour"))
            .or_default()
            .insert(look);
    }
    marks
}

/// Returns the points of a polygon or a line, in pixels; none for other elements.
fn points(node: &Node<'_, '_>) -> Vec<[f64; 2]> {
    let pixels = |text: &str| text.parse::<f64>().expect("a coordinate") / 100.0;
    let point = |text: &str| text.split_once(',').map(|(x, y)| [x, y].map(pixels));
    let texts = node
        .attribute("points")
        .unwrap_or_default()
        .split_whitespace();
    texts.map(|text| point(text).expect("a point")).collect()
}

#[test]
fn every_figure_says_what_it_shows() {
    let see = "What there is to see & know.";
    let line = |interval, verdict| Line {
        label: "a".to_owned(),
        estimate: 0.0,
        interval,
        verdict,
    };
    let map = Map {
        title: "A < B".to_owned(),
        size: [1, 1],
        ..map(vec![9.0])
    };
    let title = "A < B";
    let names = ["n".to_owned()];
    let common = PanelSettings {
        regions: &[("a region", 2.0)],
        axis: "y",
        band: "allowed",
    };
    let square = |_, _| {
        Some(MatrixCell {
            text: "1".to_owned(),
            agreement: Agreement::Biased,
        })
    };
    let panels = [("n".to_owned(), vec![1, 2])];
    let figures = [
        drawn("charts", |path| {
            charts(path, see, [400, 300], &[chart(Vec::new())])
        }),
        drawn("differences", |path| {
            differences(
                path,
                title,
                see,
                &common,
                &[("panel", vec![[1.0, -50.0, 0.0]])],
            )
        }),
        drawn("forest", |path| {
            forest(
                path,
                title,
                see,
                "interval",
                &[line([-0.5, 0.5], Verdict::Undecided { needed: 9 })],
            )
        }),
        drawn("map", |path| maps(path, see, [400, 300], 1, &[map])),
        drawn("matrix", |path| {
            matrix(path, title, see, &names, &names, |_, _| {
                Some(Detection::Missed)
            })
        }),
        drawn("squares", |path| {
            agreement_matrix(path, title, see, &names, &names, "blank", square)
        }),
        drawn("histograms", |path| histograms(path, title, see, &panels)),
    ];
    for svg in figures {
        assert!(
            svg.contains("<title id=\"title\">A &lt; B</title>"),
            "{svg}"
        );
        assert!(
            svg.contains("<desc id=\"see\">What there is to see &amp; know.</desc>"),
            "{svg}"
        );
        assert!(svg.contains("aria-labelledby=\"title see\""), "{svg}");
        parsed(&svg);
    }
}

#[test]
fn curves_are_not_jagged() {
    let parabola = (0..=200)
        .map(|i| f64::from(i) / 200.0)
        .map(|x| [x, 0.1 + 0.05 * x * x]);
    let series = Series::new("parabola", 0, Mark::Line, parabola);
    let svg = drawn("parabola", |path| {
        charts(path, "", [400, 300], &[chart(vec![series])])
    });
    let curve = polylines(&parsed(&svg))
        .map(|line| points(&line))
        .max_by_key(Vec::len)
        .expect("a curve");
    let heights: Vec<f64> = curve.iter().map(|point| point[1]).collect();
    assert_eq!(heights.len(), 201);
    // A parabola has equal second differences: each is off by less than four roundings to two
    // decimals.
    let bend: Vec<f64> = heights
        .windows(3)
        .map(|y| y[0] - 2.0 * y[1] + y[2])
        .collect();
    let [least, most] =
        [f64::min, f64::max].map(|of| bend.iter().copied().reduce(of).expect("many"));
    assert!(
        most - least <= 0.04,
        "second differences from {least} to {most}"
    );
}

#[test]
fn series_are_told_apart_without_colour() {
    const COUNT: usize = 8;
    let points = vec![[0.5, 0.5], [0.6, 0.6]];
    for mark in [Mark::Line, Mark::Points] {
        let series = |i: usize| Series::new("", i, mark, points.clone());
        // Black, 6, is the colour of references, which have a solid line.
        let colours = (0..COUNT).filter(|&i| i != 6);
        let svg = drawn("series", |path| {
            charts(
                path,
                "",
                [400, 300],
                &[chart(colours.map(series).collect())],
            )
        });
        let svg = parsed(&svg);
        let looks: BTreeSet<String> = match mark {
            Mark::Line => {
                let dash = |line: Node<'_, '_>| format!("{:?}", line.attribute("stroke-dasharray"));
                polylines(&svg).rev().take(COUNT - 1).map(dash).collect()
            }
            _ => {
                let marks = marks(&svg);
                (0..COUNT)
                    .filter(|&i| i != 6)
                    .map(|i| format!("{:?}", marks[OKABE_ITO[i]]))
                    .collect()
            }
        };
        assert_eq!(looks.len(), COUNT - 1, "{mark:?}: {looks:#?}");
    }
}

/// Returns a map of two values on a scale of ±4, without text.
fn map(values: Vec<f64>) -> Map {
    Map {
        title: String::new(),
        axes: [String::new(), String::new()],
        ranges: [[0.0, 1.0]; 2],
        size: [2, 1],
        values,
        bound: 4.0,
        unit: String::new(),
    }
}

fn two_cells(name: &str, values: Vec<f64>) -> String {
    drawn(name, |path| maps(path, "", [400, 300], 1, &[map(values)]))
}

#[test]
fn what_is_off_a_map_s_scale_is_marked() {
    let triangles = |values| {
        let svg = two_cells("overflow", values);
        svg.lines()
            .filter(|line| line.starts_with("<polygon stroke=\"#fff\"") && line.contains("#FFFFFF"))
            .count()
    };
    assert_eq!(triangles(vec![4.0, -4.0]), 0);
    assert_eq!(triangles(vec![4.1, 0.0]), 1);
    assert_eq!(triangles(vec![4.1, -4.1]), 2);
}

#[test]
fn maps_hold_their_cells_in_colours_of_equal_weight() {
    let grey = diverging(0.0);
    assert!(grey[0] > 235 && grey.iter().all(|&channel| channel.abs_diff(grey[0]) <= 1));
    assert_eq!(diverging(-3.0), diverging(-1.0));
    // Relative luminance (ITU-R BT.709, linear) of both ends is about the same.
    let luminance = |share: f64| -> f64 {
        let linear = |channel: u8| (f64::from(channel) / 255.0).powf(2.2);
        let products = diverging(share).into_iter().zip([0.2126, 0.7152, 0.0722]);
        products
            .map(|(channel, weight)| weight * linear(channel))
            .sum()
    };
    assert!((luminance(1.0) - luminance(-1.0)).abs() < 0.03);
    assert!(luminance(-1.0) < luminance(-0.5) && luminance(-0.5) < luminance(0.0));

    let svg = two_cells("cells", vec![-1.0, 5.0]);
    // The first bytes of every PNG.
    assert!(svg.contains("href=\"data:image/png;base64,iVBORw0KGgo"));
    parsed(&svg);
    assert!(
        maps(
            &folder("maps").join("map.svg"),
            "one value",
            [400, 300],
            1,
            &[map(vec![0.0])]
        )
        .is_err()
    );
}

/// Values without a verdict have a colour that is not on the scale, and the legend explains it.
#[test]
fn what_is_not_judged_is_grey() {
    let svg = |values| two_cells("unknown", values);
    let [known, unknown] = [svg(vec![0.0, -9.0]), svg(vec![0.0, f64::NAN])];
    assert!(unknown.contains("not judged") && !known.contains("not judged"));
    let picture = |svg: &str| {
        svg.split("base64,")
            .nth(1)
            .expect("a picture")
            .split('"')
            .next()
            .map(str::to_owned)
    };
    assert!(
        picture(&known) != picture(&unknown),
        "as if it were far below"
    );
}

/// Few columns leave as much room for title and legend as many: nothing covers the cells or is cut
/// off.
#[test]
fn a_narrow_matrix_has_room_for_its_legend() {
    let names = ["n".to_owned()];
    let blank = "not compared: undefined, or without finite variance";
    let title = "Image mean relative to the reference ± half its interval";
    let square = |_, _| {
        Some(MatrixCell {
            text: "1".to_owned(),
            agreement: Agreement::Agrees,
        })
    };
    let svg = drawn("narrow", |path| {
        agreement_matrix(path, title, "", &names, &names, blank, square)
    });
    let svg = parsed(&svg);
    let number = |node: Node<'_, '_>, name| {
        node.attribute(name)
            .and_then(|n| n.parse().ok())
            .expect("a number")
    };
    let height = |text: &str| -> f64 {
        let mut texts = svg.descendants().filter(|node| node.has_tag_name("text"));
        number(
            texts
                .find(|node| node.text().is_some_and(|t| t.trim() == text))
                .expect("a text"),
            "y",
        )
    };
    assert!(
        height("n") > height(blank) + 1800.0,
        "the legend stands in the matrix"
    );
    assert!(
        number(svg.root_element(), "width") > 500.0,
        "the title is cut off"
    );
}
