//! Tests of `judge` for sampled directions: every format, every verdict, and refusals.

mod own_pdf;

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::path::Path;

use experiments::judge::read::rows;
use experiments::judge::{TableDomain, read_table};
use glam::DVec3;
use npyz::WriterBuilder as _;
use whitefurnace::harness::trial::Context;
use whitefurnace::sampling::rng::{stream, uniform, uniform2};
use whitefurnace::sampling::warp::cosine_hemisphere;

use crate::{case, folder, run, text};

/// Asserts the exit code of a [`case`], and that a line of the output contains its hint.
fn assert_case(folder: &Path, text_of_case: &str) {
    let (code, options, hint) = case(text_of_case);
    let output = run(env!("CARGO_BIN_EXE_judge"), folder, options);
    let lines = text(&output.stdout) + &text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{options}: {lines}");
    assert!(lines.contains(hint), "{hint}: {lines}");
    assert!(
        code != 3 || lines.starts_with("error: ") && lines.lines().count() == 1,
        "{lines}"
    );
}

/// Returns cosine-weighted directions from a fixed seed.
fn cosines(n: u32) -> Vec<DVec3> {
    let mut rng = stream(5, 0, 0);
    (0..n)
        .map(|_| cosine_hemisphere(uniform2(&mut rng)))
        .collect()
}

fn npy(path: &Path, order: npyz::Order, shape: [u64; 2], numbers: impl Iterator<Item = f64>) {
    let file = std::fs::File::create(path).expect("a file");
    let writer = npyz::WriteOptions::new()
        .default_dtype()
        .order(order)
        .shape(&shape)
        .writer(file);
    let mut writer = writer.begin_nd().expect("a header");
    writer
        .extend(numbers)
        .and_then(|()| writer.finish())
        .expect("written");
}

#[test]
fn samples_are_read_from_every_format_and_judged() {
    let folder = folder("judge");
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("written");
    let directions = cosines(200_000);
    let mut rows = "# by cosine\nPDF, z, y, x\n".to_owned();
    // Fewer directions as text, which takes longer to read, agree within a wider margin.
    let text_directions = &directions[..40_000];
    for DVec3 { x, y, z } in text_directions {
        writeln!(rows, "{},{z},{y},{x}", z / PI).expect("text");
    }
    write("header.csv", &rows);
    for case in [
        "0 --samples header.csv --density cosine --margin 20 => reported pdf: holds",
        "1 --samples header.csv --density cosine --columns pdf,x,y,z => DIFFER: ",
        "0 --samples header.csv --density cosine --columns -,z,y,x --margin 20 => AGREE: ",
    ] {
        assert_case(&folder, case);
    }
    let shape = [directions.len() as u64, 3];
    npy(
        &folder.join("c.npy"),
        npyz::Order::C,
        shape,
        directions.iter().flat_map(|w| w.to_array()),
    );
    let columns = (0..3).flat_map(|axis| directions.iter().map(move |w| w[axis]));
    npy(
        &folder.join("fortran.npy"),
        npyz::Order::Fortran,
        shape,
        columns,
    );
    let lines = |options: &str| text(&run(env!("CARGO_BIN_EXE_judge"), &folder, options).stdout);
    let [c, fortran] = ["c", "fortran"]
        .map(|name| lines(&format!("--samples {name}.npy --density cosine-power:1")));
    assert!(c.starts_with("AGREE: ") && c == fortran, "{c}{fortran}");
    let found = std::fs::read(folder.join("out/judge/judge.json")).expect("a report");
    let found: serde_json::Value = serde_json::from_slice(&found).expect("JSON");
    assert_eq!(
        (found["n"].as_u64(), found["verdict"].as_str()),
        (Some(200_000), Some("agree"))
    );
    assert!(folder.join("out/judge/cells.svg").is_file());
    // The pdf of the cosine's table is the height of its bands.
    let table: String = (0..100)
        .map(|i| format!("{}\n", 99.5 - f64::from(i)))
        .collect();
    write("table.csv", &table);
    for case in [
        "1 --samples c.npy --density uniform-hemisphere => DIFFER: the histogram of ",
        "0 --samples c.npy --table table.csv => AGREE: ",
        "1 --samples c.npy --table table.csv --domain sphere => DIFFER: ",
    ] {
        assert_case(&folder, case);
    }
    // Weights of 1, half of them lost; and too few samples.
    let lost = |i: usize, w: &DVec3| {
        if i.is_multiple_of(2) {
            "0,0,0,0".to_owned()
        } else {
            format!("{},{},{},1", w.x, w.y, w.z)
        }
    };
    let rows: String = text_directions
        .iter()
        .enumerate()
        .map(|(i, w)| lost(i, w) + "\n")
        .collect();
    write("lost.csv", &rows);
    for case in [
        "1 --samples lost.csv --density cosine --mean-weight 0.5 => 20000 samples lost, 0.0 expected",
        "1 --samples lost.csv --density cosine --mean-weight 0.5 --margin 20 => mean weight: holds",
        "1 --samples lost.csv --density cosine --mean-weight 1 => mean weight: fails",
        "1 --samples lost.csv --density cosine => \ncolumns read: x, y, z, weight\n",
        "0 --samples header.csv --density cosine --columns -,z,y,x --margin 20 => \ncolumns read: -, z, y, x\n",
    ] {
        assert_case(&folder, case);
    }
    let few: String = directions[..20]
        .iter()
        .map(|w| format!("{},{},{}\n", w.x, w.y, w.z))
        .collect();
    write("few.csv", &few);
    assert_case(
        &folder,
        "2 --samples few.csv --density cosine --margin 20 => UNDECIDED: nothing differs",
    );
}

