//! The guide's page of the whole crate, beside what is public at its root.

use std::collections::BTreeSet;
use std::path::Path;

const PAGE: &str = "../../docs/guide/src/api.md";

/// A file by its path from this crate.
fn text_of(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).expect("it is there")
}

/// What a `pub use` of this path, which may end in braces, brings in.
fn names_used(path: &str) -> Vec<String> {
    let list = path.split_once('{').map_or(path, |(_, list)| list.trim_end_matches('}'));
    let names = list.split(',').map(str::trim).filter(|name| !name.is_empty());
    names
        .map(|name| name.rsplit_once([' ', ':']).map_or(name, |(_, last)| last).to_owned())
        .collect()
}

/// What is public at the root of a crate, by its `lib.rs`; of all that it uses of another crate, `*`.
fn public_items(lib: &str) -> BTreeSet<String> {
    let is_code = |line: &&str| !line.starts_with("//") && !line.starts_with('#');
    let code: String = lib.lines().filter(is_code).collect();
    let items = code.split(';').filter_map(|statement| statement.trim().strip_prefix("pub "));
    items
        .flat_map(|item| match item.split_once(' ') {
            Some(("use", path)) => names_used(path),
            Some(("mod", name)) => vec![name.to_owned()],
            _ => panic!("the root has something else: {item}"),
        })
        .collect()
}

fn public_items_of_facade() -> BTreeSet<String> {
    let mut items = public_items(&text_of("src/lib.rs"));
    assert!(items.remove("*"), "all of the core is in the facade");
    items.extend(public_items(&text_of("../slabsplat-core/src/lib.rs")));
    items
}

fn features() -> BTreeSet<String> {
    let manifest = text_of("Cargo.toml");
    let (_, table) = manifest.split_once("[features]\n").expect("there are features");
    let (table, _) = table.split_once("\n[").expect("a table follows");
    let rows = table.lines().filter(|line| !line.starts_with('#'));
    let names = rows.filter_map(|line| line.split_once(" = ")).map(|(name, _)| name.to_owned());
    names.filter(|name| name != "default").collect()
}

/// What the lines of a list explain, in their order.
fn explained(page: &str) -> Vec<String> {
    let rows = page.lines().filter_map(|line| line.strip_prefix("- `")?.split_once("`: "));
    rows.map(|(name, _)| name.to_owned()).collect()
}

/// Both have the same names, and the list each of them once.
fn assert_lists(list: &[String], there: &BTreeSet<String>) {
    let listed: BTreeSet<String> = list.iter().cloned().collect();
    let missing: Vec<_> = there.difference(&listed).collect();
    let unknown: Vec<_> = listed.difference(there).collect();
    assert!(missing.is_empty() && unknown.is_empty(), "without {missing:?}, but {unknown:?}");
    assert_eq!(list.len(), listed.len(), "a name is there twice");
}

#[test]
fn page_has_what_is_public_and_nothing_else() {
    let page = text_of(PAGE);
    let (items, last) = page.split_once("\n## Features\n").unwrap();
    let n_rows = page.lines().filter(|line| line.starts_with('-')).count();
    assert_eq!(n_rows, explained(&page).len(), "a row is not of the form \"- `name`: clause\"");
    assert_lists(&explained(items), &public_items_of_facade());
    assert_lists(&explained(last), &features());
}

#[test]
fn public_items_are_found() {
    let lib = "//! pub use no::A;\nmod a;\npub mod b;\n#[cfg(x)]\npub use c::D;\n/// Of e.\n\
        pub use e as f;\npub use g::{\n    H, I,\n    J as K,\n};\npub use l::*;\npub use m;\n";
    let expected = ["b", "D", "f", "H", "I", "K", "*", "m"].map(str::to_owned);
    assert_eq!(public_items(lib), BTreeSet::from(expected));
}

#[test]
#[should_panic(expected = r#"without ["a"], but ["b"]"#)]
fn difference_is_told() {
    assert_lists(&["b".to_owned()], &BTreeSet::from(["a".to_owned()]));
}
