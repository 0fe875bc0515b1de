//! What can be chosen is said where one looks for it: in the help, and in `docs/example.toml`.

use crate::answer;
use slabsplat::{BACKEND_NAMES, Field, KERNEL_NAMES, Phong, RenderSettings, Setting, Settings};
use std::path::Path;

const EXAMPLE: &str = include_str!("../../../../docs/example.toml");

#[test]
fn help_names_every_setting() {
    let help = answer(Path::new("."), "render --help");
    // Lines break wherever the terminal ends.
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    check_help::<RenderSettings>(&help);
    check_help::<Phong>(&help);
    for name in BACKEND_NAMES {
        assert!(help.contains(name), "{name} is not in:\n{help}");
    }
}

fn check_help<S: Settings>(help: &str) {
    for row in S::ROWS {
        let flag = format!("--{} <", row.name.replace('_', "-"));
        let default = format!("[default: {}]", row.text(&S::default()));
        let choices = choices(row).iter().copied();
        for expected in choices.chain([flag.as_str(), default.as_str()]) {
            assert!(help.contains(expected), "{expected} is not in:\n{help}");
        }
    }
}

/// The example is copied from the tables: `docs/example.toml` has to hold what this test prints.
#[test]
fn example_has_every_setting() {
    check_example::<Phong>();
    check_example::<RenderSettings>();
    for name in BACKEND_NAMES {
        assert!(EXAMPLE.contains(name), "{name}");
    }
}

fn check_example<S: Settings>() {
    let lines: String = S::ROWS.iter().map(example_lines).collect();
    assert!(EXAMPLE.contains(&lines), "docs/example.toml should contain:\n{lines}");
}

/// What a setting is, its default, and what it may be.
fn example_lines<S: Settings>(row: &Setting<S>) -> String {
    let default = row.text(&S::default());
    let value = match &row.field {
        Field::Choice { .. } | Field::Kernel(_) => format!("{default:?}"),
        Field::Number { .. } | Field::Count { .. } | Field::Switch(_) => default,
    };
    let permitted = match &row.field {
        Field::Choice { .. } | Field::Kernel(_) => format!("  # {}", choices(row).join(", ")),
        Field::Number { range, .. } | Field::Count { range, .. } => format!("  # {range}"),
        Field::Switch(_) => String::new(),
    };
    format!("# {}\n{} = {value}{permitted}\n", row.help, row.name)
}

fn choices<S>(row: &Setting<S>) -> &'static [&'static str] {
    match row.field {
        Field::Choice { names, .. } => names,
        Field::Kernel(_) => KERNEL_NAMES,
        Field::Number { .. } | Field::Count { .. } | Field::Switch(_) => &[],
    }
}