#[test]
fn what_is_no_sample_is_refused_in_one_line() {
    let folder = folder("judge-bad");
    npy(
        &folder.join("whole.npy"),
        npyz::Order::C,
        [5, 4],
        (0..20).map(f64::from),
    );
    let bytes = std::fs::read(folder.join("whole.npy")).expect("written");
    for (name, bytes, hint) in [
        ("empty.csv", &b""[..], "no samples"),
        ("names.csv", b"x,y,w\n0,0,1\n", "no column is called w"),
        (
            "twice.csv",
            b"x,y,y\n0,0,1\n",
            "occurs twice: choose by --columns",
        ),
        (
            "words.csv",
            b"0,0,1\n0,zero,1\n",
            "line 2: \u{201c}zero\u{201d} is not a number",
        ),
        (
            "short.csv",
            b"0,0,1\n0,0\n",
            "line 2: 2 numbers, where 3 are expected",
        ),
        ("two.csv", b"0,1\n", "2 columns, where 3 to 5 are expected"),
        (
            "long.csv",
            b"0,0,1\n0,1,1\n",
            "line 2: the direction [0, 1, 1] has length 1.41",
        ),
        ("nan.csv", b"0,0,NaN\n", "has length NaN"),
        ("weight.csv", b"0,0,1,-1\n", "the weight is -1"),
        ("bytes.csv", &[0xff, 0x31], "line 1: not UTF-8"),
        (
            "commas.csv",
            b"0,6,0,0,0,8\n",
            "commas may be decimal marks here, or separate whole numbers: separate the numbers by semicolons",
        ),
        (
            "suffix.txt",
            b"0.0f,0.0f,1.0f\n0,0,1\n",
            "line 1: \u{201c}0.0f\u{201d} is not a number",
        ),
        ("hex.txt", b"0x0p+0 0x0p+0 0x1p+0\n", "is not a number"),
        ("packed.csv", b"\x1f\x8b\x08\0", "compressed by gzip"),
        (
            "columns.csv",
            b"1 2 3 4 5 6 7 8 9 10 11\n",
            "transpose them",
        ),
        (
            "none.npy",
            &bytes
                .iter()
                .map(|&byte| if byte == b'4' { b'0' } else { byte })
                .collect::<Vec<_>>(),
            "columns",
        ),
        (
            "cut.npy",
            &bytes[..bytes.len() - 150],
            "shorter than its shape",
        ),
        ("header.npy", &bytes[..40], "header.npy"),
        (
            "rows.npy",
            &bytes,
            "row 0: the direction [0, 1, 2] has length",
        ),
    ] {
        std::fs::write(folder.join(name), bytes).expect("written");
        assert_case(
            &folder,
            &format!("3 --samples {name} --density cosine => {hint}"),
        );
    }
    std::fs::write(folder.join("one.csv"), "0,0,1\n").expect("written");
    for case in [
        "--density cosin => there are uniform-sphere",
        "--density ggx:0.3 => wrong number of parameters",
        "--density ggx:3,60 => ALPHA must be from 0.01 to 1",
        "--density cosine --mean-weight 1 => needs samples with a column weight",
        "--density cosine --columns x,y => no column z",
        "--table empty.csv => no number above 0",
        "--table nan.csv => line 1: a pdf must be finite",
        "--table none.csv => cannot read none.csv",
        "--density cosine --out one.csv/out => cannot create",
    ] {
        std::fs::write(folder.join("empty.csv"), "").expect("written");
        assert_case(&folder, &format!("3 --samples one.csv {case}"));
    }
}

