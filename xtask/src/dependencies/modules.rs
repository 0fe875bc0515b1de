//! Floors within a crate: modules use only what lies below them, and no two files use each other.
//!
//! What a file uses is read off its paths that begin with `crate`, `super` or a module beside it; code of
//! tests may use anything.

use super::tables::{FLOORS, Floors};
use anyhow::{Context, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// A module by its path from the crate's root, which is empty, and the modules that it uses.
type Uses = BTreeMap<String, BTreeSet<String>>;

/// All violations in the workspace at `root`, one line each.
pub(super) fn check(root: &Path) -> Result<Vec<String>> {
    let mut violations = Vec::new();
    for floors in FLOORS {
        let sources = sources(&root.join(floors.folder), "")?;
        violations.extend(violations_in(floors, &uses(&sources)));
    }
    Ok(violations)
}

fn violations_in(floors: &Floors, uses: &Uses) -> Vec<String> {
    let mut violations: Vec<String> = uses
        .iter()
        .flat_map(|(module, used)| used.iter().map(move |used| (module, used)))
        .filter_map(|(module, used)| {
            let upwards = floors.floor_of(module)? < floors.floor_of(used)?;
            upwards.then(|| format!("`{module}` must not use `{used}`, which lies above it"))
        })
        .collect();
    violations.extend(uses.keys().filter_map(|module| {
        let circle = path_between(uses, module, module)?;
        // A circle is reported once, from its first module on.
        let is_first = circle.iter().all(|other| module <= other);
        is_first.then(|| format!("modules use each other in a circle: `{}`", circle.join("`, `")))
    }));
    let of = |violation| format!("{}: {violation}", floors.folder);
    violations.into_iter().map(of).collect()
}

impl Floors {
    /// Counted from the lowest one; `None` for the root, which only says what there is.
    fn floor_of(&self, module: &str) -> Option<usize> {
        let top = module.split("::").next()?;
        self.from_below.iter().position(|floor| floor.contains(&top))
    }
}

/// The modules on a way from one to another, without the last; the shortest, found by going ever further.
fn path_between(uses: &Uses, from: &str, to: &str) -> Option<Vec<String>> {
    let mut ways = vec![vec![from.to_owned()]];
    let mut seen = BTreeSet::new();
    while !ways.is_empty() {
        let mut longer = Vec::new();
        for way in ways {
            for next in uses.get(way.last()?).into_iter().flatten() {
                if next == to {
                    return Some(way);
                }
                if seen.insert(next.clone()) {
                    longer.push([way.clone(), vec![next.clone()]].concat());
                }
            }
        }
        ways = longer;
    }
    None
}

/// Modules and their text, but for those of tests.
fn sources(folder: &Path, module: &str) -> Result<BTreeMap<String, String>> {
    let mut sources = BTreeMap::new();
    for entry in fs::read_dir(folder).with_context(|| format!("cannot read {folder:?}"))? {
        let path = entry?.path();
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let within = |name: &str| [module, name].join("::").trim_start_matches(':').to_owned();
        if path.is_dir() {
            sources.extend(self::sources(&path, &within(&name))?);
        } else if name != "tests" {
            let of = if ["lib", "mod"].contains(&name.as_str()) {
                module.to_owned()
            } else {
                within(&name)
            };
            sources.insert(of, fs::read_to_string(&path)?);
        }
    }
    Ok(sources)
}

fn uses(sources: &BTreeMap<String, String>) -> Uses {
    let uses = |(module, text): (&String, &String)| {
        let used = paths(text).into_iter().filter_map(|path| target(sources, module, &path));
        (module.clone(), used.filter(|used| used != module).collect())
    };
    sources.iter().map(uses).collect()
}

/// The module that a path of `module` leads into, if it is one of ours.
fn target(sources: &BTreeMap<String, String>, module: &str, path: &str) -> Option<String> {
    let mut parts: Vec<&str> = module.split("::").filter(|part| !part.is_empty()).collect();
    let mut rest = path.split("::").peekable();
    match *rest.peek()? {
        "crate" => parts.clear(),
        "super" => drop(parts.pop()),
        // A module beside it is one below the folder's own.
        child => {
            let child = [&parts[..], &[child]].concat().join("::");
            sources.get(&child)?;
            return Some(child);
        }
    }
    for part in rest.skip(1) {
        let longer = [&parts[..], &[part]].concat();
        if !sources.contains_key(&longer.join("::")) {
            break;
        }
        parts = longer;
    }
    // What the root holds is for all to see.
    Some(parts.join("::")).filter(|target| !target.is_empty())
}

/// All paths of `use` lines, one for each name that they bring, and those that begin with `crate` anywhere.
fn paths(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = code.lines().map(str::trim_start).filter(|line| !line.starts_with("//"));
    let code = lines.collect::<Vec<_>>().join(" ");
    let mut paths = Vec::new();
    let statements = code.split(';').filter_map(|part| part.rsplit_once("use ").map(|(_, p)| p));
    statements.for_each(|statement| expand("", statement, &mut paths));
    for (at, _) in code.match_indices("crate::") {
        let is_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        let path = code[at..].split(|c| !is_path(c)).next().unwrap_or_default();
        paths.push(path.trim_end_matches(':').to_owned());
    }
    paths
}

/// Writes `a::{b, c::{d}}` as `a::b` and `a::c::d`.
fn expand(prefix: &str, tree: &str, paths: &mut Vec<String>) {
    let Some((before, group)) = tree.split_once('{') else {
        paths.push(format!("{prefix}{}", tree.trim()));
        return;
    };
    let prefix = format!("{prefix}{}", before.trim());
    let group = group.rsplit_once('}').map_or(group, |(group, _)| group);
    let (mut depth, mut start) = (0_usize, 0);
    for (at, c) in group.char_indices().chain([(group.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                let item = group[start..at].trim();
                if !item.is_empty() {
                    expand(&prefix, item, paths);
                }
                start = at + 1;
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO_FLOORS: Floors = Floors { folder: "src", from_below: &[&["low"], &["high"]] };

    fn check_sources(sources: &[(&str, &str)], expected: &[&str]) {
        let sources = sources.iter().map(|(module, text)| (module.to_string(), text.to_string()));
        let found = violations_in(&TWO_FLOORS, &uses(&sources.collect()));
        assert_eq!(found, expected);
    }

    #[test]
    fn floors_of_this_workspace() {
        let violations = check(xtask::workspace::root()).unwrap();
        assert!(violations.is_empty(), "{}", violations.join("\n"));
    }

    #[test]
    fn floors_upwards() {
        check_sources(
            &[("low", "use crate::high::{self, A};"), ("high", "use crate::low::B;")],
            &[
                "src: `low` must not use `high`, which lies above it",
                "src: modules use each other in a circle: `high`, `low`",
            ],
        );
        check_sources(
            &[("low::a", "fn f() { crate::high::g() }"), ("high", "")],
            &["src: `low::a` must not use `high`, which lies above it"],
        );
    }

    #[test]
    fn floors_circle_of_files() {
        check_sources(
            &[
                ("high", "mod a; mod b;"),
                ("high::a", "use super::b::{B, c::C};"),
                ("high::b", "use crate::{low, high::a::A};"),
                ("low", "// use crate::high::A;\n#[cfg(test)] mod tests { use crate::high::A; }"),
            ],
            &["src: modules use each other in a circle: `high::a`, `high::b`"],
        );
        check_sources(
            &[("high", "mod a;\nuse a::A;\nstruct B;"), ("high::a", "use super::B;")],
            &["src: modules use each other in a circle: `high`, `high::a`"],
        );
    }
}
