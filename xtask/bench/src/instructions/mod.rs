//! `cargo xtask bench instructions`: a guard against work that grows unnoticed.
//!
//! Times on a machine that does other things say little about a tenth more or less; instructions are the same
//! from run to run. `tests/tests/instructions.rs` renders small frames on one thread, [`valgrind`] counts
//! what each takes, and [`record`] holds what they took when somebody last looked.
//!
//! valgrind knows no AVX-512, so what is counted is what a machine with AVX2 would do.
//! Counts depend on the compiler too: a new one is a reason to record again, and the failure says so.

mod record;
mod valgrind;

use anyhow::{Result, ensure};

use super::recorded::{Record as _, Task, has_grown};
use super::table::{markdown, thousands};
use record::Counts;
pub(crate) use record::Record;
use xtask::workspace;

pub(super) fn run(task: Task) -> Result<()> {
    match task {
        Task::Record => Record::now(valgrind::count(workspace::root())?)?.write(),
        Task::Compare => compare(),
    }
}

/// An error if a frame takes more than is recorded.
fn compare() -> Result<()> {
    let recorded = Record::read()?;
    let (was, machine) = (&recorded.machine, record::machine());
    if *was != machine {
        eprintln!("instructions are not compared: they were recorded on {was}, this is {machine}");
        return Ok(());
    }
    let now = Record::now(valgrind::count(workspace::root())?)?;
    println!("{}", report(&recorded.counts, &now.counts));
    let findings = findings(&recorded.counts, &now.counts);
    ensure!(
        findings.is_empty(),
        "{}\n{}`callgrind_annotate` says more of the files in {}; \
         if it must be, record the new counts by `cargo xtask bench instructions --record`",
        findings.join("\n"),
        new_compiler(&recorded.rustc, &now.rustc),
        valgrind::profiles()?.display(),
    );
    Ok(())
}

/// A compiler that is not the recorded one may be the reason.
fn new_compiler(was: &str, now: &str) -> String {
    if was == now { String::new() } else { format!("recorded with {was}, this is {now}\n") }
}

/// What makes the guard fail, a line each.
fn findings(recorded: &Counts, now: &Counts) -> Vec<String> {
    let grown = now.iter().filter_map(|(name, &count)| match recorded.get(name) {
        None => Some(format!("{name} is not recorded")),
        Some(&was) if has_grown(was, count) => {
            let [count_text, was_text] = [count, was].map(thousands);
            let change = change(was, count);
            Some(format!("{name} takes {count_text} instructions, {change} on {was_text}"))
        }
        Some(_) => None,
    });
    let gone = recorded.keys().filter(|name| !now.contains_key(*name));
    grown.chain(gone.map(|name| format!("{name} is recorded and no longer there"))).collect()
}

fn report(recorded: &Counts, now: &Counts) -> String {
    let head = ["frame", "instructions", "recorded", "change"].map(str::to_owned);
    let row = |(name, &count): (&String, &u64)| {
        let was = recorded.get(name);
        let [was, change] = match was {
            Some(&was) => [thousands(was), change(was, count)],
            None => ["-", "-"].map(str::to_owned),
        };
        vec![name.clone(), thousands(count), was, change]
    };
    markdown(&head, &now.iter().map(row).collect::<Vec<_>>())
}

fn change(was: u64, count: u64) -> String {
    format!("{:+.1} %", 100.0 * (count as f64 / was as f64 - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(counts: &[(&str, u64)]) -> Counts {
        counts.iter().map(|&(name, count)| (name.to_owned(), count)).collect()
    }

    #[test]
    fn findings_from_five_percent_on() {
        let recorded = counts(&[("haze", 1000), ("toss", 1000)]);
        let check = |now: &[(&str, u64)], expected: &[&str]| {
            assert_eq!(findings(&recorded, &counts(now)), expected, "{now:?}");
        };
        check(&[("haze", 1050), ("toss", 10)], &[]);
        let grown = "haze takes 1,051 instructions, +5.1 % on 1,000";
        check(&[("haze", 1051), ("toss", 1000)], &[grown]);
        let gone = "toss is recorded and no longer there";
        check(&[("haze", 1000), ("new", 1)], &["new is not recorded", gone]);
    }

    #[test]
    fn report_of_each_frame() {
        let text = report(&counts(&[("haze", 2000)]), &counts(&[("haze", 1000), ("new", 1)]));
        assert!(text.contains("| haze | 1,000 | 2,000 | -50.0 % |\n"), "{text}");
        assert!(text.contains("| new | 1 | - | - |\n"), "{text}");
    }
}