/// Random bytes in any place, and any length: the file gives as many rows as it has room for, a
/// table, or an error of one line.
#[test]
fn damaged_files_are_read_or_refused() {
    let folder = folder("judge-damaged");
    let mut wholes =
        vec![b"# heights\nx, y, z, weight\n0, 0.6, 0.8, 1\n0,0,0,0\n1e-3,0,1,2\n".to_vec()];
    for order in [npyz::Order::C, npyz::Order::Fortran] {
        npy(
            &folder.join("whole.npy"),
            order,
            [5, 4],
            (0..20).map(f64::from),
        );
        wholes.push(std::fs::read(folder.join("whole.npy")).expect("written"));
    }
    let context = Context::from_environment()
        .expect("a seed")
        .named("damaged samples");
    let (mut rng, path) = (context.rng("damage"), folder.join("damaged"));
    let mut found = [0; 2];
    for _ in 0..context.arguments(3000) {
        let mut below = |n: usize| (uniform(&mut rng) * n as f64) as usize;
        let mut bytes = wholes[below(3)].clone();
        for _ in 0..1 + below(3) {
            let at = below(bytes.len());
            bytes[at] = [b'0', b'9', b'-', b',', below(256) as u8][below(5)];
        }
        bytes.truncate(if below(4) == 0 {
            below(bytes.len())
        } else {
            bytes.len()
        });
        std::fs::write(&path, &bytes).expect("written");
        let mut count = 0;
        let read = rows(&path, &mut |row| {
            count += row.numbers.len().max(1);
            assert!(count <= bytes.len(), "more numbers than bytes: {bytes:?}");
            Ok(())
        });
        let table = read_table(&path, TableDomain::Sphere).map(|_| ());
        for result in [read, table] {
            found[usize::from(result.is_ok())] += 1;
            let message = result.map_or_else(|error| error.to_string(), |()| String::new());
            assert!(message.len() < 500 && !message.contains('\n'), "{message}");
        }
    }
    assert!(found.iter().all(|count| *count > 100), "{found:?}");
}

