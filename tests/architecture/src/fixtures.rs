//! The reader is tried on small crates, each with a fault, or with what only looks like one.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::plan::{Plan, Storey};
use crate::source::{self, Imports};
use crate::{rings, storeys};

/// Reads a crate whose root is `src/lib.rs`, and which can use the crates `std` and `other`.
fn read(files: &[(&str, &str)]) -> Imports {
    let text = |wanted: &Path| {
        files
            .iter()
            .find(|(path, _)| Path::new("src").join(path) == wanted)
            .map(|(_, text)| (*text).to_owned())
    };
    source::read(Path::new("src/lib.rs"), &text, &["std", "other"].map(str::to_owned).into())
}

/// The arrows of a crate in short, in order.
fn arrows(files: &[(&str, &str)]) -> Vec<String> {
    let imports = read(files);
    assert_eq!(imports.lost, Vec::<String>::new());
    let short =
        |path: &Path| path.strip_prefix("src").unwrap_or(path).with_extension("").display().to_string();
    let told = imports.arrows.iter().map(|arrow| format!("{} > {}", short(&arrow.from), short(&arrow.to)));
    told.collect::<BTreeSet<_>>().into_iter().collect()
}

fn ring_count(files: &[(&str, &str)]) -> usize {
    rings::rings(&read(files).arrows).len()
}

#[test]
fn two_files_that_import_each_other_are_a_ring() {
    let files = [
        ("lib.rs", "mod writer; mod archivist;"),
        ("writer.rs", "use crate::archivist::Task; pub struct Shared(Task);"),
        ("archivist.rs", "use crate::writer::Shared; pub struct Task(Box<Shared>);"),
    ];
    assert_eq!(arrows(&files), ["archivist > writer", "writer > archivist"]);
    let imports = read(&files);
    let [ring] = &rings::rings(&imports.arrows)[..] else { panic!("not one ring") };
    let told = rings::told(ring);
    assert!(told.contains("src/writer.rs takes from src/archivist.rs: Task (line 1)"), "{told}");
}

#[test]
fn a_ring_may_have_many_files_and_others_beside_it() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c; mod below; mod above;"),
        ("a.rs", "use crate::b::B; pub struct A(B);"),
        ("b.rs", "use crate::c::C; use crate::below::D; pub struct B(C, D);"),
        ("c.rs", "use crate::a::A; pub struct C(Box<A>);"),
        ("below.rs", "pub struct D;"),
        ("above.rs", "use crate::a::A; pub struct E(A);"),
    ];
    let imports = read(&files);
    let rings = rings::rings(&imports.arrows);
    assert_eq!(rings.iter().map(Vec::len).collect::<Vec<_>>(), [3]);
}

#[test]
fn nested_groups_renames_and_relative_paths_are_followed() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c;"),
        ("a.rs", "pub struct One; pub mod deep { pub struct Two; } pub fn three() {}"),
        (
            "b.rs",
            "use super::{a::{deep::{self as below, Two}, One as Uno, three}}; fn f(_: below::Two, _: Two, _: Uno) { three() }",
        ),
        ("c/mod.rs", "mod d; pub struct Four;"),
        (
            "c/d.rs",
            "use super::super::a::One; use super::Four; use self::inner::Five; mod inner { pub struct Five; } struct S(One, Four, Five);",
        ),
    ];
    assert_eq!(arrows(&files), ["b > a", "c/d > a", "c/d > c/mod"]);
    assert_eq!(ring_count(&files), 0);
}

#[test]
fn a_path_in_code_is_an_import_too() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c;"),
        ("a.rs", "pub fn f() {} pub struct S; pub trait T {} pub const N: u8 = 1;"),
        ("b.rs", "fn g() { crate::a::f() }"),
        ("c.rs", "use crate::a; impl a::T for u8 {}"),
    ];
    assert_eq!(arrows(&files), ["b > a", "c > a"]);
    let in_a_type = [("lib.rs", "mod a; mod b;"), files[1], ("b.rs", "fn g(_: Option<super::a::S>) {}")];
    assert_eq!(arrows(&in_a_type), ["b > a"]);
    let in_a_macro =
        [("lib.rs", "mod a; mod b;"), files[1], ("b.rs", "fn g() { println!(\"{}\", crate::a::N) }")];
    assert_eq!(arrows(&in_a_macro), ["b > a"]);
    let in_an_attribute = [
        ("lib.rs", "mod a; mod b;"),
        files[1],
        ("b.rs", "struct P { #[arg(value_parser = crate::a::f)] q: u8 }"),
    ];
    assert_eq!(arrows(&in_an_attribute), ["b > a"]);
}

