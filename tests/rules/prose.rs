//! Rules of style that neither rustfmt nor Clippy checks, for every Rust file of the workspace.
//!
//! A documentation comment begins with the thing, not with "Of" or "What", and a function takes
//! named parameters rather than tuples of different things.

use std::collections::{BTreeSet, HashSet};
use std::fmt;
use std::path::{Path, PathBuf};

use proc_macro2::{TokenStream, TokenTree};
use syn::spanned::Spanned;
use syn::visit::Visit;
use syn::{File, FnArg, Lit, Pat, Signature, Type, TypeTuple};

/// Folders of the workspace that hold Rust files.
const FOLDERS: [&str; 4] = ["src", "tests", "experiments", "book"];

/// Words with which no documentation comment begins.
const OPENINGS: [&str; 3] = ["Of", "What", "What's"];

/// A rule that is broken at a line of a file.
#[derive(Debug, PartialEq)]
struct Finding {
    line: usize,
    kind: Kind,
    /// First line of the comment, or name of the function and its parameter.
    text: String,
}

/// Rules of style.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Opening,
    TuplePattern,
    MixedTuple,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Opening => "documentation begins with \"Of\" or \"What\"",
            Self::TuplePattern => "parameter is a tuple pattern",
            Self::MixedTuple => "parameter is a tuple of different types",
        })
    }
}

/// One line of documentation.
struct DocLine {
    line: usize,
    inner: bool,
    text: String,
}

/// Collects documentation in order, also inside macros.
fn doc_lines(tokens: TokenStream, found: &mut Vec<DocLine>) {
    let is = |token: &TokenTree, c| matches!(token, TokenTree::Punct(p) if p.as_char() == c);
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    for (i, token) in tokens.iter().enumerate() {
        let TokenTree::Group(group) = token else {
            continue;
        };
        let inner = i > 0 && is(&tokens[i - 1], '!');
        let hash = i.checked_sub(1 + usize::from(inner));
        let content: Vec<TokenTree> = group.stream().into_iter().collect();
        if let [TokenTree::Ident(name), equals, TokenTree::Literal(text)] = &content[..]
            && hash.is_some_and(|hash| is(&tokens[hash], '#'))
            && name == "doc"
            && is(equals, '=')
            && let Lit::Str(text) = Lit::new(text.clone())
        {
            found.push(DocLine {
                line: text.span().start().line,
                inner,
                text: text.value(),
            });
        } else {
            doc_lines(group.stream(), found);
        }
    }
}

/// Finds documentation comments whose first line begins with one of [`OPENINGS`].
fn openings(tokens: TokenStream) -> Vec<Finding> {
    let mut docs = Vec::new();
    doc_lines(tokens, &mut docs);
    let continues = |i: usize| {
        i > 0 && docs[i - 1].line + 1 == docs[i].line && docs[i - 1].inner == docs[i].inner
    };
    docs.iter()
        .enumerate()
        .filter(|&(i, doc)| {
            let word = doc.text.split_whitespace().next();
            !continues(i) && word.is_some_and(|word| OPENINGS.contains(&word))
        })
        .map(|(_, doc)| Finding {
            line: doc.line,
            kind: Kind::Opening,
            text: doc.text.trim().to_owned(),
        })
        .collect()
}

/// Collects tuples among the parameters of functions and methods. Closures may take them.
#[derive(Default)]
struct Tuples(Vec<Finding>);

impl<'ast> Visit<'ast> for Tuples {
    /// Conversions take what they convert.
    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        let of = item.trait_.as_ref().map(|(_, path, _)| path);
        let is_conversion = of.is_some_and(|path| {
            let last = path.segments.last();
            last.is_some_and(|segment| segment.ident == "From")
        });
        if !is_conversion {
            syn::visit::visit_item_impl(self, item);
        }
    }
    fn visit_signature(&mut self, signature: &'ast Signature) {
        for (i, input) in signature.inputs.iter().enumerate() {
            let FnArg::Typed(parameter) = input else {
                continue;
            };
            let kind = if is_tuple_pattern(&parameter.pat) {
                Kind::TuplePattern
            } else if tuple(&parameter.ty).is_some_and(is_mixed) {
                Kind::MixedTuple
            } else {
                continue;
            };
            self.0.push(Finding {
                line: parameter.span().start().line,
                kind,
                text: format!("{}, parameter {}", signature.ident, i + 1),
            });
        }
        syn::visit::visit_signature(self, signature);
    }
}

fn is_tuple_pattern(pattern: &Pat) -> bool {
    match pattern {
        Pat::Tuple(_) => true,
        Pat::Reference(reference) => is_tuple_pattern(&reference.pat),
        Pat::Paren(paren) => is_tuple_pattern(&paren.pat),
        _ => false,
    }
}

/// Returns the tuple that a type is or refers to.
fn tuple(ty: &Type) -> Option<&TypeTuple> {
    match ty {
        Type::Tuple(tuple) => Some(tuple),
        Type::Reference(reference) => tuple(&reference.elem),
        Type::Paren(paren) => tuple(&paren.elem),
        _ => None,
    }
}