/// Text with the same numbers is read in every usual format, and truncated files are refused by
/// name.
#[test]
fn text_is_read_in_every_form() {
    let path = folder("judge-forms").join("samples");
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).expect("written");
        let (mut found, mut names) = (Vec::new(), None);
        let result = rows(&path, &mut |row| {
            found.push(row.numbers.to_vec());
            names = row.names.map(<[String]>::to_vec);
            Ok(())
        });
        result
            .map(|()| (found, names))
            .map_err(|error| error.to_string())
    };
    let utf16 = |text: &str| {
        text.encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect::<Vec<u8>>()
    };
    for bytes in [
        &b"0.6 0 0.8\n0 -1.5 0\n"[..],
        b"0.6\t0\t0.8\r\n0\t-1.5\t0\r\n",
        b"0.6;0;0.8\r0;-1.5;0\r",
        b"0,6;0;0,8\n0;-1,5;0",
        b"0,6 0 0,8\n0 -1,5 0\n",
        b"# by numpy\n6.00e-01 0.00e+00 8.00e-01\n0.0 -1.50e+00 0.0\n",
        b"\xef\xbb\xbf0.6,0,0.8,\n\n0,-1.5,0,\n",
        b"[[0.6, 0, 0.8],\n [0, -1.5, 0]]\n",
        b"0.6D+00 0 8.0D-01\n0 -1.5 0\n",
        b"// by a program\n0.6,0,0.8\n0,-1.5,0\n",
        "0.6,0,0.8\n0,\u{2212}1.5,0\n".as_bytes(),
        &utf16("\u{feff}0.6,0,0.8\n0,-1.5,0\n"),
        &utf16("0.6,0,0.8\n0,-1.5,0\n"),
    ] {
        let (found, names) = read(bytes).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(
            (found, names),
            (vec![vec![0.6, 0.0, 0.8], vec![0.0, -1.5, 0.0]], None)
        );
    }
    for header in [
        "x;y;z",
        "# x y z",
        "\"X [m]\", \"y (1)\", 'z'",
        "wi_x,wi_y,wi_z",
        "# Dir.X dir.y dir.z",
        "wx, wy, wz",
    ] {
        let (_, names) = read(format!("{header}\n0.6,0,0.8\n").as_bytes()).expect("rows");
        assert_eq!(names.expect("names"), ["x", "y", "z"]);
    }
    let whole = "0.60000,0.00000,0.80000\n".repeat(12);
    let cut = read(&whole.as_bytes()[..whole.len() - 3]).expect_err("cut");
    assert!(cut.contains("line 12") && cut.contains("cut off"), "{cut}");
    let mixed = read(b"0,6;0;0,8\n0.6;0;0.8\n").expect_err("mixed");
    assert!(
        mixed.contains("line 2") && mixed.contains("decimal commas"),
        "{mixed}"
    );
}

/// A table is read the same from whole numbers with commas, other text and arrays, few rows and
/// many columns among them; where commas could as well be decimal marks it is refused.
#[test]
fn a_table_is_read_in_every_form() {
    let folder = folder("judge-tables");
    let path = folder.join("table");
    let pdfs = || {
        let density = read_table(&path, TableDomain::Sphere).expect("a table");
        let column = |z: f64, i: u32| {
            let (sin, cos) = (TAU * (f64::from(i) + 0.5) / 6.0).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            density.pdf(DVec3::new(radius * cos, radius * sin, z)) * 4.0 * PI / 12.0
        };
        let row = |z: f64| (0..6).map(move |i| column(z, i)).collect::<Vec<_>>();
        [row(0.5), row(-0.5)].concat()
    };
    let counts = [2.0, 0.0, 3.0, 4.0, 5.0, 6.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0];
    let text = [
        "2,0,3,4,5,6\n2,3,4,5,6,8\n",
        "a,b,c,d,e,f\n2,0,3,4,5,6\n2,3,4,5,6,8\n",
        "2 0 3 4 5 6\n2 3 4 5 6 8\n",
        "0,2;0,0;0,3;0,4;0,5;0,6\n0,2;0,3;0,4;0,5;0,6;0,8\n",
    ];
    let assert_right = |what: &str| {
        for (found, count) in pdfs().into_iter().zip(counts) {
            assert!(
                (found - count / 48.0).abs() < 1e-12,
                "{what}: {found}, {count}"
            );
        }
    };
    for text in text {
        std::fs::write(&path, text).expect("written");
        assert_right(text);
    }
    for order in [npyz::Order::C, npyz::Order::Fortran] {
        let index = |i: usize| match order {
            npyz::Order::C => i,
            npyz::Order::Fortran => i % 2 * 6 + i / 2,
        };
        npy(&path, order, [2, 6], (0..12).map(|i| counts[index(i)]));
        assert_right("an array");
    }
    npy(&path, npyz::Order::C, [3, 64], (0..192).map(f64::from));
    read_table(&path, TableDomain::Sphere).expect("a wide table");
    assert_case(
        &folder,
        "3 --samples table --density cosine => 64 columns, where 3 to 5 are expected: name them by --columns; if each column is a sample, transpose them",
    );
    for text in ["0,2,1,0,0,3\n", "2,25,3,125,4,50\n"] {
        std::fs::write(&path, text).expect("written");
        let refused = read_table(&path, TableDomain::Sphere).map(|_| ());
        let message = refused.expect_err("ambiguous").to_string();
        assert!(message.contains("semicolons"), "{message}");
    }
}