#[test]
fn an_import_through_a_reexport_leads_to_the_file_that_defines() {
    let files = [
        ("lib.rs", "mod kept; mod journal; pub use kept::*; pub use journal::Journal as Book;"),
        ("kept.rs", "pub struct Kept;"),
        ("journal.rs", "use crate::Kept; pub struct Journal(Kept);"),
    ];
    // The face of the crate defines nothing and is no room; what it hands on ties nobody to it.
    assert_eq!(arrows(&files), ["journal > kept"]);
    assert!(!read(&files).rooms.contains(Path::new("src/lib.rs")));
    let twice = [
        ("lib.rs", "mod a; mod b; mod user;"),
        ("a.rs", "pub struct S;"),
        ("b.rs", "pub use crate::a::S as Renamed; pub fn f() {}"),
        ("user.rs", "use crate::b::Renamed; struct U(Renamed);"),
    ];
    assert_eq!(arrows(&twice), ["user > a"]);
}

#[test]
fn a_glob_hands_on_only_names_that_can_be_seen() {
    let files = [
        ("lib.rs", "mod live; mod request; mod user; pub use live::*; pub use request::*;"),
        ("live.rs", "use crate::Status; pub struct Live(Status);"),
        ("request.rs", "pub struct Status;"),
        ("user.rs", "use crate::Status; struct U(Status); mod within { use super::*; struct V(Status); }"),
    ];
    assert_eq!(arrows(&files), ["live > request", "user > request"]);
}

#[test]
fn an_item_that_a_macro_makes_is_found_by_its_name() {
    let files = [
        ("lib.rs", "mod sets; mod status; mod user; pub use sets::*; pub use status::*;"),
        ("sets.rs", "kinds! { Question: Status(u8) -> Status, } kinds! { Order { Say = 1 } }"),
        ("status.rs", "pub struct Status;"),
        ("user.rs", "use crate::{Order, Question, Status}; struct U(Order, Question, Status);"),
    ];
    // A type that is known elsewhere is not the macro's, though the macro has the word.
    assert_eq!(arrows(&files), ["user > sets", "user > status"]);
    let by_rules = [
        ("lib.rs", "mod items; mod user;"),
        (
            "items.rs",
            "macro_rules! items { ($($kind:ident)*) => { pub enum Item { $($kind),* } } } items! { A B }",
        ),
        ("user.rs", "use crate::items::Item; struct U(Item);"),
    ];
    assert_eq!(arrows(&by_rules), ["user > items"]);
}

#[test]
fn a_face_that_defines_what_its_children_import_is_in_the_ring() {
    let hands_on = [
        ("lib.rs", "mod part; pub use part::Part; pub struct Whole;"),
        ("part.rs", "use crate::Whole; pub struct Part(Whole);"),
    ];
    assert_eq!((arrows(&hands_on), ring_count(&hands_on)), (vec!["part > lib".to_owned()], 0));
    let uses = [("lib.rs", "mod part; pub use part::Part; pub struct Whole(Box<Part>);"), hands_on[1]];
    assert_eq!(
        (arrows(&uses), ring_count(&uses)),
        (vec!["lib > part".to_owned(), "part > lib".to_owned()], 1)
    );
}

#[test]
fn globs_are_opened() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c;"),
        ("a.rs", "pub struct S; pub enum E { X }"),
        ("b.rs", "pub use crate::a::*; pub use super::c::*; pub struct T;"),
        ("c.rs", "use super::b::*; use crate::a::E::*; fn f(_: S, _: T, _: Vec<u8>) { X; }"),
    ];
    assert_eq!(arrows(&files), ["c > a", "c > b"]);
}

#[test]
fn tests_are_left_out() {
    let files = [
        ("lib.rs", "mod a; mod b; #[cfg(test)] mod tests;"),
        (
            "a.rs",
            "pub struct A; #[cfg(test)] use crate::b::B; #[cfg(test)] mod tests { use super::super::b::B; }",
        ),
        (
            "b.rs",
            "use crate::a::A; pub struct B(A); #[cfg(all(test, unix))] fn f() {} #[cfg(not(test))] fn g(_: crate::a::A) {}",
        ),
    ];
    assert_eq!((arrows(&files), ring_count(&files)), (vec!["b > a".to_owned()], 0));
}

#[test]
fn a_module_may_stand_where_its_attribute_says() {
    let files = [
        ("lib.rs", "#[path = \"elsewhere/named.rs\"] mod a; mod b;"),
        ("elsewhere/named.rs", "mod within; pub struct A;"),
        ("elsewhere/within.rs", "use super::A; struct W(A);"),
        ("b.rs", "use crate::a::A; struct B(A);"),
    ];
    assert_eq!(arrows(&files), ["b > elsewhere/named", "elsewhere/within > elsewhere/named"]);
}

