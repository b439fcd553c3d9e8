//! The modules of the library form layers: siblings never import each other in a circle, and the
//! table in `src/lib.rs` lists the folders in an order in which each imports only from those above.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::Visit;
use syn::{File, ItemUse, UseTree, Visibility};

/// A module by the names on the way to it from the crate's root, which is empty.
type Module = Vec<String>;

/// A path as written in a file, segment by segment.
type Segments = Vec<String>;

/// The paths of a file: those that it uses, and those that it exports again.
#[derive(Default)]
struct Paths {
    used: Vec<Segments>,
    exported: Vec<Segments>,
}

impl<'ast> Visit<'ast> for Paths {
    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        let list = match item.vis {
            Visibility::Inherited => &mut self.used,
            _ => &mut self.exported,
        };
        leaves(&item.tree, &mut Vec::new(), list);
    }
    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments = path.segments.iter();
        self.used
            .push(segments.map(|segment| segment.ident.to_string()).collect());
        syn::visit::visit_path(self, path);
    }
}

/// Adds the paths of a `use` tree; a renamed item counts by its own name.
fn leaves(tree: &UseTree, prefix: &mut Segments, found: &mut Vec<Segments>) {
    let mut leaf = |name: String| {
        let mut path = prefix.clone();
        if name != "self" {
            path.push(name);
        }
        found.push(path);
    };
    match tree {
        UseTree::Path(path) => {
            prefix.push(path.ident.to_string());
            leaves(&path.tree, prefix, found);
            prefix.pop();
        }
        UseTree::Group(group) => {
            for tree in &group.items {
                leaves(tree, prefix, found);
            }
        }
        UseTree::Name(name) => leaf(name.ident.to_string()),
        UseTree::Rename(name) => leaf(name.ident.to_string()),
        UseTree::Glob(_) => leaf("*".to_owned()),
    }
}

/// The parsed modules of a crate.
struct Crate {
    paths: BTreeMap<Module, Paths>,
}

impl Crate {
    fn new(sources: impl IntoIterator<Item = (Module, String)>) -> Self {
        let parse = |(module, source): (Module, String)| {
            let file: File = syn::parse_str(&source).expect("a Rust file");
            let mut paths = Paths::default();
            paths.visit_file(&file);
            (module, paths)
        };
        Self {
            paths: sources.into_iter().map(parse).collect(),
        }
    }

    /// The path from the root that a path in a module names, if it is one of this crate.
    fn absolute(&self, module: &Module, path: &[String]) -> Option<Segments> {
        let supers = path.iter().take_while(|name| *name == "super").count();
        let (base, rest) = match path.first()?.as_str() {
            "crate" => (&[][..], &path[1..]),
            "self" => (&module[..], &path[1..]),
            "super" => (
                &module[..module.len().checked_sub(supers)?],
                &path[supers..],
            ),
            child => {
                let own = [&module[..], &[child.to_owned()]].concat();
                (path.len() > 1 && self.paths.contains_key(&own)).then_some(())?;
                (&module[..], path)
            }
        };
        Some([base, rest].concat())
    }

    /// The module in which the item of an absolute path is declared: re-exports are followed.
    fn module_of(&self, path: &[String]) -> Module {
        let known = (0..=path.len()).rev();
        let module = known
            .map(|length| path[..length].to_vec())
            .find(|module| self.paths.contains_key(module))
            .unwrap_or_default();
        let Some(item) = path.get(module.len()) else {
            return module;
        };
        let exports = self.paths[&module].exported.iter();
        let original = exports
            .filter(|export| export.last() == Some(item))
            .find_map(|export| self.absolute(&module, export));
        match original {
            Some(original) if original != path => self.module_of(&original),
            _ => module,
        }
    }

    /// For every pair of siblings of which one uses the other, itself or below it, a file that
    /// does. Modules and those that they lie in may use each other.
    fn imports(&self) -> BTreeMap<(Module, Module), Module> {
        let mut imports = BTreeMap::new();
        for (module, paths) in &self.paths {
            for path in &paths.used {
                let Some(path) = self.absolute(module, path) else {
                    continue;
                };
                let target = self.module_of(&path);
                let common = module
                    .iter()
                    .zip(&target)
                    .take_while(|(a, b)| a == b)
                    .count();
                if module.len() > common && target.len() > common {
                    let pair = (module[..=common].to_vec(), target[..=common].to_vec());
                    imports.entry(pair).or_insert_with(|| module.clone());
                }
            }
        }
        imports
    }

