//! `cargo xtask bench shaders`: what AMD's compiler makes of the shaders, without a GPU.
//!
//! Mesa's driver for AMD compiles for a GPU that is not there ([`compiler`]), and says what registers a
//! shader takes and prints its code, in which [`assembly`] finds loops. These are no times; but an
//! instruction of the innermost loop is one for every pixel of every splat, and registers limit how many
//! threads hide each other's waiting. [`record`] holds what they were when somebody last looked, and more is
//! a failure where the same driver is installed.

mod assembly;
mod compiler;
mod record;

use anyhow::{Result, ensure};

use super::recorded::{Record as _, Task, has_grown};
use super::table::{markdown, thousands};
use record::Counts;
pub(crate) use record::Record;
use xtask::workspace;

pub(super) fn run(task: Task) -> Result<()> {
    let Some(driver) = compiler::driver() else {
        eprintln!("shaders are not compiled: Mesa's Vulkan driver for AMD is not installed");
        return Ok(());
    };
    let now = compiler::count(workspace::root(), &driver)?;
    match task {
        Task::Record => now.write(),
        Task::Compare => compare(&Record::read()?, &now),
    }
}

/// An error if a shader takes more than is recorded.
fn compare(recorded: &Record, now: &Record) -> Result<()> {
    println!("{}\n\n{}", now.device, report(now));
    if recorded.device != now.device {
        eprintln!("they are not compared with what is recorded of {}", recorded.device);
        return Ok(());
    }
    let findings = findings(recorded, now);
    ensure!(
        findings.is_empty(),
        "{}\nif it must be, record the new counts by `cargo xtask bench shaders --record`",
        findings.join("\n"),
    );
    Ok(())
}

/// What makes the guard fail, a line each.
fn findings(recorded: &Record, now: &Record) -> Vec<String> {
    let grown = now.shaders.iter().flat_map(|(name, counts)| match recorded.shaders.get(name) {
        None => vec![format!("{name} is not recorded")],
        Some(was) => grown(name, was, counts),
    });
    let gone = recorded.shaders.keys().filter(|name| !now.shaders.contains_key(*name));
    grown.chain(gone.map(|name| format!("{name} is recorded and no longer there"))).collect()
}

fn grown(name: &str, was: &Counts, now: &Counts) -> Vec<String> {
    let of = |what: &str, was: u64, now: u64| {
        has_grown(was, now).then(|| format!("{name} takes {now} {what}, recorded are {was}"))
    };
    [
        of("instructions", was.instructions, now.instructions),
        of("instructions in its innermost loop", was.innermost_loop, now.innermost_loop),
        of("registers", was.registers, now.registers),
        of("bytes of workgroup memory", was.workgroup_bytes, now.workgroup_bytes),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn report(record: &Record) -> String {
    let head =
        ["shader", "innermost loop", "instructions", "registers", "workgroup bytes", "subgroups"];
    let row = |(name, counts): (&String, &Counts)| {
        let Counts { innermost_loop, instructions, registers, workgroup_bytes, subgroups } =
            *counts;
        let numbers = [innermost_loop, instructions, registers, workgroup_bytes, subgroups];
        std::iter::once(name.clone()).chain(numbers.map(thousands)).collect()
    };
    let rows: Vec<Vec<String>> = record.shaders.iter().map(row).collect();
    markdown(&head.map(str::to_owned), &rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(innermost_loop: u64, registers: u64) -> Record {
        let counts = Counts { innermost_loop, registers, ..Counts::default() };
        Record { device: "none".to_owned(), shaders: [("a".to_owned(), counts)].into() }
    }

    #[test]
    fn findings_from_five_percent_on() {
        let was = record(40, 64);
        assert_eq!(findings(&was, &record(42, 64)), Vec::<String>::new());
        let grown = findings(&was, &record(43, 72));
        let expected = ["a takes 43 instructions in its innermost loop, recorded are 40"];
        assert_eq!(grown[..1], expected);
        assert_eq!(grown[1], "a takes 72 registers, recorded are 64");
        let nothing = Record { device: "none".to_owned(), shaders: [].into() };
        assert_eq!(findings(&was, &nothing), ["a is recorded and no longer there"]);
        assert_eq!(findings(&nothing, &was), ["a is not recorded"]);
    }

    #[test]
    fn report_of_each_shader() {
        let text = report(&record(40, 64));
        assert!(text.ends_with("| a | 40 | 0 | 64 | 0 | 0 |\n"), "{text}");
    }
}