#[test]
fn a_name_of_a_module_and_of_a_function_are_two() {
    let files = [
        ("lib.rs", "mod digest; mod user; pub use digest::digest;"),
        ("digest.rs", "pub fn digest() {} pub struct Digest;"),
        ("user.rs", "use crate::digest; fn f(_: digest::Digest) { digest(); let digest = 1; drop(digest); }"),
    ];
    assert_eq!(arrows(&files), ["user > digest"]);
}

#[test]
fn crates_of_others_are_noted_by_file() {
    let files = [
        ("lib.rs", "mod a; mod b; pub use other::Name;"),
        ("a.rs", "use std::fmt; fn f(_: other::Thing) -> fmt::Result { Ok(()) }"),
        ("b.rs", "use crate::Name; struct S(Name);"),
    ];
    let foreign: Vec<_> = read(&files).foreign.into_iter().filter(|(_, name)| name == "other").collect();
    let files: Vec<_> = foreign.iter().map(|(file, _)| file.display().to_string()).collect();
    assert_eq!(files, ["src/a.rs", "src/b.rs", "src/lib.rs"]);
}

#[test]
fn a_path_that_breaks_off_is_told() {
    let files = [("lib.rs", "mod a; mod b;"), ("a.rs", ""), ("b.rs", "\nuse crate::a::Missing;")];
    assert_eq!(read(&files).lost, ["src/b.rs:2: crate::a::Missing"]);
}

#[test]
fn an_import_from_above_is_told() {
    let storey = |name: &str, rooms: &[&str]| Storey {
        name: name.to_owned(),
        rooms: rooms.iter().map(|room| Path::new("src").join(room)).collect(),
    };
    let files = [
        ("lib.rs", "mod cycle; mod memory; mod nouns; mod stray;"),
        ("cycle/mod.rs", "pub mod step;"),
        ("cycle/step.rs", "use crate::memory::Memory; pub struct Frame(Memory);"),
        ("memory.rs", "use crate::nouns::N; pub struct Memory(N);"),
        ("nouns.rs", "\nuse crate::cycle::step::Frame;\npub struct N(Box<Frame>);"),
        ("stray.rs", "pub struct S;"),
    ];
    let imports = read(&files);
    let plan = [
        storey("cycle", &["cycle"]),
        storey("memory", &["memory.rs", "gone.rs"]),
        storey("nouns", &["nouns.rs"]),
    ];
    assert_eq!(
        storeys::problems(Path::new("src"), &plan, &[&imports]),
        [
            "src/stray.rs is in no storey: say in ARCHITECTURE.md which it belongs to",
            "storey memory names src/gone.rs, and there is no such file",
            "src/nouns.rs:2 (in nouns) takes Frame from src/cycle/step.rs (in cycle, which is above)",
        ]
    );
    // A file may be in another storey than its folder.
    let plan = [
        storey("cycle", &["cycle", "memory.rs", "stray.rs"]),
        storey("frames", &["cycle/step.rs"]),
        storey("nouns", &["nouns.rs"]),
    ];
    let problems = storeys::problems(Path::new("src"), &plan, &[&imports]);
    assert!(problems.iter().any(|problem| problem.contains("(in frames) takes Memory")), "{problems:?}");
}

#[test]
fn the_plan_is_read_from_the_page() {
    let page = "\
| crate | depends on | must never |
|---|---|---|
| `pschema-a` (`folder`) | nothing of ours | say `b` |
| `pschema-b` | `a`, and `c` for its names | |

| crate of others | named only in |
|---|---|
| `wire` | `b/src/wire/`, `b/src/lib.rs` |

```storeys
a/src
  top     x.rs y/
  ground  z.rs
```
";
    let plan = Plan::read(page);
    assert_eq!(plan.crates["pschema-b"], ["pschema-a", "pschema-c"].map(str::to_owned).into());
    assert!(plan.crates["pschema-a"].is_empty());
    assert_eq!(plan.named_only_in["wire"], ["b/src/wire/", "b/src/lib.rs"].map(PathBuf::from));
    let storeys = &plan.storeys[Path::new("a/src")];
    assert_eq!(storeys.len(), 2);
    assert_eq!(
        (&*storeys[0].name, &*storeys[0].rooms),
        ("top", &["a/src/x.rs", "a/src/y/"].map(PathBuf::from)[..])
    );
}