    /// A circle of siblings, each with the file that imports the next.
    fn circle(&self) -> Option<Vec<String>> {
        let imports = self.imports();
        let mut next: BTreeMap<&Module, BTreeSet<&Module>> = BTreeMap::new();
        for (from, to) in imports.keys() {
            next.entry(from).or_default().insert(to);
        }
        // Siblings without imports among those left are taken away until none or a circle is left.
        loop {
            let is_leaf = |module: &&Module| {
                let left = next[*module].iter();
                left.clone().all(|to| !next.contains_key(*to))
            };
            match next.keys().copied().find(|module| is_leaf(module)) {
                Some(leaf) => next.remove(leaf),
                None => break,
            };
        }
        let mut chain: Vec<&Module> = vec![next.keys().next()?];
        loop {
            let last = chain[chain.len() - 1];
            let to = next[last].iter().find(|to| next.contains_key(**to))?;
            if let Some(start) = chain.iter().position(|seen| seen == to) {
                let of_circle = chain[start..]
                    .iter()
                    .zip(chain[start + 1..].iter().chain([to]));
                let name = |(from, to): (&&Module, &&Module)| {
                    let file = imports[&((*from).clone(), (*to).clone())].join("::");
                    format!("{} imports {} (in {file})", from.join("::"), to.join("::"))
                };
                return Some(of_circle.map(name).collect());
            }
            chain.push(to);
        }
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../src")
}

/// Adds all modules below a folder with their sources.
fn read(folder: &Path, module: &Module, sources: &mut Vec<(Module, String)>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let stem = path.file_stem().and_then(|stem| stem.to_str());
        let name = stem.expect("a name").to_owned();
        let child = [&module[..], std::slice::from_ref(&name)].concat();
        if path.is_dir() {
            read(&path, &child, sources);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let is_own = matches!(name.as_str(), "mod" | "lib");
            let source = fs::read_to_string(&path).expect("UTF-8");
            sources.push((if is_own { module.clone() } else { child }, source));
        }
    }
}

fn library() -> Crate {
    let mut sources = Vec::new();
    read(&root(), &Vec::new(), &mut sources);
    Crate::new(sources)
}

#[test]
fn siblings_import_each_other_in_no_circle() {
    let library = library();
    assert!(library.paths.len() > 80, "the modules of src");
    assert!(library.imports().len() > 100, "their imports");
    if let Some(circle) = library.circle() {
        panic!("a circle of imports:\n{}", circle.join("\n"));
    }
}

#[test]
fn the_table_of_modules_lists_all_in_the_order_of_imports() {
    let source = fs::read_to_string(root().join("lib.rs")).expect("lib.rs");
    let rows = source
        .lines()
        .filter_map(|line| line.strip_prefix("//! | "));
    let first_cells = rows.filter_map(|row| row.split('|').next());
    let listed: Vec<String> = first_cells
        .flat_map(|cell| cell.split('`').skip(1).step_by(2))
        .map(str::to_owned)
        .collect();
    let declared = source.lines().filter_map(|line| {
        let declaration = line.strip_prefix("pub mod ").or(line.strip_prefix("mod "));
        declaration.and_then(|name| name.strip_suffix(';'))
    });
    let mut sorted = listed.clone();
    sorted.sort();
    assert_eq!(sorted, declared.collect::<Vec<_>>(), "modules of the table");
    let place = |module: &Module| listed.iter().position(|name| *name == module[0]);
    for ((from, to), file) in library().imports() {
        if from.len() == 1 {
            let is_above = place(&to) < place(&from);
            assert!(
                is_above,
                "{} imports {}, listed below {}",
                file.join("::"),
                to[0],
                from[0]
            );
        }
    }
}

/// A crate of these modules and sources.
fn small(sources: &[(&str, &str)]) -> Crate {
    Crate::new(sources.iter().map(|(module, source)| {
        let names = module.split("::").filter(|name| !name.is_empty());
        (names.map(str::to_owned).collect(), (*source).to_owned())
    }))
}

#[test]
fn circles_are_found_however_they_are_written() {
    let with = |a: &str| small(&[("", ""), ("a", a), ("b", "use crate::a::A;"), ("a::c", "")]);
    for a in [
        "use crate::b::B;",
        "use super::b;",
        "use crate::{a, b::{self, C as D}};",
        "fn f() { crate::b::g(); }",
        "struct S(super::b::B);",
    ] {
        assert!(with(a).circle().is_some(), "{a}");
    }
    for a in ["use std::b::B;", "use c::B;", "mod b { } use self::b::B;"] {
        assert_eq!(with(a).circle(), None, "{a}");
    }
    let deep = [
        ("", ""),
        ("a", ""),
        ("a::x", "use crate::b::B;"),
        ("b", "use crate::a::x::A;"),
    ];
    assert!(small(&deep).circle().is_some());
    let parent = [("", ""), ("a", "use x::X;"), ("a::x", "use super::A;")];
    assert_eq!(small(&parent).circle(), None);
    // b's item is declared in c: a and c import each other, whatever b is called on the way.
    let again = [
        ("", ""),
        ("a", "use crate::b::C;"),
        ("b", "pub use crate::c::C;"),
        ("c", "use crate::a::A;"),
    ];
    let circle = small(&again).circle().expect("a circle");
    assert_eq!(circle, ["a imports c (in a)", "c imports a (in c)"]);
}