fn is_mixed(tuple: &TypeTuple) -> bool {
    tuple.elems.iter().collect::<HashSet<_>>().len() > 1
}

/// Finds what breaks the rules in a source text.
fn findings(source: &str) -> Result<Vec<Finding>, syn::Error> {
    let tokens: TokenStream = source.parse()?;
    let mut found = openings(tokens.clone());
    let file: File = syn::parse2(tokens)?;
    let mut tuples = Tuples::default();
    tuples.visit_file(&file);
    found.extend(tuples.0);
    Ok(found)
}

/// Lists the Rust files below a folder, without those in folders named `target`.
fn rust_files(folder: &Path, files: &mut BTreeSet<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of the workspace") {
        let path = entry.expect("an entry").path();
        if path.is_dir() && path.file_name().is_some_and(|name| name != "target") {
            rust_files(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.insert(path);
        }
    }
}

#[test]
fn prose_and_parameters_follow_the_rules() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut files = BTreeSet::new();
    for folder in FOLDERS {
        rust_files(&root.join(folder), &mut files);
    }
    assert!(files.len() > 100, "only {} files", files.len());
    let mut report = Vec::new();
    for path in &files {
        let source = std::fs::read_to_string(path).expect("a source file");
        let name = path.strip_prefix(&root).expect("below the root").display();
        let found = findings(&source).unwrap_or_else(|error| panic!("{name}: {error}"));
        report.extend(
            found
                .iter()
                .map(|Finding { line, kind, text }| format!("{name}:{line}: {kind}: {text}")),
        );
    }
    assert!(report.is_empty(), "{}", report.join("\n"));
}

/// Lines and kinds of what is found in a snippet.
fn found(source: &str) -> Vec<(usize, Kind)> {
    let findings = findings(source).expect("Rust");
    findings.iter().map(|f| (f.line, f.kind)).collect()
}

#[test]
fn prose_openings_are_found() {
    for (source, line) in [
        ("//! Of a module.", 1),
        ("//! What a module does.", 1),
        ("/// What's in it.\nstruct A;", 1),
        ("/** What a block says. */\nstruct A;", 1),
        ("#[doc = \"What an attribute says.\"]\nstruct A;", 1),
        ("struct A {\n    /// Of a field.\n    x: f64,\n}", 2),
        ("enum A {\n    /// What a variant is.\n    B,\n}", 2),
        ("impl A {\n    /// Of a method.\n    fn b() {}\n}", 2),
        ("thing! {\n    /// What a macro takes.\n    x\n}", 2),
        ("//! A module.\n/// What an item is.\nstruct A;", 2),
    ] {
        assert_eq!(found(source), [(line, Kind::Opening)], "{source}");
    }
}

#[test]
fn prose_that_begins_with_the_thing_is_allowed() {
    for source in [
        "/// Area of a triangle.\n/// What follows is its formula.\nfn f() {}",
        "/// Whatever is left.\nfn f() {}",
        "/// Offset of the ray.\nfn f() {}",
        "// What an ordinary comment says.\nfn f() {}",
        "fn f() -> &'static str { \"/// What a string holds\" }",
    ] {
        assert_eq!(found(source), [], "{source}");
    }
}

#[test]
fn prose_tuple_parameters_are_found() {
    for (source, line, kind) in [
        ("fn f((a, b): (A, B)) {}", 1, Kind::TuplePattern),
        ("fn f((a, b): (A, A)) {}", 1, Kind::TuplePattern),
        ("fn f(&(a, b): &(A, B)) {}", 1, Kind::TuplePattern),
        ("fn f((a, b): Pair) {}", 1, Kind::TuplePattern),
        (
            "fn f(\n    x: A,\n    y: (A, B),\n) {}",
            3,
            Kind::MixedTuple,
        ),
        ("fn f(x: &mut (A, B)) {}", 1, Kind::MixedTuple),
        ("fn f(x: (A, A, Vec<A>)) {}", 1, Kind::MixedTuple),
        (
            "impl A {\n    fn f(&self, x: (A, B)) {}\n}",
            2,
            Kind::MixedTuple,
        ),
        ("trait A {\n    fn f(x: (A, B));\n}", 2, Kind::MixedTuple),
        (
            "fn f() {\n    fn g((a, b): (A, B)) {}\n}",
            2,
            Kind::TuplePattern,
        ),
    ] {
        assert_eq!(found(source), [(line, kind)], "{source}");
    }
}

#[test]
fn prose_pairs_of_like_things_and_closures_are_allowed() {
    for source in [
        "fn f(range: (f64, f64)) {}",
        "fn f(ends: &(Vec<A>, Vec<A>)) {}",
        "fn f([a, b]: [A; 2]) {}",
        "fn f(Pair(a, b): Pair) {}",
        "fn f(pairs: &[(A, B)]) {}",
        "fn f(g: impl Fn((A, B))) {}",
        "fn f() { g(|(a, b): (A, B)| a) }",
        "fn f() -> (A, B) { g() }",
        "impl From<(A, B)> for C { fn from((a, b): (A, B)) -> C { g() } }",
    ] {
        assert_eq!(found(source), [], "{source}");
    }
}
